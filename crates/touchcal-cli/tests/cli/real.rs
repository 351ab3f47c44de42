//! Real arms: fitted on one placement, scored on another.

use super::{data, json, stderr, stdout, touchcal};

#[test]
fn kuka_fitted_in_front_is_right_on_the_left() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    let (logs, urdf) = (mukca.join("kuka_14"), mukca.join("iiwa14.urdf"));
    let (logs, urdf) = (logs.to_str().unwrap(), urdf.to_str().unwrap());
    let args = ["calibrate", "--mukca", logs, "--only", "front", "--urdf", urdf, "--out", "out"];
    let done = touchcal(folder.path(), &args).success();
    assert_eq!(stderr(&done), "");
    assert!(stdout(&done).contains("--except front --urdf out/calibrated.urdf"), "{}", stdout(&done));
    let estimate = json(&folder.path().join("out/estimate.json"));
    assert_eq!(estimate["status"], "converged");

    let args = ["evaluate", "--mukca", logs, "--only", "left_back", "--urdf", "out/calibrated.urdf"];
    let done = touchcal(folder.path(), &[&args[..], &["--nominal", urdf, "--json"]].concat()).success();
    let score: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    let mean = |scores: &serde_json::Value| scores["mean_mm"].as_f64().unwrap();
    assert!(mean(&score) <= 0.15 && mean(&score["nominal"]) > 0.5, "{score}");
}

/// The fitted placement itself scores through the URDF alone as in the estimate: the tool's place
/// is in it.
#[test]
fn calibrated_urdf_carries_the_tool() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    let (logs, urdf) = (mukca.join("panda_3"), mukca.join("panda.urdf"));
    let (logs, urdf) = (logs.to_str().unwrap(), urdf.to_str().unwrap());
    touchcal(folder.path(), &["calibrate", "--mukca", logs, "--urdf", urdf, "--out", "."]).success();
    let args = ["evaluate", "--mukca", logs, "--urdf", "calibrated.urdf", "--json"];
    let score: serde_json::Value = serde_json::from_str(&stdout(&touchcal(folder.path(), &args).success())).unwrap();
    let postfit = json(&folder.path().join("estimate.json"))["residuals"]["postfit"]["mean_mm"].as_f64().unwrap();
    // Drifts between placements are not in the URDF.
    assert!((score["mean_mm"].as_f64().unwrap() - postfit).abs() < 2e-3, "{score}");
}

/// Where the URDF branches, the message says where, and `--tip` which link carries the ball.
#[test]
fn the_tip_of_a_urdf_that_branches_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    let logs = mukca.join("panda_3");
    let finger = "<link name=\"finger\"/><joint name=\"finger_joint\" type=\"fixed\">\
                  <parent link=\"panda_hand\"/><child link=\"finger\"/></joint></robot>";
    let urdf = std::fs::read_to_string(mukca.join("panda.urdf")).unwrap().replace("</robot>", finger);
    std::fs::write(folder.path().join("gripper.urdf"), urdf).unwrap();
    let args = ["--mukca", logs.to_str().unwrap(), "--only", "backleft", "--urdf", "gripper.urdf"];
    let asked = |command: &str, more: &[&str]| touchcal(folder.path(), &[&[command], &args[..], more].concat());
    let said = stderr(&asked("inspect", &[]).code(1));
    assert!(
        said.contains("`ball_link` or `finger`, which branch at `panda_hand`; choose one of these as `tip`"),
        "{said}"
    );
    asked("inspect", &["--tip", "ball_link"]).success();
    asked("evaluate", &["--tip", "ball_link"]).success();
    touchcal(folder.path(), &["inspect", "problem.toml", "--tip", "ball_link"]).code(2);
}

/// An arm that bends scores through its URDF as in the estimate, and the user is told who reads it.
#[test]
fn calibrated_urdf_carries_the_compliance() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    let (logs, urdf) = (mukca.join("kuka_14"), mukca.join("iiwa14.urdf"));
    let (logs, urdf) = (logs.to_str().unwrap(), urdf.to_str().unwrap());
    let args = ["calibrate", "--mukca", logs, "--only", "front", "--urdf", urdf, "--joint-compliance", "--out", "."];
    let done = touchcal(folder.path(), &args).success();
    assert!(stdout(&done).contains("only touchcal reads the joints' compliance"), "{}", stdout(&done));
    let estimate = json(&folder.path().join("estimate.json"));
    let entry = |entry: &&serde_json::Value| entry["name"] == "joint_compliance.joint_a2";
    assert_eq!(estimate["parameters"].as_array().unwrap().iter().find(entry).unwrap()["unit"], "rad/(N m)");
    assert_eq!(estimate["warnings"][0]["kind"], "compliance_needs_driver");

    let score = |placement: &str, urdf: &str| {
        let args = ["evaluate", "--mukca", logs, "--only", placement, "--urdf", urdf, "--json"];
        let done = touchcal(folder.path(), &args).success();
        serde_json::from_str::<serde_json::Value>(&stdout(&done)).unwrap()["mean_mm"].as_f64().unwrap()
    };
    let postfit = estimate["residuals"]["postfit"]["mean_mm"].as_f64().unwrap();
    // The kilogram assumed at the tip moves with the ball's place.
    assert!((score("front", "calibrated.urdf") - postfit).abs() < 1e-3);
    let held_out = score("left_back", "calibrated.urdf");
    assert!(held_out <= 0.1, "{held_out}");

    let text = std::fs::read_to_string(folder.path().join("calibrated.urdf")).unwrap();
    let rigid: String = text.split_inclusive('\n').filter(|line| !line.contains("touchcal_compliance")).collect();
    std::fs::write(folder.path().join("rigid.urdf"), rigid).unwrap();
    assert!(score("left_back", "rigid.urdf") > 1.5 * held_out);
}
