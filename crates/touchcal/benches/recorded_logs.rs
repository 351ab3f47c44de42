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

use support::{mujoco_problem, mujoco_trials, timed};

/// Number of times that each calibration is timed. The least time counts: machines are noisy.
const REPEATS: usize = 3;

const NOISE: &str = "[noise]\nencoder_deg = 0.002\ncontact_mm = 0.02\n";
const ESTIMATE: &str = "[estimate]\nparameters = [\"strain\", \"joint_offset\"]\n";

/// Least time (s) of a calibration of a log with this `noise`, whose result must be usable.
fn least(log: &str, noise: &str) -> f64 {
    let problem = mujoco_problem(log, "builtin = \"extrusion25\"", "", &format!("{noise}{ESTIMATE}"));
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
        let declared = least(log, NOISE);
        let estimated = least(log, "");
        slowest = slowest.max(declared).max(estimated);
        println!("{log} | {declared:.2} s | {estimated:.2} s");
    }
    println!("slowest: {slowest:.3} s");
}
