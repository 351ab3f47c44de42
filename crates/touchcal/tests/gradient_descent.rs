//! Gradient descent, as the paper searches: its gradient, and where it gets with an exact projection of the gap.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking"
)]

mod common;

use common::{mujoco_trial, solve};
use touchcal::estimate::{Descent, Method, Optimiser, Status};

/// Mean absolute bias (degrees) and strain error of gradient descent on the gaps of one trial.
fn errors(trial: &str, descent: Descent) -> (f64, f64, Status) {
    let (mut problem, truth) = mujoco_trial(trial);
    problem.method = Method::GradientDescent(descent);
    let estimate = solve(&problem);
    let value = |k: usize| estimate.parameters[k].value;
    let offsets = truth.offset.iter().enumerate().map(|(i, offset)| (value(i + 1) - offset).abs());
    let offset = offsets.sum::<f64>().to_degrees() / truth.offset.len() as f64;
    println!("{trial}: {offset:.4}°, {:.1e}, {:?}", (value(0) - truth.strain).abs(), estimate.termination);
    (offset, (value(0) - truth.strain).abs(), estimate.status)
}

/// Far from the hole the gap is nearly a distance from its middle, so that descent comes home, if not as far as a second-order method.
#[test]
fn adam_on_exact_gaps_comes_near() {
    let (offset, strain, status) = errors("extrusion/rich/trial_00", Descent::default());
    assert_eq!(status, Status::Converged);
    assert!(offset < 0.05 && strain < 1e-3, "{offset}°, {strain}");
}

#[test]
fn plain_descent_comes_nearer_than_it_began() {
    let descent = Descent { optimiser: Optimiser::Plain, rate: 0.3, steps: 1000, ..Descent::default() };
    let (offset, strain, status) = errors("extrusion/rich/trial_00", descent);
    assert!(offset < 2.5 && strain < 0.025, "{offset}°, {strain}");
    assert_ne!(status, Status::Converged, "it was still on its way");
}
