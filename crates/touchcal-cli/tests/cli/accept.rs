//! Decisions at a tolerance: words, file and exit code.

use super::{json, stderr, stdout, touchcal};

#[test]
fn a_tolerance_is_passed_or_failed() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--contacts", "600", "--out", "demo"]).success();
    let problem = folder.path().join("demo/problem.toml");
    let text = std::fs::read_to_string(&problem).unwrap();
    let ask = |tolerance: &str| {
        let task = "region = { center_mm = [500, 0, 400], size_mm = [400, 400, 400] }";
        std::fs::write(&problem, format!("{text}\n[accept]\ntolerance_mm = {tolerance}\n{task}\n")).unwrap();
        touchcal(folder.path(), &["calibrate", "demo/problem.toml", "--out", "out"])
    };
    let acceptance = || json(&folder.path().join("out/estimate.json"))["acceptance"].clone();

    let passed = ask("1").success();
    assert!(
        stdout(&passed).contains("Accept    PASS: the tool is within 1.000 mm in all 100 poses"),
        "{}",
        stdout(&passed)
    );
    assert_eq!(acceptance()["decision"], "pass");
    let report = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(report.contains("PASS: the tool is within 1.000 mm"));

    let failed = ask("0.0001").code(3);
    assert!(stdout(&failed).contains("Accept    FAIL: "), "{}", stdout(&failed));
    assert!(stderr(&failed).contains("FAIL: the tool is not within the tolerance of [accept]"), "{}", stderr(&failed));
    assert_eq!((acceptance()["decision"].as_str(), acceptance()["poses"].as_u64()), (Some("fail"), Some(100)));

    let bound = acceptance()["errors"]["distance_mm"].as_f64().unwrap();
    let undecided = ask(&format!("{}", 0.8 * bound)).code(3);
    assert!(stdout(&undecided).contains("Accept    UNDECIDED: "), "{}", stdout(&undecided));
    assert!(stdout(&undecided).contains("-> record contacts that tell `"), "{}", stdout(&undecided));
}
