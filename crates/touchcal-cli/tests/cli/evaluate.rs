//! `evaluate`: what is found beside what the calibration predicts.

use std::path::Path;

use super::golden::golden;
use super::{json, stderr, stdout, touchcal};

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

/// Logs that the calibration was fitted to are noted; a tool declared at another pose than in the
/// calibrated problem, or than in the simulation, is refused.
#[test]
fn logs_of_the_calibration_and_other_tools_are_named() {
    let folder = tempfile::tempdir().unwrap();
    recorded_twice(folder.path());
    touchcal(folder.path(), &["calibrate", "fit/problem.toml", "--out", "out"]).success();
    let run = |problem: &str| {
        let args = ["evaluate", problem, "--urdf", "out/calibrated.urdf"];
        touchcal(folder.path(), &[&args[..], &ESTIMATE].concat())
    };
    let note = "6 of 6 logs are those of the calibration: agreement with contacts that it was fitted to proves little";
    assert!(stderr(&run("fit/problem.toml").success()).contains(note));
    assert!(!stderr(&run("check/problem.toml").success()).contains("logs are those of the calibration"));
    let text = std::fs::read_to_string(folder.path().join("check/problem.toml")).unwrap();
    let tool = text.lines().find(|line| line.starts_with("tip_from_tool = ")).unwrap();
    let moved = text.replace(tool, &tool.replace("150", "151"));
    assert_ne!(moved, text);
    std::fs::write(folder.path().join("check/moved.toml"), moved).unwrap();
    let refused = stderr(&run("check/moved.toml").code(1));
    assert!(refused.contains("tool, tip_from_tool: expected { xyz_mm = [0.0000, 0.0000, 150.0000]"), "{refused}");
    assert!(refused.contains("since the estimate in out/estimate.json is relative to it, found {"), "{refused}");
    let with_truth = |problem: &str| {
        let args = ["evaluate", problem, "--urdf", "check/true.urdf", "--truth", "check/truth.json"];
        touchcal(folder.path(), &args)
    };
    with_truth("check/problem.toml").success();
    let refused = stderr(&with_truth("check/moved.toml").code(1));
    assert!(refused.contains("tool, tip_from_tool: expected { xyz_mm = [0.0000, 0.0000, 150.0000]"), "{refused}");
    let reason = "as in the simulation, since the truth in check/truth.json is relative to it, found {";
    assert!(refused.contains(reason), "{refused}");
}

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
    let shown = page(folder.path(), "check/problem.toml");
    let expected = &found["scatter"]["all"];
    assert_eq!(shown["all"]["scatter"]["ratio"], expected["ratio"]);
    assert_eq!((&shown["agrees"], &shown["status"]), (&true.into(), &"usable".into()));
    let fixture = &shown["fixtures"][0];
    let in_json = &found["per_fixture"][fixture["name"].as_str().unwrap()];
    assert_eq!(1e3 * fixture["change"]["after"]["rms"].as_f64().unwrap(), in_json["rms_mm"].as_f64().unwrap());
    assert_eq!((shown["fixtures"].as_array().unwrap().len(), shown["distances"].as_array().unwrap().len()), (6, 3));
    assert_eq!(shown["distances"][0]["deviations"], found["distances"][0]["deviations"]);
}

/// One placement held out by its logs: these contacts alone are scored, as with `--only`.
#[test]
fn contacts_that_are_held_out_are_scored() {
    let folder = tempfile::tempdir().unwrap();
    recorded_twice(folder.path());
    let path = folder.path().join("fit/problem.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let of_right = |k: usize| format!("fixture = \"right/{k}\"\n");
    let held_out = (0..2).fold(text.clone(), |text, k| {
        let (before, contacts) = text.split_once("[[contacts]]").unwrap();
        format!("{before}[[contacts]]{}", contacts.replace(&of_right(k), &format!("{}held_out = true\n", of_right(k))))
    });
    assert_eq!(held_out.matches("held_out").count(), 2, "{held_out}");
    std::fs::write(folder.path().join("fit/held_out.toml"), held_out).unwrap();
    touchcal(folder.path(), &["calibrate", "fit/held_out.toml", "--out", "out"]).success();
    let found = evaluated(folder.path(), "fit/held_out.toml", &ESTIMATE);
    let only = evaluated(folder.path(), "fit/problem.toml", &[&ESTIMATE[..], &["--only", "right"]].concat());
    assert_eq!(found["all"], only["all"]);
    assert_eq!(found["scatter"]["all"], only["scatter"]["all"]);
    assert_eq!(found["distances"].as_array().unwrap().len(), 1, "{found}");
    // The tables are those that `--only` has, and have no rows of fixtures without contacts.
    let tables = |args: &[&str]| {
        let args = [&["evaluate", "--urdf", "out/calibrated.urdf"], &ESTIMATE[..], args].concat();
        stdout(&touchcal(folder.path(), &args).success())
    };
    let held_out = tables(&["fit/held_out.toml"]);
    assert_eq!(held_out, tables(&["fit/problem.toml", "--only", "right"]));
    assert!(held_out.contains("  right/0") && !held_out.contains("left/0"), "{held_out}");
    let fitted = stdout(&touchcal(folder.path(), &["calibrate", "fit/held_out.toml", "--out", "again"]).success());
    let (_, residuals) = fitted.split_once("Distance from contact (mm)\n").unwrap();
    let residuals = residuals.split("\n\n").next().unwrap();
    assert!(residuals.contains("left/1") && !residuals.contains("right/"), "{residuals}");
    assert!(fitted.contains("Next      evaluate it on the contacts that are held out"), "{fitted}");
}

/// The data of the page that `--report` writes.
fn page(folder: &Path, problem: &str) -> serde_json::Value {
    evaluated(folder, problem, &[&ESTIMATE[..], &["--report", "page.html"]].concat());
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    let data = page.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script").next()).unwrap();
    serde_json::from_str(data).unwrap()
}

#[test]
fn a_page_replaces_no_file_that_is_read() {
    let folder = tempfile::tempdir().unwrap();
    recorded_twice(folder.path());
    touchcal(folder.path(), &["calibrate", "fit/problem.toml", "--out", "out"]).success();
    let args = ["evaluate", "check/problem.toml", "--urdf", "out/calibrated.urdf", "--report"];
    for read in ["check/problem.toml", "out/calibrated.urdf"] {
        let before = std::fs::read(folder.path().join(read)).unwrap();
        let refused = touchcal(folder.path(), &[&args[..], &[read]].concat()).failure();
        assert!(stderr(&refused).contains(read), "{}", stderr(&refused));
        assert_eq!(std::fs::read(folder.path().join(read)).unwrap(), before);
    }
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

/// Parameters beside the true ones: those that contacts determine first, and these alone in
/// standard deviations.
fn parameters_are_compared(folder: &Path, found: &serde_json::Value) {
    let truth = ["--truth", "sim/truth.json"];
    let entries = found["truth"]["parameters"].as_array().unwrap();
    let is_identifiable = |entry: &serde_json::Value| entry["identifiable"].as_bool().unwrap();
    let truth_file = json(&folder.join("sim/truth.json"));
    let first_unknown = entries.iter().position(|entry| !is_identifiable(entry)).unwrap_or(entries.len());
    assert!(entries[first_unknown..].iter().all(|entry| !is_identifiable(entry)), "{entries:?}");
    assert!(entries.iter().filter(|entry| entry["name"].as_str().unwrap().starts_with("joint_offset.")).count() >= 6);
    for entry in entries {
        let [truth, estimated, difference] =
            ["true", "estimated", "difference"].map(|key| entry[key].as_f64().unwrap());
        assert_eq!(truth_file["parameters"][entry["name"].as_str().unwrap()], truth);
        assert_eq!(difference, estimated - truth);
        assert_eq!(entry["deviations"].is_number(), is_identifiable(entry), "{entry}");
        assert!(entry["deviations"].as_f64().is_none_or(|deviations| deviations.abs() < 5.0), "{entry}");
    }
    let args = ["evaluate", "sim/problem.toml", "--urdf", "out/calibrated.urdf"];
    let text = |more: &[&str]| stdout(&touchcal(folder, &[&args[..], &ESTIMATE, &truth, more].concat()).success());
    let rows = |text: &str| {
        let (_, table) = text.split_once("Parameters of the calibration relative to the true ones\n").unwrap();
        let lines =
            table.lines().skip(1).take_while(|line| !line.contains("… and") && !line.contains("Where directions"));
        lines.count()
    };
    assert_eq!(rows(&text(&["--all"])), entries.len());
    assert_eq!(rows(&text(&[])), entries.len().min(10));
    assert!(text(&[]).contains("single parameters do not compare"));
    let without = stdout(&touchcal(folder, &[&args[..], &truth].concat()).success());
    assert!(!without.contains("Parameters of the calibration"), "{without}");
}

/// Calibrated and nominal arm are off by what the summary expects, and the true arm by nothing. The
/// truth of another robot is refused.
#[test]
fn errors_against_the_truth_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let simulate = ["simulate", "--preset", "workcell", "--contacts", "600", "--seed", "3", "--out", "sim"];
    touchcal(folder.path(), &simulate).success();
    touchcal(folder.path(), &["calibrate", "sim/problem.toml", "--out", "out"]).success();
    let truth = ["--truth", "sim/truth.json"];
    let found = evaluated(folder.path(), "sim/problem.toml", &[&ESTIMATE[..], &truth].concat());
    let rms = |of: &serde_json::Value, name: &str| of[name]["rms"].as_f64().unwrap();
    let expected = &json(&folder.path().join("out/estimate.json"))["workspace_uncertainty"];
    for (error, sigma, nominal) in [
        ("position_mm", "position_mm", "nominal_position_mm"),
        ("angle_deg", "angle_deg", "nominal_angle_deg"),
        ("distance_mm", "distance_mm", "nominal_distance_mm"),
    ] {
        let (after, before) = (rms(&found["truth"]["given"], error), rms(&found["truth"]["nominal"], error));
        let [sigma, nominal] = [sigma, nominal].map(|name| expected[name].as_f64().unwrap());
        println!("{error}: {after} (expected {sigma}), nominal {before} (expected {nominal})");
        // One draw of the errors.
        assert!(after < 3.0 * sigma, "{error}: {after}, expected {sigma}");
        assert!((0.5..2.0).contains(&(before / nominal)), "{error}: {before}, expected {nominal}");
    }
    assert!(rms(&found["truth"]["given"], "aligned_position_mm") < rms(&found["truth"]["given"], "position_mm"));

    parameters_are_compared(folder.path(), &found);

    touchcal(folder.path(), &["simulate", "--preset", "paper", "--contacts", "60", "--out", "exact"]).success();
    let args = ["evaluate", "exact/problem.toml", "--urdf", "exact/true.urdf", "--truth", "exact/truth.json"];
    let text = stdout(&touchcal(folder.path(), &[&args[..], &["--json"]].concat()).success());
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    for name in ["position_mm", "angle_deg", "aligned_position_mm", "aligned_angle_deg", "distance_mm"] {
        assert!(found["truth"]["given"][name]["max"].as_f64().unwrap() < 1e-6, "{name}: {text}");
    }
    assert!(rms(&found["truth"]["nominal"], "position_mm") > 10.0, "{text}");

    let other = std::fs::read_to_string(folder.path().join("exact/truth.json")).unwrap();
    std::fs::write(folder.path().join("other.json"), other.replace("joint_a3", "elbow")).unwrap();
    let args = ["evaluate", "exact/problem.toml", "--urdf", "exact/true.urdf", "--truth", "other.json"];
    let refused = touchcal(folder.path(), &args).code(1);
    assert!(stderr(&refused).contains("expected a parameter of the robot \"iiwa14\""), "{}", stderr(&refused));
}
