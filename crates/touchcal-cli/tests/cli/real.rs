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

/// The fitted placement itself scores through the URDF alone as in the estimate: the tool's place is in it.
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
