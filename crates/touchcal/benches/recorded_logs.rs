//! Calibrations of the recorded logs with 3000 contacts of a T-slot peg, all tests on and nothing
//! exact, with declared and with estimated noise; on one core.
//! `cargo bench -p touchcal --bench recorded_logs`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a bench prints its figures"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use support::{data, mujoco_trials, timed};
use touchcal::io::problem_file;

/// Number of times that each calibration is timed. The least time counts: machines are noisy.
const REPEATS: usize = 3;

const PROBLEM: &str = r#"
[robot]
builtin = "iiwa14"
[tool]
kind = "peg"
tip_from_tool = { xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }
builtin = "extrusion25"
length_mm = 40
[[fixture]]
name = "hole"
kind = "hole"
base_from_fixture = { xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }
outline_offset_mm = 0.5
depth_mm = 30
[[contacts]]
file = "contact.csv.gz"
fixture = "hole"
[estimate]
parameters = ["strain", "joint_offset"]
"#;
const NOISE: &str = "[noise]\nencoder_deg = 0.002\ncontact_mm = 0.02\n";

/// Least time (s) of a calibration of a log, whose result must be usable.
fn least(log: &str, problem: &str) -> f64 {
    let folder = data().join("mujoco_iiwa14").join(log);
    let problem = problem_file::read(problem, "problem.toml", &folder).unwrap().problem;
    let time = |_| {
        let (estimate, time) = timed(&problem);
        assert!(estimate.status.is_usable(), "{log}");
        time
    };
    (0..REPEATS).map(time).fold(f64::INFINITY, f64::min)
}

fn main() {
    let logs = ["extrusion/paper", "extrusion/rich"].map(mujoco_trials).concat();
    let mut slowest: f64 = 0.0;
    println!("log | noise declared | noise estimated");
    for log in &logs {
        let declared = least(log, &format!("{PROBLEM}{NOISE}"));
        let estimated = least(log, PROBLEM);
        slowest = slowest.max(declared).max(estimated);
        println!("{log} | {declared:.2} s | {estimated:.2} s");
    }
    println!("slowest: {slowest:.3} s");
}
