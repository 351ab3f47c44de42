//! Peg-in-hole logs of an independent physics simulator, with truth: does the estimator find it, and does it know how well?
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking"
)]

mod common;

use common::{mujoco_trial, mujoco_trials, solve};
use touchcal::estimate::{Status, evaluate};

/// Mean errors over the trials of one profile.
struct Errors {
    /// Mean absolute bias error (degrees).
    offset: f64,
    /// Mean absolute strain error.
    strain: f64,
    /// Parameters, and those within their 95 % interval.
    parameters: usize,
    inside: usize,
}

fn errors(profile: &str) -> Errors {
    let trials = mujoco_trials(profile);
    let mut errors = Errors { offset: 0.0, strain: 0.0, parameters: 0, inside: 0 };
    for trial in &trials {
        let (problem, truth) = mujoco_trial(trial);
        let estimate = solve(&problem);
        assert_eq!(estimate.status, Status::Converged, "{trial}: {:?}", estimate.termination);
        let truths = std::iter::once(truth.strain).chain(truth.offset.iter().copied());
        for (estimated, truth) in estimate.parameters.iter().zip(truths) {
            assert!(estimated.identifiable, "{trial}: {}", estimated.parameter.name);
            let error = (estimated.value - truth).abs();
            errors.parameters += 1;
            errors.inside += usize::from(error < 1.96 * estimated.sigma.expect("a standard deviation"));
            if estimated.parameter.name == "strain" {
                errors.strain += error / trials.len() as f64;
            } else {
                errors.offset += error.to_degrees() / (trials.len() * problem.robot.dof()) as f64;
            }
        }
    }
    println!(
        "{profile}: bias {:.5}°, strain {:.2e}, {} of {} within 95 %",
        errors.offset, errors.strain, errors.inside, errors.parameters
    );
    errors
}

#[test]
fn little_elbow_motion() {
    let found = errors("extrusion/paper");
    assert!(found.offset <= 0.012, "{}", found.offset);
    assert!(found.strain <= 6e-5, "{}", found.strain);
    assert!(found.inside as f64 >= 0.88 * found.parameters as f64, "{} of {}", found.inside, found.parameters);
}

#[test]
fn elbow_motion() {
    let found = errors("extrusion/rich");
    assert!(found.offset <= 0.002, "{}", found.offset);
    assert!(found.strain <= 3e-5, "{}", found.strain);
    assert!(found.inside as f64 >= 0.88 * found.parameters as f64, "{} of {}", found.inside, found.parameters);
}

#[test]
fn square_peg() {
    for (profile, offset, strain) in [("square/paper", 0.012, 6e-5), ("square/rich", 0.002, 3e-5)] {
        let found = errors(profile);
        assert!(found.offset <= offset, "{profile}: {}", found.offset);
        assert!(found.strain <= strain, "{profile}: {}", found.strain);
    }
}

/// The published size of the errors that the method must undo; and a start so far off that the poses lie centimetres away.
#[test]
fn nominal_arm_misses_the_hole_by_centimetres() {
    let (problem, _) = mujoco_trial("extrusion/paper/trial_00");
    let estimate = solve(&problem);
    let prefit = evaluate(&problem).all.mean;
    assert!(prefit > 5e-3, "{prefit}");
    assert!(estimate.postfit.all.mean < 30e-6, "{}", estimate.postfit.all.mean);
}
