//! The real and simulated logs of the folder `data` are read whole.

use std::path::{Path, PathBuf};

use touchcal::contact::ContactLog;
use touchcal::contact::Detection;
use touchcal::io::contact_log::{self, Options};
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{KinematicParameter, calibrated};

use crate::support::data;

fn files_below(folder: &Path, name: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files_below(&path, name));
        } else if path.file_name().unwrap() == name {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn real_robots_and_their_logs_are_read() {
    let mukca = data().join("mukca");
    let sets =
        [("iiwa14", "kuka_14", 2), ("panda", "panda_1", 3), ("panda", "panda_3", 6), ("gen3lite", "dinova_2", 4)];
    for (arm, set, placements) in sets {
        let file = urdf::read_file(&mukca.join(format!("{arm}.urdf")), Ends::default()).unwrap();
        assert_eq!(file.robot.tip(), "ball_link");
        assert_eq!(urdf::rewrite(&file.text, &file.robot).unwrap(), file.text);
        let loaded = mukca::read(&mukca.join(set), file, &MukcaOptions::default()).unwrap();
        let problem = &loaded.problem;
        assert_eq!((problem.fixtures.len(), problem.distances.len()), (2 * placements, placements), "{set}");
        assert!(
            (0..problem.fixtures.len()).all(|f| (0..problem.contacts.len()).any(|i| problem.contacts.fixture(i) == f))
        );
        assert!(
            problem.contacts.len() >= 40 * placements && problem.contacts.rows_read() == problem.contacts.len() as u64
        );
    }
}

#[test]
fn real_robots_survive_being_rewritten() {
    for arm in ["iiwa14", "panda", "gen3lite"] {
        let file = urdf::read_file(&data().join(format!("mukca/{arm}.urdf")), Ends::default()).unwrap();
        let columns: Vec<KinematicParameter> =
            (0..file.robot.dof()).flat_map(|i| (0..6).map(move |k| KinematicParameter::JointOrigin(i, k))).collect();
        let theta: Vec<f64> = (0..columns.len()).map(|k| 0.01 * (k as f64).sin()).collect();
        let changed = calibrated(&file.robot, &columns, &theta);
        let text = urdf::rewrite(&file.text, &changed).unwrap();
        let back = urdf::read(&text, arm, Ends::default()).unwrap();
        for (a, b) in changed.joints().iter().zip(back.joints()) {
            let error = a.parent_from_joint.to_homogeneous() - b.parent_from_joint.to_homogeneous();
            assert!(error.norm() < 1e-12, "{arm} {}: {}", a.name, error.norm());
        }
    }
}

#[test]
fn simulated_logs_are_read_and_their_contacts_detected() {
    let folder = data().join("mujoco_iiwa14");
    let robot = urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot;
    let plain = Options::default();
    let contacts = files_below(&folder, "contact.csv.gz");
    assert!(!contacts.is_empty());
    for path in contacts {
        let mut log = ContactLog::new(robot.dof());
        contact_log::read_file(&path, &robot, &plain, &mut log).unwrap();
        assert_eq!((log.len(), log.rows_read()), (3000, 3000), "{}", path.display());
    }
    let detection = Some(Detection { threshold: 3.0, release: 3.0, debounce: 1 });
    let detecting = Options { detection, ..Options::default() };
    for path in files_below(&folder, "log.csv.gz") {
        let mut detected = ContactLog::new(robot.dof());
        contact_log::read_file(&path, &robot, &detecting, &mut detected).unwrap();
        let mut flagged = ContactLog::new(robot.dof());
        contact_log::read_file(&path, &robot, &plain, &mut flagged).unwrap();
        assert!(detected.len() >= 2900, "{}: {}", path.display(), detected.len());
        let differing = detected.len().abs_diff(flagged.len());
        assert!(differing * 100 <= flagged.len(), "{}: {} and {}", path.display(), detected.len(), flagged.len());
    }
}
