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

use std::time::Instant;

use common::{mujoco_trial, solve};
use touchcal::contact::ContactLog;

/// Most memory that this process has held so far (bytes), where the system tells.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes * 1024.0)
}

fn main() {
    let (mut problem, _) = mujoco_trial("extrusion/rich/trial_00");
    let logged = problem.contacts.clone();
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let base = peak_memory();
    println!("{:>10} {:>10} {:>14} {:>18}", "contacts", "seconds", "µs a contact", "bytes a contact");
    for count in [3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000] {
        let mut contacts = ContactLog::new(logged.dof());
        contacts.add_file("tiled");
        for i in 0..count {
            // Each pass over the log is moved a little, so that no contact comes twice.
            let (pass, row) = (i / logged.len(), i % logged.len());
            let nudge = |joint: usize| 1e-5 * ((pass * (joint + 3)) as f64).sin();
            let q: Vec<f64> = logged.q(row).iter().enumerate().map(|(joint, q)| q + nudge(joint)).collect();
            contacts.push(&q, 0, logged.source(row));
        }
        problem.contacts = contacts;
        let start = Instant::now();
        let estimate = one_core.install(|| solve(&problem));
        let seconds = start.elapsed().as_secs_f64();
        let memory = peak_memory().zip(base).map_or(f64::NAN, |(peak, base)| (peak - base) / count as f64);
        let each = 1e6 * seconds / count as f64;
        let steps = estimate.termination.iterations;
        println!("{count:>10} {seconds:>10.3} {each:>14.1} {memory:>18.0}   {:?} in {steps} steps", estimate.status);
    }
}
