//! Stored manifolds: from poses and from contacts, and calibrating with them.

use std::path::Path;

use super::golden::golden;
use super::{data, errors, json, stderr, stdout, touchcal};

fn offline() -> String {
    let path = data().join("mujoco_iiwa14/extrusion/offline/contact_poses.csv.gz");
    path.to_str().unwrap().to_owned()
}

#[test]
fn recorded_poses_are_stored_thinned() {
    let folder = tempfile::tempdir().unwrap();
    let poses = offline();
    let args = ["manifold", "--poses", &poses, "--fixture", "hole", "--spacing-mm", "1", "--out"];
    let done = touchcal(folder.path(), &[&args[..], &["new/m.safetensors"]].concat()).success();
    assert_eq!(errors(&done), "");
    golden("manifold.txt", &stdout(&done));
    let again = touchcal(folder.path(), &[&args[..], &["again.safetensors", "--json"]].concat()).success();
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("new/m.safetensors") == bytes("again.safetensors"), "not the same again");
    let told: serde_json::Value = serde_json::from_str(&stdout(&again)).unwrap();
    assert_eq!(told["provenance"]["recorded"], 81_000);
    assert!(told["spacing"][0].as_f64().unwrap() >= 1e-3);
}

/// Writes the demonstration into a folder, with `calibrated.toml`, its problem with the arm that it
/// calibrated; returns the texts of both problems.
pub(super) fn demonstration(folder: &Path, contacts: &str) -> [String; 2] {
    touchcal(folder, &["demo", "--contacts", contacts, "--out", "."]).success();
    let text = std::fs::read_to_string(folder.join("problem.toml")).unwrap();
    let is_robot = |line: &&str| line.starts_with("builtin = \"iiwa14\"") || line.starts_with("urdf = ");
    let robot = text.lines().find(is_robot).unwrap();
    let calibrated = text.replace(robot, "urdf = \"calibrated.urdf\"");
    std::fs::write(folder.join("calibrated.toml"), &calibrated).unwrap();
    [text, calibrated]
}

/// `inspect` has no standard deviations of a problem with a projection, as `calibrate` has none; it
/// has those of the demonstration's exact gap.
#[track_caller]
pub(super) fn no_uncertainty_is_expected(folder: &Path, problem: &str) {
    let inspect = |problem: &str| -> serde_json::Value {
        serde_json::from_str(&stdout(&touchcal(folder, &["inspect", problem, "--json"]).success())).unwrap()
    };
    let sigmas = |inspection: &serde_json::Value| {
        let parameters = inspection["parameters"].as_array().unwrap();
        (parameters.iter().filter(|entry| entry["sigma"].is_f64()).count(), parameters.len())
    };
    let has_warning = |inspection: &serde_json::Value| inspection["warnings"].to_string().contains("no_uncertainty");
    let projected = inspect(problem);
    assert_eq!(sigmas(&projected), (0, 8), "{projected}");
    assert!(has_warning(&projected), "{projected}");
    let exact = inspect("problem.toml");
    assert_eq!(sigmas(&exact), (15, 15), "{exact}");
    assert!(!has_warning(&exact), "{exact}");
    let shown = stdout(&touchcal(folder, &["inspect", problem]).success());
    assert!(shown.contains("Parameters, without standard deviations") && !shown.contains("Expected"), "{shown}");
}

/// The demonstration's problem with its calibrated arm gives a manifold, on which the same contacts
/// calibrate the nominal arm.
#[test]
fn contacts_of_a_calibrated_arm_are_a_manifold() {
    let folder = tempfile::tempdir().unwrap();
    let [text, _] = demonstration(folder.path(), "1000");
    let done = touchcal(folder.path(), &["manifold", "calibrated.toml", "--out", "m.safetensors"]).success();
    let shown = stdout(&done);
    let touch = shown.lines().find_map(|line| line.strip_prefix("Distance  ")?.split(' ').next()).unwrap();
    assert!(touch.parse::<f64>().unwrap() < 0.05, "{shown}");

    let key = "outline_offset_mm";
    let nearest = text.replace(key, &format!("manifold = \"nearest\"\nsamples = \"m.safetensors\"\n{key}"));
    std::fs::write(folder.path().join("nearest.toml"), nearest).unwrap();
    let done = touchcal(folder.path(), &["evaluate", "nearest.toml", "--urdf", "calibrated.urdf", "--json"]).success();
    let score: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    assert!(
        score["mean_mm"].as_f64().unwrap() < 1e-6 && score["nominal"]["mean_mm"].as_f64().unwrap() > 5.0,
        "{score}"
    );
    no_uncertainty_is_expected(folder.path(), "nearest.toml");
    touchcal(folder.path(), &["calibrate", "nearest.toml", "--out", "out"]).success();
    let estimate = json(&folder.path().join("out/estimate.json"));
    assert!(estimate["parameters"].as_array().unwrap().iter().all(|entry| entry["sigma"].is_null()), "{estimate}");
    let inputs = json(&folder.path().join("out/estimate.json"))["inputs"].to_string();
    assert!(inputs.contains("m.safetensors"), "{inputs}");
}

/// Without the lines that declare the hole's shape.
fn shapeless(problem: &str) -> String {
    let shapes = ["outline_offset_mm", "depth_mm", "length_mm"];
    let lines: Vec<&str> = problem.lines().filter(|line| !shapes.iter().any(|shape| line.starts_with(shape))).collect();
    lines.join("\n").replace("kind = \"hole\"", "kind = \"hole\"\nmanifold = \"unknown\"") + "\n"
}

/// Contacts with a hole whose outline nobody knows give the same manifold as with it, and calibrate
/// nothing before.
#[test]
fn a_hole_of_unknown_shape_can_be_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let [_, calibrated] = demonstration(folder.path(), "600");
    std::fs::write(folder.path().join("unknown.toml"), shapeless(&calibrated)).unwrap();
    let record = |problem: &str, out: &str, notes: usize| {
        let done = touchcal(folder.path(), &["manifold", problem, "--json", "--out", out]).success();
        let said = stderr(&done);
        assert_eq!(said.lines().filter(|line| line.contains("whether its arm is calibrated")).count(), notes, "{said}");
        let mut told: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
        told["provenance"]["inputs"].take();
        told
    };
    let with = record("calibrated.toml", "with.safetensors", 0);
    let mut without = record("unknown.toml", "without.safetensors", 1);
    assert_eq!(without["touch"], serde_json::Value::Null);
    without["touch"] = with["touch"].clone();
    assert_eq!(with, without);
    for command in [&["calibrate", "unknown.toml", "--out", "out"][..], &["inspect", "unknown.toml"]] {
        let failed = touchcal(folder.path(), command).code(1);
        let said = stderr(&failed);
        assert!(said.contains("fixture `hole`: expected a known manifold, found `unknown`"), "{said}");
    }
    assert!(!folder.path().join("out").exists());
}

/// Neither at a hole of known shape, nor at one of unknown shape beside it, are contacts of an arm
/// stored that misses the known one.
#[test]
fn contacts_of_an_arm_that_misses_its_fixture_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [nominal, calibrated] = demonstration(folder.path(), "600");
    let refused = |problem: &str, fixture: &str| {
        let args = ["manifold", problem, "--fixture", fixture, "--out", "m.safetensors"];
        let done = touchcal(folder.path(), &args).code(3);
        let said = stderr(&done);
        assert!(said.lines().count() == 1 && stdout(&done).is_empty(), "{said}");
        for part in
            ["expected contacts with `hole` within 0.", "found 1.5", "out/calibrated.urdf", "touchcal calibrate"]
        {
            assert!(said.contains(part), "expected `{part}` in: {said}");
        }
        assert!(!folder.path().join("m.safetensors").exists());
    };
    refused("problem.toml", "hole");
    // So far off that no place within the tolerances fits.
    let in_metres = nominal.replace("xyz_mm = [0, 0, 150]", "xyz_mm = [0, 0, 0.15]");
    assert_ne!(in_metres, nominal);
    std::fs::write(folder.path().join("metres.toml"), in_metres).unwrap();
    let said = stderr(&touchcal(folder.path(), &["manifold", "metres.toml", "--out", "m.safetensors"]).code(3));
    assert!(said.contains("touchcal calibrate") && said.lines().count() == 1, "{said}");
    // The same contacts again, in rows of their own, with a fixture that has no shape.
    let log = std::fs::read_to_string(folder.path().join("hole.csv")).unwrap();
    let of_second: String = log.lines().map(|row| format!("{row},again\n")).collect();
    std::fs::write(folder.path().join("second.csv"), of_second).unwrap();
    let beside = |problem: &str| {
        let block = |heading: &str| {
            let (_, rest) = problem.split_once(heading).unwrap();
            format!("{heading}{}\n", rest.split_once("\n[").unwrap().0)
        };
        let [fixture, contacts] =
            ["[[fixture]]", "[[contacts]]"].map(|heading| block(heading).replace("\"hole\"\n", "\"second\"\n"));
        let contacts = contacts.replace("hole.csv", "second.csv");
        let fixture = shapeless(&fixture.replace("kind = \"second\"", "kind = \"hole\""));
        problem.replacen("[[contacts]]", &format!("{fixture}{contacts}[[contacts]]"), 1)
    };
    std::fs::write(folder.path().join("beside.toml"), beside(&nominal)).unwrap();
    refused("beside.toml", "second");
    std::fs::write(folder.path().join("beside.toml"), beside(&calibrated)).unwrap();
    let args = ["manifold", "beside.toml", "--fixture", "second", "--out", "m.safetensors"];
    let done = touchcal(folder.path(), &args).success();
    assert!(!stderr(&done).contains("whether its arm is calibrated"), "{}", stderr(&done));
}

/// With a calibrated arm the place of the hole is declared beside the true one: within a default of
/// 1 mm, beyond it, and beside a place that is declared exact.
#[test]
fn a_fixture_that_is_found_elsewhere_is_noted_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [_, exact] = demonstration(folder.path(), "600");
    let to_1_mm = exact.replace("exact = true\n", "");
    let recorded = |text: &str, x: &str, code: i32| {
        let text = text.replace("[600, 100, 150]", &format!("[{x}, 100, 150]"));
        std::fs::write(folder.path().join("moved.toml"), text).unwrap();
        std::fs::remove_file(folder.path().join("m.safetensors")).ok();
        let done = touchcal(folder.path(), &["manifold", "moved.toml", "--out", "m.safetensors"]).code(code);
        assert_eq!(folder.path().join("m.safetensors").exists(), code == 0);
        stderr(&done)
    };
    assert_eq!(recorded(&to_1_mm, "600", 0), "");
    assert_eq!(recorded(&to_1_mm, "600.3", 0), "");
    for (x, found) in [("600.9", "fixture `hole` is 0.9"), ("602.3", "fixture `hole` is 2.3")] {
        let said = recorded(&to_1_mm, x, 0);
        let is_noted = said.contains(found) && said.contains("stored poses are relative to the declared place");
        assert!(is_noted && said.lines().count() == 1, "{said}");
    }
    for (text, x, found) in [(&to_1_mm, "605", "found them 5.0"), (&exact, "602.3", "found them 2.3")] {
        let said = recorded(text, x, 3);
        let parts = ["expected tool and fixture `hole` within their tolerances", found, "touchcal calibrate"];
        assert!(parts.iter().all(|part| said.contains(part)) && said.lines().count() == 1, "{said}");
    }
}

#[test]
fn bad_input_gets_one_message_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let header = "x,y,z,qw,qx,qy,qz\n";
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("none.csv", header);
    write("one.csv", &format!("{header}0,0,0,1,0,0,0\n0,0,0,1,0,0,0\n"));
    write("two.csv", &format!("{header}0,0,0,1,0,0,0\n0,0,0.001,1,0,0,0\n"));
    write("nan.csv", &format!("{header}0,0,0,1,0,0,0\n0,0,NaN,1,0,0,0\n"));
    for (args, code, parts) in [
        (&["--poses", "none.csv"][..], 1, &["none.csv: expected at least two different poses, found 0 in 0"][..]),
        (&["--poses", "one.csv"], 1, &["one.csv", "found 1 in 2"]),
        (&["--poses", "nan.csv"], 1, &["nan.csv:3, column z: expected a number, found \"NaN\""]),
        (&["--poses", "no.csv"], 1, &["no.csv", "No such file"]),
        (&["--poses", "two.csv", "--spacing-mm", "5"], 1, &["--spacing-mm: expected at least two different poses"]),
        (&["--poses", "two.csv", "--spacing-mm=-5"], 2, &["--spacing-mm", "expected a number from 0"]),
        (&["--poses", "two.csv", "--mm-per-deg", "0"], 2, &["expected a number above 0"]),
        (&["--poses", "two.csv", "problem.toml"], 2, &["cannot be used with"]),
        (&[], 2, &["PROBLEM.toml"]),
    ] {
        let done = touchcal(folder.path(), &[&["manifold", "--out", "m.safetensors"], args].concat()).code(code);
        assert!(parts.iter().all(|part| stderr(&done).contains(part)), "expected {parts:?} in: {}", stderr(&done));
        assert!(code == 2 || stderr(&done).lines().count() == 1, "{}", stderr(&done));
        assert!(stdout(&done).is_empty() && !folder.path().join("m.safetensors").exists());
    }
}

#[test]
fn one_of_several_fixtures_must_be_named() {
    let folder = tempfile::tempdir().unwrap();
    let [_, text] = demonstration(folder.path(), "600");
    let table =
        "[[fixture]]\nname = \"table\"\nkind = \"plane\"\nbase_from_fixture = { xyz_mm = [0, 0, 10] }\n\n[[contacts]]";
    std::fs::write(folder.path().join("problem.toml"), text.replacen("[[contacts]]", table, 1)).unwrap();
    let run = |args: &[&str]| {
        touchcal(folder.path(), &[&["manifold", "problem.toml", "--out", "m.safetensors"], args].concat())
    };
    assert!(stderr(&run(&[]).code(1)).contains("--fixture with the name of one (hole, table), found none"));
    assert!(stderr(&run(&["--fixture", "whole"]).code(1)).contains("found `whole`"));
    assert!(
        stderr(&run(&["--fixture", "table"]).code(1))
            .contains("`table`: expected at least two different poses, found 0")
    );
    run(&["--fixture", "hole"]).success();
}
