//! Texts that do not change by accident. `TOUCHCAL_UPDATE=1 cargo test` writes them anew.

use std::path::Path;

use super::{stdout, touchcal};

#[track_caller]
pub(super) fn golden(name: &str, text: &str) {
    same(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/golden").join(name), text);
}

/// The text is that of the file.
#[track_caller]
pub(super) fn same(path: &Path, text: &str) {
    if std::env::var_os("TOUCHCAL_UPDATE").is_some() {
        std::fs::write(path, text).unwrap();
    }
    let expected = std::fs::read_to_string(path).unwrap_or_default();
    assert_eq!(text, expected, "{} differs; TOUCHCAL_UPDATE=1 takes the new text over", path.display());
}

/// The text without the time that the calibration took.
fn without_seconds(text: &str) -> String {
    let line = text.lines().find(|line| line.starts_with("Search ")).unwrap();
    let (search, seconds) = line.rsplit_once(" steps, ").unwrap();
    assert!(seconds.ends_with(" s"), "{line}");
    text.replacen(line, &format!("{search} steps, TIME s"), 1)
}

#[test]
fn help() {
    let folder = tempfile::tempdir().unwrap();
    for (name, args) in [
        ("help.txt", &["--help"][..]),
        ("help_calibrate.txt", &["calibrate", "--help"]),
        ("help_manifold.txt", &["manifold", "--help"]),
        ("help_train.txt", &["train", "--help"]),
        ("help_simulate.txt", &["simulate", "--help"]),
        ("help_table1.txt", &["experiment", "table1", "--help"]),
    ] {
        golden(name, &stdout(&touchcal(folder.path(), args).success()));
    }
}

/// Simulated logs are the same to the last bit, and so is all that follows from them.
#[test]
fn summaries() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| stdout(&touchcal(folder.path(), args).success());
    let problem = "mukca/problem.toml";
    golden(
        "simulate_mukca.txt",
        &run(&["simulate", "--preset", "mukca", "--contacts", "30", "--seed", "1", "--out", "mukca"]),
    );
    golden("inspect_mukca.txt", &run(&["inspect", problem]));
    golden("calibrate_mukca.txt", &without_seconds(&run(&["calibrate", problem, "--out", "calibration"])));
    golden("evaluate_mukca.txt", &run(&["evaluate", problem, "--urdf", "calibration/calibrated.urdf"]));
}
