//! Readers of folders and of outlines: whatever lies there, they answer with values or one error.

use std::path::Path;

use proptest::prelude::*;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::urdf::{self, Ends};
use touchcal::io::{problem_file, trial_folder, truth_file};

const TRUTH: &str = r#"{"geometry": "extrusion", "r": 0.05, "b_rad": [0, 0, 0, 0, 0, 0, 0.1],
 "T_flange_peg": {"position_m": [0, 0, 0.15], "quat_wxyz": [0, 0, 1, 0]},
 "T_base_hole": {"position_m": [0.6, 0.1, 0.15], "quat_wxyz": [1, 0, 0, 0]}}"#;
const CONTACTS: &str = "0.1,0.2,0.3,-1.4,0.5,0.6,0.7\n0.2,0.2,0.3,-1.4,0.5,0.6,0.7\n";
const OUTLINE: &str = "x_mm,y_mm\n-10,-10\n10,-10\n10,10\n-10,10\n";
const PROBLEM: &str = r#"
[robot]
builtin = "iiwa14"
[tool]
kind = "peg"
outline = "peg.csv"
length_mm = 40
[[fixture]]
name = "hole"
kind = "hole"
base_from_fixture = { xyz_mm = [600, 100, 150] }
outline_offset_mm = 0.5
depth_mm = 30
[[contacts]]
file = "log.csv"
fixture = "hole"
[estimate]
parameters = ["strain"]
"#;

fn write(path: &Path, text: &str) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, text).unwrap();
}

/// `text` with some of it replaced.
fn mutated(text: &str, at: usize, cut: usize, with: &str) -> String {
    let at = at % text.len();
    let mut text = text.to_owned();
    text.replace_range(at..(at + cut).min(text.len()), with);
    text
}

/// The error names the file and keeps to one line.
fn answered<T>(result: Result<T, touchcal::io::IoError>, file: &str) {
    if let Err(error) = result {
        let message = error.to_string();
        assert!(message.contains(file) && message.lines().count() == 1, "{message}");
    }
}

#[test]
fn what_is_mutated_below_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let arm = urdf::read_builtin("iiwa14", Ends::default()).unwrap();
    write(&folder.path().join("one/truth.json"), TRUTH);
    write(&folder.path().join("one/contact.csv"), CONTACTS);
    assert_eq!(trial_folder::read(folder.path(), &arm.robot).unwrap()[0].contacts.len(), 2);
    write(&folder.path().join("mukca/front/hole_0.csv"), CONTACTS);
    let read = mukca::read(&folder.path().join("mukca"), arm, &MukcaOptions::default()).unwrap();
    assert_eq!(read.problem.contacts.len(), 2);
    write(&folder.path().join("peg.csv"), OUTLINE);
    write(&folder.path().join("log.csv"), CONTACTS);
    problem_file::read(PROBLEM, "problem.toml", folder.path()).unwrap();
}

#[test]
fn the_truth_of_a_recorded_trial_is_read_as_that_of_a_simulation() {
    let folder = tempfile::tempdir().unwrap();
    let robot = urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot;
    let path = folder.path().join("truth.json");
    let read = |text: &str| {
        write(&path, text);
        truth_file::read_file(&path, &robot)
    };
    let simulated = r#"{"parameters": {"strain": 0.05, "joint_offset.joint_a7": 0.1}}"#;
    let [recorded, simulated] = [TRUTH, simulated].map(|text| read(text).unwrap());
    assert_eq!(recorded.by_name.len(), 8);
    for (name, value) in &simulated.by_name {
        assert_eq!(recorded.by_name[name], *value);
    }
    let not_zero = |truth: &truth_file::TruthFile| {
        let each = truth.parameters.iter().zip(&truth.values);
        each.filter(|(_, value)| **value != 0.0).map(|(id, value)| (*id, *value)).collect::<Vec<_>>()
    };
    assert_eq!(not_zero(&recorded), not_zero(&simulated));
    for text in ["{}", r#"{"r": 0.05}"#, r#"{"r": 0.05, "b_rad": [0.1]}"#, r#"{"b_rad": [0, 0, 0, 0, 0, 0, 0.1]}"#] {
        let refused = read(text).unwrap_err().to_string();
        assert!(refused.contains("expected `parameters`, as of a simulation, or `r` and `b_rad`"), "{refused}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn mutated_truths_are_answered(at in 0..1000usize, cut in 0..40usize, with in "[\\[\\]{}\":, a-z0-9.\\-]{0,6}") {
        let folder = tempfile::tempdir().unwrap();
        let robot = urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot;
        write(&folder.path().join("one/truth.json"), &mutated(TRUTH, at, cut, &with));
        write(&folder.path().join("one/contact.csv"), CONTACTS);
        answered(trial_folder::read(folder.path(), &robot), "truth.json");
    }

    #[test]
    fn mutated_sockets_are_answered(at in 0..1000usize, cut in 0..40usize, with in "\\PC{0,6}", name in "hole_[0-9]{1,3}") {
        let folder = tempfile::tempdir().unwrap();
        let arm = urdf::read_builtin("iiwa14", Ends::default()).unwrap();
        write(&folder.path().join(format!("front/{name}.csv")), &mutated(CONTACTS, at, cut, &with));
        answered(mukca::read(folder.path(), arm, &MukcaOptions::default()), &folder.path().display().to_string());
    }

    #[test]
    fn mutated_outlines_are_answered(at in 0..1000usize, cut in 0..20usize, with in "[x_m,y0-9.\\-e\\n\" ]{0,6}") {
        let folder = tempfile::tempdir().unwrap();
        write(&folder.path().join("peg.csv"), &mutated(OUTLINE, at, cut, &with));
        write(&folder.path().join("log.csv"), CONTACTS);
        answered(problem_file::read(PROBLEM, "problem.toml", folder.path()), "");
    }
}
