//! Stored manifolds: from poses and from contacts, and calibrating with them.

use super::golden::golden;
use super::{data, json, stderr, stdout, touchcal};

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
    assert_eq!(stderr(&done), "");
    golden("manifold.txt", &stdout(&done));
    let again = touchcal(folder.path(), &[&args[..], &["again.safetensors", "--json"]].concat()).success();
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("new/m.safetensors") == bytes("again.safetensors"), "not the same again");
    let told: serde_json::Value = serde_json::from_str(&stdout(&again)).unwrap();
    assert_eq!(told["provenance"]["recorded"], 81_000);
    assert!(told["spacing"][0].as_f64().unwrap() >= 1e-3);
}

/// The demonstration's problem with its calibrated arm gives a manifold, on which the same contacts
/// calibrate the nominal arm.
#[test]
fn contacts_of_a_calibrated_arm_are_a_manifold() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--contacts", "1000", "--out", "."]).success();
    let text = std::fs::read_to_string(folder.path().join("problem.toml")).unwrap();
    let robot =
        text.lines().find(|line| line.starts_with("builtin = \"iiwa14\"") || line.starts_with("urdf = ")).unwrap();
    let calibrated = text.replace(robot, "urdf = \"calibrated.urdf\"");
    std::fs::write(folder.path().join("calibrated.toml"), &calibrated).unwrap();
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
    touchcal(folder.path(), &["calibrate", "nearest.toml", "--out", "out"]).success();
    let inputs = json(&folder.path().join("out/estimate.json"))["inputs"].to_string();
    assert!(inputs.contains("m.safetensors"), "{inputs}");
}

/// Contacts with a hole whose outline nobody knows give the same manifold as with it, and calibrate
/// nothing before.
#[test]
fn a_hole_of_unknown_shape_can_be_recorded() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--contacts", "600", "--out", "."]).success();
    let text = std::fs::read_to_string(folder.path().join("problem.toml")).unwrap();
    let shapes = ["outline_offset_mm", "depth_mm", "length_mm"];
    let shapeless: Vec<&str> =
        text.lines().filter(|line| !shapes.iter().any(|shape| line.starts_with(shape))).collect();
    let unknown = shapeless.join("\n").replace("kind = \"hole\"", "kind = \"hole\"\nmanifold = \"unknown\"");
    std::fs::write(folder.path().join("unknown.toml"), unknown + "\n").unwrap();
    let record = |problem: &str, out: &str| {
        let done = touchcal(folder.path(), &["manifold", problem, "--json", "--out", out]).success();
        let mut told: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
        told["provenance"]["inputs"].take();
        told
    };
    let (with, mut without) =
        (record("problem.toml", "with.safetensors"), record("unknown.toml", "without.safetensors"));
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
    touchcal(folder.path(), &["demo", "--contacts", "600", "--out", "."]).success();
    let path = folder.path().join("problem.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let table =
        "[[fixture]]\nname = \"table\"\nkind = \"plane\"\nbase_from_fixture = { xyz_mm = [0, 0, 10] }\n\n[[contacts]]";
    std::fs::write(&path, text.replacen("[[contacts]]", table, 1)).unwrap();
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
