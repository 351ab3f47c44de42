//! Time and memory against the number of contacts, on one core. `cargo bench -p touchcal --bench scaling`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a bench prints its figures"
)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{mujoco_trial, solve};
use rayon::prelude::*;
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::Problem;
use touchcal::geometry::extrusion::PegAndHole;
use touchcal::geometry::profile::Profile;
use touchcal::robot::Column;
use touchcal::sim::{Compliance, Exploration, Insertion};

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

/// The insertion that `problem` describes, done by an arm with errors of the published size.
fn insertion(problem: &Problem) -> Insertion {
    let peg = Profile::extrusion25();
    let hole = peg.offset_mitred(0.5e-3).expect("an outline");
    let degrees = [2.0, -3.0, 1.5, 4.0, -2.5, 3.5, -1.0f64];
    let offsets = degrees.iter().enumerate().map(|(joint, b)| (Column::JointOffset(joint), b.to_radians()));
    Insertion {
        robot: problem.robot.clone(),
        errors: std::iter::once((Column::Strain, 0.02)).chain(offsets).collect(),
        tip_from_peg: problem.tool.tip_from_tool,
        base_from_hole: problem.fixtures[0].base_from_fixture.expect("a known hole"),
        parts: PegAndHole::new(peg, 0.04, hole, 0.03).expect("parts"),
        posture: vec![0.0, 0.73, 0.26, -1.56, -0.23, 0.87, -0.02],
        compliance: Compliance { translation: 3000.0, rotation: 30.0, contact: 5e6 },
        exploration: Exploration { radius: 2e-3, tilt: 0.04, swing: 0.2, rate: 300.0 },
        encoder_sigma: problem.noise.encoder,
        contact_sigma: problem.noise.contact,
        force_threshold: 3.0,
    }
}

/// Explores until the log has `count` contacts, with new noise in each run.
fn explore(insertion: &Insertion, contacts: &mut ContactLog, count: usize) {
    let missing: Vec<usize> = (contacts.len()..count).step_by(RUN).collect();
    for starts in missing.chunks(RUNS_AT_ONCE) {
        let run = |&start: &usize| insertion.run(RUN.min(count - start), start as u64).expect("contacts").q;
        let runs: Vec<Vec<Vec<f64>>> = starts.par_iter().map(run).collect();
        for q in runs.iter().flatten() {
            let line = contacts.len() as u64 + 1;
            contacts.push(q, 0, Source { file: 0, line });
        }
    }
}

fn main() {
    let (mut problem, _) = mujoco_trial("extrusion/rich/trial_00");
    let insertion = insertion(&problem);
    problem.contacts = ContactLog::new(problem.robot.dof());
    problem.contacts.add_file("simulated");
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let base = peak_memory();
    println!("{:>10} {:>10} {:>14} {:>18}", "contacts", "seconds", "µs a contact", "bytes a contact");
    for count in COUNTS {
        explore(&insertion, &mut problem.contacts, count);
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
