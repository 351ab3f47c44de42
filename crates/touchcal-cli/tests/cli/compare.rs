//! `compare`: two calibrations of one arm, and of arms that changed.

use std::path::Path;

use super::{stderr, stdout, touchcal};

/// The arm of a seed, recorded with the noise of another and calibrated into a folder.
fn calibrate(folder: &Path, seed: &str, noise_seed: &str, out: &str) {
    let logs = format!("{out}_logs");
    let args = ["simulate", "--preset", "mukca", "--contacts", "60", "--seed", seed, "--noise-seed", noise_seed];
    touchcal(folder, &[&args[..], &["--out", &logs]].concat()).success();
    touchcal(folder, &["calibrate", &format!("{logs}/problem.toml"), "--out", out]).success();
}

fn compared(folder: &Path, both: [&str; 2]) -> serde_json::Value {
    let text = stdout(&touchcal(folder, &["compare", both[0], both[1], "--json"]).success());
    serde_json::from_str(&text).unwrap()
}

#[test]
fn an_arm_that_changed_is_told_from_one_that_did_not() {
    let folder = tempfile::tempdir().unwrap();
    calibrate(folder.path(), "1", "1", "monday");
    calibrate(folder.path(), "1", "2", "tuesday");
    calibrate(folder.path(), "2", "3", "other");
    let same = compared(folder.path(), ["monday", "tuesday"]);
    assert!(same["arm"]["p_value"].as_f64().unwrap() > 0.01, "{same}");
    assert!(same["tool"]["p_value"].as_f64().unwrap() > 0.01, "{same}");
    assert_eq!(same["common_logs"].as_array().unwrap().len(), 0);
    let other = compared(folder.path(), ["monday", "other"]);
    assert!(other["arm"]["p_value"].as_f64().unwrap() < 1e-9, "{other}");
    // The same parameters as in the files.
    let change = &other["arm"]["parameters"][0];
    for (key, out) in [("earlier", "monday"), ("later", "other")] {
        let file = super::json(&folder.path().join(out).join("estimate.json"));
        let entry = file["parameters"].as_array().unwrap().iter().find(|entry| entry["name"] == change["name"]);
        assert_eq!(entry.unwrap()["value"], change[key]);
        assert_eq!(file["created"].as_str().unwrap().len(), "2026-11-24T09:30:00Z".len());
    }
    // What both calibrations say of the tip agrees with how far apart they are.
    let moved = |found: &serde_json::Value| found["tip_motion"]["distance_mm"]["rms"].as_f64().unwrap();
    let expected = super::json(&folder.path().join("monday/estimate.json"))["workspace_uncertainty"]["distance_mm"]
        .as_f64()
        .unwrap();
    assert!(moved(&same) < 3.0 * expected && moved(&other) > 10.0 * expected, "{same} {other} {expected}");
    let words = |both: [&str; 2]| stdout(&touchcal(folder.path(), &["compare", both[0], both[1]]).success());
    assert!(words(["monday", "tuesday"]).starts_with("Arm       no change beyond the uncertainties (p = 0."));
    assert!(words(["monday", "other"]).starts_with("Arm       CHANGED by more than the uncertainties explain"));
    assert!(words(["monday", "monday"]).contains("both calibrations read monday_logs/front_0.csv"));
}

#[test]
fn calibrations_of_other_robots_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    calibrate(folder.path(), "1", "1", "iiwa");
    // The same joints by name, one of them a millimetre elsewhere.
    let path = folder.path().join("iiwa_logs/problem.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("builtin = \"iiwa14\""), "{text}");
    std::fs::copy(folder.path().join("iiwa/calibrated.urdf"), folder.path().join("iiwa_logs/other.urdf")).unwrap();
    std::fs::write(&path, text.replace("builtin = \"iiwa14\"", "urdf = \"other.urdf\"")).unwrap();
    touchcal(folder.path(), &["calibrate", "iiwa_logs/problem.toml", "--out", "other"]).success();
    let refused = stderr(&touchcal(folder.path(), &["compare", "iiwa", "other"]).code(1));
    assert!(refused.contains("other, robot: expected a calibration of the robot"), "{refused}");
    let args = ["evaluate", "iiwa_logs/problem.toml", "--urdf", "iiwa/calibrated.urdf", "--estimate"];
    let refused = stderr(&touchcal(folder.path(), &[&args[..], &["iiwa/estimate.json"]].concat()).code(1));
    assert!(refused.contains("iiwa/estimate.json, robot: expected a calibration of the robot"), "{refused}");
    touchcal(folder.path(), &[&args[..], &["other/estimate.json"]].concat()).success();
    // No calibration at all.
    let refused = stderr(&touchcal(folder.path(), &["compare", "iiwa", "iiwa_logs"]).code(1));
    assert!(refused.contains("iiwa_logs/estimate.json: could not open"), "{refused}");
}

/// Compliances under measured torques are others than those under gravity and load.
#[test]
fn compliances_under_other_torques_are_noted() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let scenario = "preset = \"mukca\"\ncontacts = 60\n[errors]\njoint_compliance_rad_per_nm = 1e-5\n";
    std::fs::write(at("scenario.toml"), scenario).unwrap();
    touchcal(folder.path(), &["simulate", "scenario.toml", "--seed", "1", "--out", "sim"]).success();
    touchcal(folder.path(), &["calibrate", "sim/problem.toml", "--out", "gravity"]).success();
    // The same as if it were made from measured torques; without a manifest it is not checked.
    std::fs::create_dir(at("measured")).unwrap();
    std::fs::copy(at("gravity/estimate.json"), at("measured/estimate.json")).unwrap();
    let urdf = std::fs::read_to_string(at("gravity/calibrated.urdf")).unwrap();
    let measured: Vec<String> = urdf
        .lines()
        .map(|line| match line.contains("<touchcal_compliance ") {
            true => line.replace("/>", " torque=\"measured\"/>"),
            false => line.to_owned(),
        })
        .collect();
    std::fs::write(at("measured/calibrated.urdf"), measured.join("\n")).unwrap();
    let note = "one calibration has compliances and backlashes under measured joint torques";
    let said = |both: [&str; 2]| {
        let done = touchcal(folder.path(), &["compare", both[0], both[1]]).success();
        stdout(&done).replace("\n          ", " ")
    };
    assert!(said(["gravity", "measured"]).contains(note), "{}", said(["gravity", "measured"]));
    assert!(said(["measured", "gravity"]).contains("calibrate both with `tau_joint`, or both without"));
    assert!(!said(["gravity", "gravity"]).contains(note) && !said(["measured", "measured"]).contains(note));
}
