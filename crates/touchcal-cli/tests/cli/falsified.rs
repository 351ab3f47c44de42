//! `touchcal experiment falsified`: every trial once, its figures, and what is written.

use touchcal::experiment::falsified::FalsifiedKind;

use super::{json, stderr, stdout, touchcal};

const ARGS: [&str; 8] = ["experiment", "falsified", "--trials", "1", "--contacts", "300", "--out", "out"];

#[test]
fn two_kinds_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let run = |more: &[&str]| touchcal(path, &[&ARGS[..], more].concat());
    let kinds = ["--kind", "hole_exact_1mm", "--kind", "nothing_exact"];
    let done = run(&kinds).success();
    let printed = stdout(&done);
    // In the order of the battery, not of the arguments.
    let lines: Vec<Vec<&str>> = printed.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(lines[2][..4], ["kind", "trials", "honest", "useful"], "{printed}");
    assert_eq!((lines[3][0], lines[4][0], lines[5][0]), ("nothing_exact", "hole_exact_1mm", "all"), "{printed}");
    assert_eq!((lines[3][1], lines[4][1], lines[5][1]), ("3", "2", "5"), "{printed}");

    let found = json(&path.join("out/falsified.json"));
    let (nothing, hole) = (&found[0], &found[1]);
    assert_eq!((&nothing["kind"], &nothing["trials"]), (&"nothing_exact".into(), &3.into()));
    assert_eq!(nothing["excitations"]["sockets"]["trials"], 1);
    assert!(nothing["tool_error_mm"].as_f64().unwrap() > 0.0, "{nothing}");
    // A millimetre in a hole of half a millimetre at each side is more than 300 contacts forgive.
    assert_eq!((&hole["honest"], &hole["useful"]), (&2.into(), &0.into()), "{hole}");
    let svg = std::fs::read_to_string(path.join("out/falsified.svg")).unwrap();
    assert!(svg.contains("hole_exact_1mm") && svg.contains("2/2 honest"), "{svg}");
    let parquet = std::fs::read(path.join("out/falsified.parquet")).unwrap();
    assert!(parquet.starts_with(b"PAR1") && parquet.ends_with(b"PAR1"));

    // Finished trials are kept, those of other settings or broken ones are not.
    let row = |name: &str| path.join("out/rows").join(name);
    let written = |name: &str| std::fs::metadata(row(name)).unwrap().modified().unwrap();
    let kept = written("hole_exact_1mm.rich.1.json");
    std::fs::write(row("nothing_exact.sockets.1.json"), "{").unwrap();
    assert_eq!(stdout(&run(&kinds).success()), printed);
    assert_eq!(written("hole_exact_1mm.rich.1.json"), kept);
    let as_json = run(&[&kinds[..], &["--json"]].concat()).success();
    assert_eq!(serde_json::from_str::<serde_json::Value>(&stdout(&as_json)).unwrap(), found);
    let other = ["experiment", "falsified", "--trials", "1", "--contacts", "200", "--out", "out"];
    touchcal(path, &[&other[..], &["--kind", "hole_exact_1mm"]].concat()).success();
    assert_ne!(written("hole_exact_1mm.rich.1.json"), kept);
}

#[test]
fn kinds_are_listed_and_others_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let help = stdout(&touchcal(folder.path(), &["experiment", "falsified", "--help"]).success());
    for kind in FalsifiedKind::ALL {
        assert!(help.contains(kind.name), "{}", kind.name);
    }
    let done = touchcal(folder.path(), &[&ARGS[..], &["--kind", "hole_2mm"]].concat()).code(2);
    assert!(stderr(&done).contains("hole_2mm") && !folder.path().join("out").exists(), "{}", stderr(&done));
}

#[test]
fn recorded_contacts_are_tried_with_what_the_problem_declares() {
    let folder = tempfile::tempdir().unwrap();
    let logs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/mujoco_iiwa14/extrusion/rich");
    let run = |kind: &str| {
        let args = ["experiment", "falsified", "--logs", logs, "--trials", "1", "--kind", kind, "--out", "out"];
        touchcal(folder.path(), &args)
    };
    run("hole_1mm").success();
    let found = &json(&folder.path().join("out/falsified.json"))[0];
    let trials = std::fs::read_dir(logs).unwrap().count();
    assert_eq!(
        (&found["trials"], &found["honest"], &found["useful"]),
        (&trials.into(), &trials.into(), &trials.into())
    );
    assert_eq!(found["excitations"]["rich.trial_00"]["trials"], 1, "{found}");
    assert!(folder.path().join("out/rows/hole_1mm.rich.trial_00.1.json").is_file());
    let refused = stderr(&run("friction_0.25").failure());
    assert!(refused.contains("friction_0.25 needs a simulation"), "{refused}");
}
