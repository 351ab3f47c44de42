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
    // Right below the verdict.
    let lines = stdout(&failed);
    assert!(lines.starts_with("USABLE") && lines.contains("Accept    FAIL: "), "{lines}");
    assert!(lines.find("Accept    ").unwrap() < lines.find("Contacts  ").unwrap(), "{lines}");
    assert!(stderr(&failed).contains("FAIL: the tool is not within the tolerance of [accept]"), "{}", stderr(&failed));
    assert_eq!((acceptance()["decision"].as_str(), acceptance()["poses"].as_u64()), (Some("fail"), Some(100)));
    let report = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(report.contains("\"acceptance\":{\"decision\":\"fail\",\"message\":\"FAIL: "));

    let bound = acceptance()["errors"]["distance_mm"].as_f64().unwrap();
    let undecided = ask(&format!("{}", 0.8 * bound)).code(3);
    assert!(stdout(&undecided).contains("Accept    UNDECIDED: "), "{}", stdout(&undecided));
    assert!(
        stdout(&undecided).contains("-> record contacts in more postures and at other places: an exact `"),
        "{}",
        stdout(&undecided)
    );
}

/// A result that has no decision says which of the reasons holds.
#[test]
fn the_reason_why_nothing_is_decided_is_named() {
    let folder = tempfile::tempdir().unwrap();
    // Without errors a short descent starts where it ends, and a long one runs away.
    let scenario = "preset = \"paper\"\ncontacts = 90\n[errors]\nstrain = 0\njoint_offset_deg = 0\n";
    std::fs::write(folder.path().join("scenario.toml"), scenario).unwrap();
    touchcal(folder.path(), &["simulate", "scenario.toml", "--seed", "1", "--out", "sim"]).success();
    let problem = folder.path().join("sim/problem.toml");
    let text = std::fs::read_to_string(&problem).unwrap();
    let accept = "[accept]\ntolerance_mm = 1\nregion = { center_mm = [500, 0, 400], size_mm = [400, 400, 400] }\n";
    let decided = |rate: &str| {
        let descent = format!("descent = {{ steps = 20, contacts = 40, rate = {rate} }}");
        let method = format!("[estimate]\nmethod = \"gradient_descent\"\n{descent}");
        std::fs::write(&problem, format!("{}\n{accept}", text.replace("[estimate]", &method))).unwrap();
        stdout(&touchcal(folder.path(), &["calibrate", "sim/problem.toml", "--out", "out"]).code(3))
    };
    let ran_away = decided("50");
    let reason =
        "Accept    UNDECIDED: the calibration must not be used\n          -> follow the advice of the warnings";
    assert!(ran_away.starts_with("NOT USABLE") && ran_away.contains(reason), "{ran_away}");
    let without = decided("1e-6");
    let reason =
        "Accept    UNDECIDED: the calibration has no uncertainty of the arm or the tool\n          -> estimate";
    assert!(without.starts_with("DOUBTFUL") && without.contains(reason), "{without}");
}

/// The demo's calibration, asked for 1 mm, with another log of the same arm held out.
#[test]
fn contacts_that_are_held_out_confirm_or_contradict() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--contacts", "600", "--out", "demo"]).success();
    let problem = folder.path().join("demo/problem.toml");
    let text = std::fs::read_to_string(&problem).unwrap();
    let region = "region = { center_mm = [500, 0, 400], size_mm = [400, 400, 400] }";
    let calibrate = |log: &str| {
        std::fs::write(folder.path().join("demo/check.csv"), log).unwrap();
        let check = "[[contacts]]\nfile = \"check.csv\"\nfixture = \"hole\"\nforce_threshold_n = 3\nheld_out = true";
        std::fs::write(&problem, format!("{text}\n{check}\n[accept]\ntolerance_mm = 1\n{region}\n")).unwrap();
        touchcal(folder.path(), &["calibrate", "demo/problem.toml", "--out", "out"])
    };
    let estimate = || json(&folder.path().join("out/estimate.json"));
    let again = ["simulate", "demo/scenario.toml", "--noise-seed", "7", "--out", "again"];
    touchcal(folder.path(), &again).success();
    let again = std::fs::read_to_string(folder.path().join("again/hole.csv")).unwrap();

    let passed = calibrate(&again).success();
    assert!(stdout(&passed).contains("Held out  600 contacts: "), "{}", stdout(&passed));
    assert!(stdout(&passed).contains("contacts that were held out agree"), "{}", stdout(&passed));
    assert_eq!((&estimate()["status"], &estimate()["contacts"]["used"]), (&"usable".into(), &600.into()));
    let report = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(report.contains("\"held_out\":{\"contacts\":600"));

    // The first encoder is 0.1 degrees off in every other row.
    let shifted = again.lines().enumerate().map(|(i, line)| match line.split(',').collect::<Vec<_>>() {
        cells if i > 0 && i % 2 == 0 => {
            let q: f64 = cells[1].parse().unwrap();
            format!("{},{},{}\n", cells[0], q + 0.1_f64.to_radians(), cells[2..].join(","))
        }
        _ => format!("{line}\n"),
    });
    let contradicted = calibrate(&shifted.collect::<String>()).code(3);
    assert!(stdout(&contradicted).contains("UNDECIDED: "), "{}", stdout(&contradicted));
    let message = estimate()["acceptance"]["message"].as_str().unwrap().to_owned();
    assert!(message.contains("but contacts that were held out contradict that"), "{message}");
    assert_eq!(estimate()["status"], "doubtful");
    assert_eq!(estimate()["warnings"][0]["kind"], "held_out_contradicted");
    assert!(estimate()["held_out"]["scatter"]["ratio"].as_f64().unwrap() > 2.0);
}
