//! Real arms: fitted on one placement, scored on another.

use std::path::Path;

use super::{data, errors, json, stderr, stdout, touchcal};

/// Writes `sockets/problem.toml` for the logs of a real arm into a folder; returns its name there.
fn sockets(folder: &Path, logs: &Path, urdf: &Path, more: &[&str]) -> &'static str {
    let [logs, urdf] = [logs, urdf].map(|path| path.to_str().unwrap());
    let args = ["new", "sockets", "--from", logs, "--urdf", urdf, "--out", "sockets"];
    touchcal(folder, &[&args[..], more].concat()).success();
    "sockets/problem.toml"
}

#[test]
fn kuka_fitted_in_front_is_right_on_the_left() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    let problem = sockets(folder.path(), &mukca.join("kuka_14"), &mukca.join("iiwa14.urdf"), &[]);
    let args = ["calibrate", problem, "--only", "front", "--out", "out"];
    let done = touchcal(folder.path(), &args).success();
    assert_eq!(errors(&done), "");
    assert!(stdout(&done).contains("--except front --urdf out/calibrated.urdf"), "{}", stdout(&done));
    let estimate = json(&folder.path().join("out/estimate.json"));
    assert_eq!(estimate["status"], "usable");

    let args = ["evaluate", problem, "--only", "left_back", "--urdf", "out/calibrated.urdf", "--json"];
    let done = touchcal(folder.path(), &args).success();
    assert_eq!(errors(&done), "");
    let score: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    let mean = |scores: &serde_json::Value| scores["mean_mm"].as_f64().unwrap();
    assert!(mean(&score) <= 0.15 && mean(&score["nominal"]) > 0.5, "{score}");
}

/// With two joints exchanged contacts scatter by decimetres: that is no noise, though none is
/// declared.
#[test]
fn learned_noise_has_a_bound() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    for log in ["front/hole_0.csv", "front/hole_1.csv"] {
        let text = std::fs::read_to_string(mukca.join("kuka_14").join(log)).unwrap();
        let exchanged = text.lines().map(|row| {
            let mut columns: Vec<&str> = row.split(',').collect();
            columns.swap(2, 3);
            columns.join(",") + "\n"
        });
        std::fs::create_dir_all(folder.path().join("logs/front")).unwrap();
        std::fs::write(folder.path().join("logs").join(log), exchanged.collect::<String>()).unwrap();
    }
    let problem = sockets(folder.path(), &folder.path().join("logs"), &mukca.join("iiwa14.urdf"), &[]);
    touchcal(folder.path(), &["calibrate", problem, "--out", "out"]).code(3);
    let estimate = json(&folder.path().join("out/estimate.json"));
    let warnings = estimate["warnings"].as_array().unwrap();
    let found = warnings.iter().find(|warning| warning["kind"] == "noise_contradicted");
    let message = found.unwrap_or_else(|| panic!("{estimate}"))["message"].as_str().unwrap();
    assert!(message.contains("times more than the assumed noise"), "{message}");
    assert!(warnings.iter().any(|warning| warning["kind"] == "mistaken_declaration"), "{warnings:?}");
}

/// The fitted placement itself scores through the URDF alone as in the estimate: the tool's place
/// is in it.
#[test]
fn calibrated_urdf_carries_the_tool() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    let problem = sockets(folder.path(), &mukca.join("panda_3"), &mukca.join("panda.urdf"), &[]);
    touchcal(folder.path(), &["calibrate", problem, "--out", "."]).success();
    let args = ["evaluate", problem, "--urdf", "calibrated.urdf", "--json"];
    let score: serde_json::Value = serde_json::from_str(&stdout(&touchcal(folder.path(), &args).success())).unwrap();
    let postfit = json(&folder.path().join("estimate.json"))["residuals"]["postfit"]["mean_mm"].as_f64().unwrap();
    // Drifts between placements are not in the URDF.
    assert!((score["mean_mm"].as_f64().unwrap() - postfit).abs() < 2e-3, "{score}");
}

/// Where the URDF branches, the message says where, and `--tip` which link carries the ball.
#[test]
fn the_tip_of_a_urdf_that_branches_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().join("mukca");
    let logs = mukca.join("panda_3");
    let finger = "<link name=\"finger\"/><joint name=\"finger_joint\" type=\"fixed\">\
                  <parent link=\"panda_hand\"/><child link=\"finger\"/></joint></robot>";
    let urdf = std::fs::read_to_string(mukca.join("panda.urdf")).unwrap().replace("</robot>", finger);
    std::fs::write(folder.path().join("gripper.urdf"), urdf).unwrap();
    let args = ["new", "sockets", "--from", logs.to_str().unwrap(), "--urdf", "gripper.urdf"];
    let said = stderr(&touchcal(folder.path(), &args).code(1));
    assert!(
        said.contains("`ball_link` or `finger`, which branch at `panda_hand`; choose one of these as `tip`"),
        "{said}"
    );
    assert!(!folder.path().join("sockets").exists());
    let problem = sockets(folder.path(), &logs, &folder.path().join("gripper.urdf"), &["--tip", "ball_link"]);
    touchcal(folder.path(), &["inspect", problem, "--only", "backleft"]).success();
    touchcal(folder.path(), &["evaluate", problem, "--only", "backleft", "--urdf", "gripper.urdf"]).success();
    // What was filled in is not overwritten.
    touchcal(folder.path(), &[&args[..], &["--tip", "ball_link"]].concat()).code(1);
}

/// An arm that bends scores through its URDF as in the estimate, and the user is told who reads it.
#[test]
fn calibrated_urdf_carries_the_compliance() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    let urdf = mukca.join("iiwa14.urdf");
    let problem = sockets(folder.path(), &mukca.join("kuka_14"), &urdf, &["--joint-compliance"]);
    let done = touchcal(folder.path(), &["calibrate", problem, "--only", "front", "--out", "."]).success();
    assert!(stdout(&done).contains("only touchcal reads joint compliance"), "{}", stdout(&done));
    let estimate = json(&folder.path().join("estimate.json"));
    let entry = |entry: &&serde_json::Value| entry["name"] == "joint_compliance.joint_a2";
    assert_eq!(estimate["parameters"].as_array().unwrap().iter().find(entry).unwrap()["unit"], "rad/(N m)");
    let kinds = estimate["warnings"].as_array().unwrap();
    assert!(kinds.iter().any(|warning| warning["kind"] == "compliance_in_robot"), "{kinds:?}");
    // What other programs need to apply it lies beside.
    assert!(stdout(&done).contains("correction.json, which corrects joint positions"), "{}", stdout(&done));
    let correction = json(&folder.path().join("correction.json"));
    assert_eq!(correction["status"], estimate["status"]);
    let found = &correction["joints"][1];
    let value = |name: &str| {
        let entries = estimate["parameters"].as_array().unwrap();
        entries.iter().find(|entry| entry["name"] == name).unwrap()["value"].as_f64().unwrap()
    };
    let compliance = found["compliance_rad_per_nm"].as_f64().unwrap();
    assert!((compliance - value("joint_compliance.joint_a2")).abs() < 1e-15, "{found}");
    assert_eq!((&found["name"], &found["harmonics"]), (&"joint_a2".into(), &serde_json::json!([])));
    let listed = json(&folder.path().join("touchcal.json"));
    assert!(listed["results"]["calibration"]["files"]["correction.json"].is_string(), "{listed}");

    let score = |placement: &str, urdf: &str| {
        let args = ["evaluate", problem, "--only", placement, "--urdf", urdf, "--json"];
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

/// The options that a problem file replaced answer with the commands that replace them.
#[test]
fn replaced_options_show_what_replaces_them() {
    let folder = tempfile::tempdir().unwrap();
    let replaced = |args: &[&str], parts: &[&str]| {
        let text = stderr(&touchcal(folder.path(), args).code(2));
        for part in parts {
            assert!(text.contains(part), "expected `{part}` in: {text}");
        }
    };
    let source = ["--mukca", "logs", "--urdf", "arm.urdf", "--only", "front", "--tip", "ball", "--spacing-mm", "40"];
    let new = "touchcal new sockets --from logs --urdf arm.urdf --tip ball --spacing-mm 40 --out sockets";
    replaced(
        &[&["calibrate", "--out", "out"], &source[..]].concat(),
        &["--mukca was replaced", new, "touchcal calibrate sockets/problem.toml --only front --out out"],
    );
    replaced(&[&["inspect"], &source[..]].concat(), &[new, "touchcal inspect sockets/problem.toml --only front"]);
    replaced(
        &["evaluate", "--mukca", "logs", "--urdf", "c.urdf", "--nominal", "arm.urdf", "--except", "front"],
        &["--from logs --urdf arm.urdf", "touchcal evaluate sockets/problem.toml --except front --urdf c.urdf"],
    );
    replaced(&["calibrate", "--mukca", "logs", "--out", "out"], &["--from logs --urdf FILE"]);
    replaced(&["new", "planes", "--from", "logs", "--urdf", "arm.urdf"], &["touchcal new sockets --from"]);
}
