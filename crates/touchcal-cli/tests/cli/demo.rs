//! The demonstration, and its example calibrated again.

use std::path::Path;

use super::{errors, json, stdout, touchcal};

const FILES: [&str; 8] = [
    "problem.toml",
    "scenario.toml",
    "hole.csv",
    "truth.json",
    "true.urdf",
    "calibrated.urdf",
    "estimate.json",
    "report.html",
];

/// The file's lines but those that tell when it was made and the time taken.
fn timeless(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let is_timeless = |line: &&str| !["\"seconds\"", "\"created\""].iter().any(|key| line.contains(key));
    text.lines().filter(is_timeless).collect::<Vec<_>>().join("\n")
}

#[test]
fn demo_finds_the_truth_and_its_example_gives_the_same_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join("touchcal-demo").join(name);
    let done = touchcal(folder.path(), &["demo"]).success();
    assert_eq!(errors(&done), "", "quiet where stderr is no terminal");
    let text = stdout(&done);
    assert!(text.contains("joint_offset.joint_a7") && text.contains("at 100 other poses"), "{text}");
    let (estimate, truth) = (json(&at("estimate.json")), json(&at("truth.json")));
    assert_eq!(estimate["status"], "usable");
    let value = |k: usize| estimate["parameters"][k]["value"].as_f64().unwrap();
    assert!((value(0) - truth["parameters"]["strain"].as_f64().unwrap()).abs() < 1e-3);
    let truth = |k: usize| truth["parameters"][estimate["parameters"][k]["name"].as_str().unwrap()].as_f64().unwrap();
    let mean = ((1..8).map(|k| (value(k) - truth(k)).abs()).sum::<f64>() / 7.0).to_degrees();
    assert!(mean < 0.02, "mean offset error {mean} deg");

    assert!(!at("correction.json").exists(), "the URDF says all about joint positions");
    let first = FILES.map(|name| timeless(&at(name)));
    touchcal(folder.path(), &["demo"]).success();
    assert_eq!(first, FILES.map(|name| timeless(&at(name))), "the same bytes again");

    touchcal(folder.path(), &["calibrate", "touchcal-demo/problem.toml", "--out", "again"]).success();
    for name in ["calibrated.urdf", "estimate.json", "report.html"] {
        assert_eq!(timeless(&folder.path().join("again").join(name)), timeless(&at(name)), "{name}");
    }
    let score = ["evaluate", "touchcal-demo/problem.toml", "--urdf", "again/calibrated.urdf", "--json"];
    let score: serde_json::Value = serde_json::from_str(&stdout(&touchcal(folder.path(), &score).success())).unwrap();
    assert!(score["mean_mm"].as_f64() < Some(0.05) && score["nominal"]["mean_mm"].as_f64() > Some(10.0));
}

/// A hole whose declared place is off by what the problem allows is scored where the calibration
/// found it.
#[test]
fn a_score_takes_the_places_that_were_found() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--contacts", "1000", "--out", "."]).success();
    let text = std::fs::read_to_string(folder.path().join("problem.toml")).unwrap();
    let place = text.lines().find(|line| line.starts_with("base_from_fixture")).unwrap();
    let exact = format!("{place}\nexact = true");
    assert!(text.contains(&exact), "{text}");
    let off = "base_from_fixture = { xyz_mm = [601, 99, 150.5], rpy_deg = [0.2, 0, 20] }\nsigma_mm = 1\nsigma_deg = 0.2\nexact = [\"clearance\", \"depth\"]";
    std::fs::write(folder.path().join("off.toml"), text.replace(&exact, off)).unwrap();
    let done = touchcal(folder.path(), &["calibrate", "off.toml", "--out", "out"]).success();
    assert!(stdout(&done).contains("--estimate out/estimate.json"), "{}", stdout(&done));
    let score = |more: &[&str]| -> f64 {
        let args = ["evaluate", "off.toml", "--urdf", "out/calibrated.urdf", "--json"];
        let done = touchcal(folder.path(), &[&args[..], more].concat()).success();
        serde_json::from_str::<serde_json::Value>(&stdout(&done)).unwrap()["mean_mm"].as_f64().unwrap()
    };
    let postfit = json(&folder.path().join("out/estimate.json"))["residuals"]["postfit"]["mean_mm"].as_f64().unwrap();
    let found = score(&["--estimate", "out/estimate.json"]);
    assert!((found - postfit).abs() < 1e-9 * postfit, "{found} and {postfit} mm");
    assert!(score(&[]) > 5.0 * postfit, "{} and {postfit} mm", score(&[]));
}

/// A hole half a millimetre from where it is declared exactly: the table says what contacts show,
/// how large it would be, and where the problem file declares it.
#[test]
fn effects_that_contacts_show_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--out", "."]).success();
    let text = std::fs::read_to_string(folder.path().join("problem.toml")).unwrap();
    let off = text.replace("xyz_mm = [600, 100, 150]", "xyz_mm = [600.4, 99.6, 150.4]");
    assert_ne!(off, text);
    std::fs::write(folder.path().join("off.toml"), off).unwrap();
    let shown = stdout(&touchcal(folder.path(), &["calibrate", "off.toml", "--out", "out"]).code(3));
    let row = shown.lines().find(|line| line.starts_with("  fixture.hole ")).unwrap();
    for part in ["e-", "hole.", " ± ", "base_from_fixture in [[fixture]] hole"] {
        assert!(row.contains(part), "expected `{part}` in: {row}");
    }
    let report = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(report.contains("\"declared_in\":\"base_from_fixture in [[fixture]] hole\""));
}

#[test]
fn inspect_expects_what_calibrate_then_finds() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--contacts", "1000", "--seed", "7", "--out", "d"]).success();
    let done = touchcal(folder.path(), &["inspect", "d/problem.toml", "--json"]).success();
    let inspection: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    let estimate = json(&folder.path().join("d/estimate.json"));
    assert_eq!(inspection["contacts_per_fixture"]["hole"], 1000);
    assert_eq!(inspection["rank"], estimate["rank"]);
    for (expected, found) in
        inspection["parameters"].as_array().unwrap().iter().zip(estimate["parameters"].as_array().unwrap())
    {
        assert_eq!(expected["name"], found["name"]);
        let ratio = expected["sigma"].as_f64().unwrap() / found["sigma"].as_f64().unwrap();
        assert!((0.3..4.0).contains(&ratio), "{}: {ratio}", expected["name"]);
    }
}
