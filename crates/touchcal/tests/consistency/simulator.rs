//! Is the simulated exploration like that of an independent physics simulator? Statistics of the
//! preset `paper` beside those of the MuJoCo logs.

use std::io::Read;

use crate::support::{data, report};
use touchcal::experiment::Trial;
use touchcal::geometry::{Parts, PrismPair, visit_features_within};
use touchcal::io::trial_folder;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::Kinematics;
use touchcal::sim::{self, Preset, Scenario};

/// Pairs of features that differ by less than encoder noise moves them (m).
const NEAR: f64 = 0.1e-3;
/// Deeper than this (m) the peg is in the hole rather than on its rim.
const INSIDE: f64 = 1e-3;

/// What a trial looks like.
#[derive(Debug, Default)]
struct Statistics {
    /// Share of the log's rows in contact.
    contacts: f64,
    /// Share of the contacts in the hole.
    inside: f64,
    /// Quarter, half and three quarters of the contacts have less force (N).
    force: [f64; 3],
    /// Standard deviations in the hole: of x, y and z (mm), of the rotations about them (degrees).
    spread: [f64; 6],
    /// Mean number of pairs of features near touching.
    near: f64,
}

/// Poses are computed from measured joint positions with the true arm, in both kinds of log.
fn statistics(trial: &Trial, parts: &PrismPair, rows: usize, mut force: Vec<f64>) -> Statistics {
    let arm = Kinematics::new(&trial.true_robot(), &[], trial.tip_from_peg);
    let contacts = &trial.contacts;
    let poses = (0..contacts.len()).map(|i| trial.base_from_hole.inverse() * arm.pose(contacts.q(i)));
    let inside: Vec<_> = poses.filter(|pose| pose.translation.z < -INSIDE).collect();
    let spread = |k: usize| {
        let value = |pose: &touchcal::se3::Pose| match k {
            0..3 => 1e3 * pose.translation.vector[k],
            _ => pose.rotation.scaled_axis()[k - 3].to_degrees(),
        };
        let mean = inside.iter().map(value).sum::<f64>() / inside.len() as f64;
        (inside.iter().map(|pose| (value(pose) - mean).powi(2)).sum::<f64>() / inside.len() as f64).sqrt()
    };
    let mut near = 0;
    for pose in &inside {
        visit_features_within(parts, pose, NEAR, |_, _| near += 1);
    }
    force.sort_unstable_by(f64::total_cmp);
    Statistics {
        contacts: contacts.len() as f64 / rows as f64,
        inside: inside.len() as f64 / contacts.len() as f64,
        force: [25, 50, 75].map(|percent| force[force.len() * percent / 100]),
        spread: std::array::from_fn(spread),
        near: near as f64 / inside.len() as f64,
    }
}

/// Rows of a MuJoCo log, and the forces of its contacts (N).
fn logged(trial: &str) -> (usize, Vec<f64>) {
    let path = data().join("mujoco_iiwa14/extrusion/paper").join(trial).join("log.csv.gz");
    let mut text = String::new();
    flate2::read::MultiGzDecoder::new(std::fs::File::open(path).unwrap()).read_to_string(&mut text).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let forces = rows.iter().filter(|row| row[15] > 0.5).map(|row| row[9].hypot(row[10]).hypot(row[11])).collect();
    (rows.len(), forces)
}

fn mean(all: &[Statistics], value: impl Fn(&Statistics) -> f64) -> f64 {
    all.iter().map(value).sum::<f64>() / all.len() as f64
}

#[test]
fn explorations_are_like_those_of_mujoco() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot;
    let scenario = Preset::Paper.scenario(robot.clone()).unwrap();
    let Parts::PegInHole(parts) = &scenario.touches[0].parts else { panic!("a hole") };
    let recorded = trial_folder::read(&data().join("mujoco_iiwa14/extrusion/paper"), &robot).unwrap();
    let recorded: Vec<Statistics> = recorded
        .iter()
        .map(|trial| {
            let (rows, force) = logged(&trial.name);
            statistics(trial, parts, rows, force)
        })
        .collect();
    let simulate = |seed: u64| {
        let scenario = Scenario { contacts: 3000, ..scenario.clone() };
        let log = &sim::simulate(&scenario, seed).unwrap().logs[0];
        let force = log.contacts().map(|row| log.truth[row].force).collect();
        statistics(&Trial::simulated(&scenario, seed).unwrap(), parts, log.len(), force)
    };
    let simulated: Vec<Statistics> = (1..=4).map(simulate).collect();
    let both = |value: &dyn Fn(&Statistics) -> f64| (mean(&recorded, value), mean(&simulated, value));
    let mut ratios = Vec::new();
    let mut compare = |name: &str, value: &dyn Fn(&Statistics) -> f64, most: f64| {
        let (recorded, simulated) = both(value);
        report(name, &[("mujoco", recorded), ("simulated", simulated), ("limit", most)]);
        ratios.push((name.to_owned(), simulated / recorded, most));
    };
    // Both are explorations of the same hole for ten seconds, each with its own command: shares of
    // rows agree to a quarter.
    compare("contacts, share of rows", &|s| s.contacts, 1.25);
    compare("in the hole, share of contacts", &|s| s.inside, 1.25);
    // The clearance bounds all but z, whatever the command.
    for (k, name) in ["x mm", "y mm", "z mm", "rx deg", "ry deg", "rz deg"].into_iter().enumerate() {
        compare(&format!("spread of {name}"), &|s| s.spread[k], 1.75);
    }
    // The arm's stiffness and press are a choice; impacts and friction, which MuJoCo has, lengthen
    // only the upper tail.
    for (k, name) in ["25 %", "50 %", "75 %"].into_iter().enumerate() {
        compare(&format!("force N, {name}"), &|s| s.force[k], 1.75);
    }
    compare("features near touching", &|s| s.near, 1.5);
    for (name, ratio, most) in ratios {
        assert!(ratio < most && ratio > 1.0 / most, "{name}: {ratio:.2} times MuJoCo's");
    }
}
