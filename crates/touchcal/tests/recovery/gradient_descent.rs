//! Gradient descent, as the paper searches: its gradient, and where it gets with an exact
//! projection of the gap.

use crate::support::{mujoco_trial, solve};
use touchcal::estimate::{GradientDescent, Method, Optimizer, Status};

/// Mean absolute bias (degrees) and strain error of gradient descent on the gaps of one trial.
fn errors(trial: &str, descent: GradientDescent) -> (f64, f64, Status) {
    let (mut problem, truth) = mujoco_trial(trial);
    problem.method = Method::GradientDescent(descent);
    let estimate = solve(&problem);
    let value = |k: usize| estimate.parameters[k].value;
    let offsets = truth.offset.iter().enumerate().map(|(i, offset)| (value(i + 1) - offset).abs());
    let offset = offsets.sum::<f64>().to_degrees() / truth.offset.len() as f64;
    println!("{trial}: {offset:.4}°, {:.1e}, {:?}", (value(0) - truth.strain).abs(), estimate.termination);
    (offset, (value(0) - truth.strain).abs(), estimate.status)
}

/// Far from the hole the gap is nearly a distance from its middle, so that descent comes home, if
/// not as far as a second-order method.
#[test]
#[ignore = "long form: scripts/test long"]
fn adam_on_exact_gaps_comes_near() {
    let (offset, strain, status) = errors("extrusion/rich/trial_00", GradientDescent::default());
    assert!(status.is_usable());
    assert!(offset < 0.05 && strain < 1e-3, "{offset}°, {strain}");
}

/// Where the elbow hardly moves the loss is a long narrow valley: against its gradient nothing
/// descends any more while the arm is still more than a degree off.
#[test]
fn adam_in_a_narrow_valley_has_not_converged() {
    for steps in [400, 600] {
        let (offset, _, status) =
            errors("extrusion/paper/trial_00", GradientDescent { steps, ..GradientDescent::default() });
        assert!(offset > 1.0 && !status.is_usable(), "{steps} steps: {offset}°");
    }
}

#[test]
fn plain_descent_comes_nearer_than_it_began() {
    let descent = GradientDescent { optimizer: Optimizer::Plain, rate: 0.3, steps: 1000, ..GradientDescent::default() };
    let (offset, strain, status) = errors("extrusion/rich/trial_00", descent);
    assert!(offset < 2.5 && strain < 0.025, "{offset}°, {strain}");
    assert!(!status.is_usable(), "it was still on its way");
}
