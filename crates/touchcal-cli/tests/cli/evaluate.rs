//! `evaluate`: what is found beside what the calibration predicts.

use std::path::Path;

use super::golden::golden;
use super::{stderr, stdout, touchcal};

/// Sockets of one arm, recorded for its calibration in `fit` and once more in `check`.
fn recorded_twice(folder: &Path) {
    for (noise_seed, out) in [("1", "fit"), ("2", "check")] {
        let args = ["simulate", "--preset", "mukca", "--contacts", "30", "--seed", "1", "--noise-seed", noise_seed];
        touchcal(folder, &[&args[..], &["--out", out]].concat()).success();
    }
}

/// Writes the problem of a folder with other spacings (mm); returns its path.
fn with_spacing(folder: &Path, name: &str, mm: &str) -> String {
    let text = std::fs::read_to_string(folder.join(name).join("problem.toml")).unwrap();
    assert!(text.contains("\nmm = 50\nsigma_mm = 0.01\n"), "{text}");
    let path = format!("{name}/spacing_{mm}.toml");
    let spaced = text.replace("\nmm = 50\nsigma_mm = 0.01\n", &format!("\nmm = {mm}\nsigma_mm = 0.05\n"));
    std::fs::write(folder.join(&path), spaced).unwrap();
    path
}

fn evaluated(folder: &Path, problem: &str, more: &[&str]) -> serde_json::Value {
    let args = ["evaluate", problem, "--urdf", "out/calibrated.urdf", "--json"];
    serde_json::from_str(&stdout(&touchcal(folder, &[&args[..], more].concat()).success())).unwrap()
}

const ESTIMATE: [&str; 2] = ["--estimate", "out/estimate.json"];

#[test]
fn held_out_contacts_are_as_the_calibration_predicts() {
    let folder = tempfile::tempdir().unwrap();
    recorded_twice(folder.path());
    touchcal(folder.path(), &["calibrate", "fit/problem.toml", "--out", "out"]).success();
    let args = ["evaluate", "check/problem.toml", "--urdf", "out/calibrated.urdf"];
    golden("evaluate_held_out.txt", &stdout(&touchcal(folder.path(), &[&args[..], &ESTIMATE].concat()).success()));
    let found = evaluated(folder.path(), "check/problem.toml", &ESTIMATE);
    assert!((found["scatter"]["all"]["ratio"].as_f64().unwrap() - 1.0).abs() < 0.1, "{found}");
    assert_eq!(found["scatter"]["per_fixture"].as_object().unwrap().len(), 6);
    assert_eq!(found["distances"].as_array().unwrap().len(), 3);
    assert_eq!(found["warnings"], serde_json::json!([]));
}

/// A spacing of 50 mm that was declared 50.3 mm when the arm was calibrated is seen by an
/// evaluation that declares it right, and by its distances alone.
#[test]
fn a_wrong_spacing_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    recorded_twice(folder.path());
    let [wrong, right] = [("fit", "50.3"), ("check", "50")].map(|(name, mm)| with_spacing(folder.path(), name, mm));
    touchcal(folder.path(), &["calibrate", &wrong, "--out", "out"]).success();
    let found = evaluated(folder.path(), &right, &ESTIMATE);
    for distance in found["distances"].as_array().unwrap() {
        assert!(distance["deviations"].as_f64().unwrap() > 3.0, "{distance}");
    }
    assert_eq!(found["warnings"][0]["kind"], "common_strain", "{found}");
    let scatter = &found["scatter"]["all"];
    assert!(scatter["ratio"].as_f64() < scatter["by_chance"][1].as_f64(), "{scatter}");
    let args = ["evaluate", &right, "--urdf", "out/calibrated.urdf"];
    let shown = stdout(&touchcal(folder.path(), &[&args[..], &ESTIMATE].concat()).success());
    assert!(
        shown.contains("Warning   all distances of fixtures are") && shown.contains("check their units"),
        "{shown}"
    );
    // An evaluation without the calibration's covariance compares, and contradicts nothing.
    let alone = evaluated(folder.path(), &right, &[]);
    assert_eq!(alone["distances"].as_array().unwrap().len(), 3);
    assert_eq!(alone["warnings"], serde_json::json!([]));
}

#[test]
fn a_calibration_that_is_not_usable_stays_so() {
    let folder = tempfile::tempdir().unwrap();
    recorded_twice(folder.path());
    let in_centimetres = with_spacing(folder.path(), "fit", "5");
    touchcal(folder.path(), &["calibrate", &in_centimetres, "--out", "out"]).code(3);
    let args = ["evaluate", "check/problem.toml", "--urdf", "out/calibrated.urdf"];
    touchcal(folder.path(), &args).success();
    let done = touchcal(folder.path(), &[&args[..], &ESTIMATE].concat()).code(3);
    let said = stderr(&done);
    assert!(said.contains("the calibration of out/estimate.json is not usable: do not use it"), "{said}");
    assert!(stdout(&done).contains("found/predicted"), "{}", stdout(&done));
}
