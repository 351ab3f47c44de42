//! Completions, manual pages and the guide's reference say what the arguments' definition says.

use super::{stdout, touchcal};

#[test]
fn completions_know_commands_and_options() {
    let folder = tempfile::tempdir().unwrap();
    for (shell, marks) in [
        ("bash", ["complete -F _touchcal", "--driver-offsets"]),
        ("zsh", ["#compdef touchcal", "--driver-offsets"]),
        ("fish", ["complete -c touchcal", "driver-offsets"]),
    ] {
        let script = stdout(&touchcal(folder.path(), &["completions", shell]).success());
        for mark in marks {
            assert!(script.contains(mark), "{shell}: {mark}");
        }
    }
    touchcal(folder.path(), &["completions", "tcsh"]).code(2);
}

/// Bash itself takes the script and completes with it.
#[cfg(unix)]
#[test]
fn bash_completes() {
    let folder = tempfile::tempdir().unwrap();
    let script = stdout(&touchcal(folder.path(), &["completions", "bash"]).success());
    std::fs::write(folder.path().join("touchcal.bash"), script).unwrap();
    let complete = "source touchcal.bash; COMP_WORDS=(touchcal calibrate --driv); COMP_CWORD=2; \
                    _touchcal touchcal --driv calibrate; echo \"${COMPREPLY[@]}\"";
    let done = std::process::Command::new("bash").current_dir(folder.path()).args(["-c", complete]).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&done.stdout), "--driver-offsets\n");
}

#[test]
fn every_command_has_a_page() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["man", "--out", "man1"]).success();
    let page = |name: &str| std::fs::read_to_string(folder.path().join("man1").join(name)).unwrap();
    assert!(page("touchcal.1").contains(".TH touchcal 1"));
    assert!(page("touchcal-calibrate.1").contains("\\-\\-driver\\-offsets"));
    assert!(page("touchcal-experiment-table1.1").contains("\\-\\-descent\\-contacts"));
    // Groups of options are parts of OPTIONS; examples are as they are in the help.
    let calibrate = page("touchcal-calibrate.1");
    let at = |mark: &str| calibrate.find(mark).unwrap_or_else(|| panic!("{mark}: {calibrate}"));
    assert!(at(".SH OPTIONS\n") < at(".SS CONTACTS\n") && at(".SS OUTPUT\n") < at(".SH EXAMPLES\n.nf\n"));
    assert!(calibrate.contains("\n    touchcal calibrate sim/problem.toml \\-\\-except left \\-\\-out fitted\n"));
    assert!(page("touchcal-evaluate.1").contains(" \\-\\-only left \\e\n      \\-\\-urdf fitted/calibrated.urdf "));
    assert!(page("touchcal.1").contains(".SH EXIT STATUS\n.nf\n"));
    for file in std::fs::read_dir(folder.path().join("man1")).unwrap().map(|file| file.unwrap().path()) {
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(text.matches("\n.SH EXAMPLES\n").count(), 1, "{}", file.display());
    }
    assert!(!folder.path().join("man1/touchcal-reference.1").exists());
    assert_eq!(stdout(&touchcal(folder.path(), &["man"]).success()), page("touchcal.1"));
}

/// `TOUCHCAL_UPDATE=1 cargo test -p touchcal-cli reference` writes it anew.
#[cfg(feature = "parquet")]
#[test]
fn the_guides_reference_is_what_help_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../guide/src/reference.md");
    super::golden::same(&path, &stdout(&touchcal(folder.path(), &["reference"]).success()));
}
