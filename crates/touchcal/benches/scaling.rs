//! Time and memory against the number of contacts, on one core. `cargo bench -p touchcal --bench
//! scaling`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a bench prints its figures"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::ops::ControlFlow;

use rayon::prelude::*;
use support::{mujoco_trial, solve};
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::Problem;
use touchcal::sim::{self, Log, Preset, Scenario, Truth};

const COUNTS: [usize; 6] = [3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000];
/// Contacts simulated in one go.
const RUN: usize = 10_000;
/// Runs simulated at a time: what they hold counts as memory.
const RUNS_AT_ONCE: usize = 4;

/// Most memory that this process has held so far (bytes), where the system tells.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes * 1024.0)
}

/// Processor time of this thread (s): other processes do not count.
fn processor_seconds() -> f64 {
    let times = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    times.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}

/// The exploration that `problem` describes, with elbow motion, by an arm with errors of the
/// published size.
fn scenario(problem: &Problem) -> (Scenario, Truth) {
    let mut scenario = Preset::Paper.scenario(problem.robot.clone()).expect("parts");
    scenario.touches[0].exploration.swing = 0.2;
    scenario.contact_sigma = problem.noise.contact;
    scenario.recorder.encoder_sigma = problem.noise.encoder;
    let truth = sim::draw_truth(&scenario, 1);
    (scenario, truth)
}

/// Explores until the log has `count` contacts, with new noise in each run.
fn explore(scenario: &Scenario, truth: &Truth, contacts: &mut ContactLog, count: usize) {
    let missing: Vec<usize> = (contacts.len()..count).step_by(RUN).collect();
    for starts in missing.chunks(RUNS_AT_ONCE) {
        let run = |&start: &usize| {
            let scenario = Scenario { contacts: RUN.min(count - start), ..scenario.clone() };
            sim::run(&scenario, truth, start as u64, &mut |_| ControlFlow::Continue(())).expect("contacts")
        };
        let runs: Vec<Vec<Log>> = starts.par_iter().map(run).collect();
        for log in runs.iter().flatten() {
            for row in log.contacts() {
                let line = contacts.len() as u64 + 1;
                contacts.push(log.q(row), 0, Source { file: 0, line });
            }
        }
    }
}

fn main() {
    let (mut problem, _) = mujoco_trial("extrusion/rich/trial_00");
    let (scenario, truth) = scenario(&problem);
    problem.contacts = ContactLog::new(problem.robot.dof());
    problem.contacts.add_file("simulated");
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let base = peak_memory();
    println!("{:>10} {:>10} {:>14} {:>18}", "contacts", "seconds", "µs a contact", "bytes a contact");
    for count in COUNTS {
        explore(&scenario, &truth, &mut problem.contacts, count);
        let (estimate, seconds) = one_core.install(|| {
            let start = processor_seconds();
            let estimate = solve(&problem);
            (estimate, processor_seconds() - start)
        });
        let memory = peak_memory().zip(base).map_or(f64::NAN, |(peak, base)| (peak - base) / count as f64);
        let each = 1e6 * seconds / count as f64;
        let steps = estimate.termination.iterations;
        println!("{count:>10} {seconds:>10.3} {each:>14.1} {memory:>18.0}   {:?} in {steps} steps", estimate.status);
    }
}
