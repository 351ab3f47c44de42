//! Texts that do not change by accident. `TOUCHCAL_UPDATE=1 cargo test` writes them anew.

use std::path::Path;

use super::{data, stdout, touchcal};

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

/// The text with every number as `#` and single blanks, so that columns may change their width.
fn without_numbers(text: &str) -> String {
    let mut shown = String::new();
    for line in text.lines() {
        let words = line.split_whitespace().map(|word| match word.trim_end_matches(['*', ',', ')']).parse::<f64>() {
            Ok(_) => "#".to_owned(),
            Err(_) => word.to_owned(),
        });
        shown.push_str(&words.collect::<Vec<_>>().join(" "));
        shown.push('\n');
    }
    shown
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

#[test]
fn summaries_of_a_real_arm() {
    let folder = tempfile::tempdir().unwrap();
    let mukca = data().canonicalize().unwrap().join("mukca");
    let (logs, urdf) = (mukca.join("kuka_14"), mukca.join("iiwa14.urdf"));
    let source = ["--mukca", logs.to_str().unwrap(), "--only", "front", "--urdf", urdf.to_str().unwrap()];
    let shown = |args: &[&str]| {
        let text = stdout(&touchcal(folder.path(), &[args, &source[..]].concat()).success());
        let text = without_numbers(&text.replace(mukca.to_str().unwrap(), "MUKCA"));
        // Which directions come first, and what takes part in them, are matters of rounding.
        text.lines().filter(|line| !line.starts_with("- ")).map(|line| format!("{line}\n")).collect::<String>()
    };
    golden("calibrate.txt", &shown(&["calibrate", "--out", "out"]));
    golden("inspect.txt", &shown(&["inspect"]));
}
