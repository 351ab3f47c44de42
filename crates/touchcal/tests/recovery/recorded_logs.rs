//! Peg-in-hole logs of an independent physics simulator, with truth: does the estimator find it,
//! and does it know how well?

use std::ops::ControlFlow;

use crate::support::{mujoco_trial, mujoco_trials, report, solve, spread};
use touchcal::estimate::{StopReason, calibrate, evaluate};

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

/// Most that the mean errors may be (degrees, and the strain's).
#[derive(Clone, Copy)]
struct Limits {
    offset: f64,
    strain: f64,
}

const LITTLE_ELBOW_MOTION: Limits = Limits { offset: 0.012, strain: 6e-5 };
const ELBOW_MOTION: Limits = Limits { offset: 0.002, strain: 3e-5 };

fn errors(profile: &str, limits: Limits) -> Errors {
    let trials = mujoco_trials(profile);
    let (mut offset, mut strain, mut inside) = (Vec::new(), Vec::new(), 0);
    for trial in &trials {
        let (problem, truth) = mujoco_trial(trial);
        let estimate = solve(&problem);
        assert!(estimate.status.is_usable(), "{trial}: {:?}", estimate.termination);
        let truths = std::iter::once(truth.strain).chain(truth.offset.iter().copied());
        for (estimated, truth) in estimate.parameters.iter().zip(truths) {
            assert!(estimated.identifiable, "{trial}: {}", estimated.parameter.name);
            let error = (estimated.value - truth).abs();
            inside += usize::from(error < 1.96 * estimated.sigma.expect("a standard deviation"));
            if estimated.parameter.name == "strain" {
                strain.push(error);
            } else {
                offset.push(error.to_degrees());
            }
        }
    }
    let parameters = offset.len() + strain.len();
    let (offset, strain) = (spread(offset), spread(strain));
    report(&format!("{profile}, encoder offsets (°)"), &[offset.as_slice(), &[("limit", limits.offset)]].concat());
    report(&format!("{profile}, strain"), &[strain.as_slice(), &[("limit", limits.strain)]].concat());
    let count = |name, count: usize| (name, count as f64);
    report(profile, &[count("trials", trials.len()), count("inside", inside), count("of", parameters)]);
    let errors = Errors { offset: offset[0].1, strain: strain[0].1, parameters, inside };
    assert!(errors.offset <= limits.offset, "{profile}: {}", errors.offset);
    assert!(errors.strain <= limits.strain, "{profile}: {}", errors.strain);
    errors
}

#[test]
fn little_elbow_motion() {
    let found = errors("extrusion/paper", LITTLE_ELBOW_MOTION);
    assert!(found.inside as f64 >= 0.88 * found.parameters as f64, "{} of {}", found.inside, found.parameters);
}

#[test]
fn elbow_motion() {
    let found = errors("extrusion/rich", ELBOW_MOTION);
    assert!(found.inside as f64 >= 0.88 * found.parameters as f64, "{} of {}", found.inside, found.parameters);
}

#[test]
fn square_peg() {
    errors("square/paper", LITTLE_ELBOW_MOTION);
    errors("square/rich", ELBOW_MOTION);
}

/// The published size of the errors that the method must undo; and a start so far off that the
/// poses lie centimetres away.
#[test]
fn nominal_arm_misses_the_hole_by_centimetres() {
    let (problem, _) = mujoco_trial("extrusion/paper/trial_00");
    let estimate = solve(&problem);
    let prefit = evaluate(&problem).all.mean;
    assert!(prefit > 5e-3, "{prefit}");
    assert!(estimate.postfit.all.mean < 30e-6, "{}", estimate.postfit.all.mean);
}

/// Wherever in the search the caller says stop, that is the end of it; with noise to be learned,
/// too.
#[test]
fn a_search_that_is_told_to_stop_stops() {
    stops_at_every(7);
}

#[test]
#[ignore = "long form: scripts/test long"]
fn a_search_that_is_told_to_stop_stops_at_each_step() {
    stops_at_every(1);
}

fn stops_at_every(stride: usize) {
    let (declared, _) = mujoco_trial("square/rich/trial_00");
    let mut learned = declared.clone();
    learned.noise.is_estimated = true;
    for problem in [declared, learned] {
        let mut steps = 0;
        let mut until = |last: usize| {
            steps = 0;
            let estimate = calibrate(&problem, &mut |_| {
                steps += 1;
                if steps < last { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            (estimate.termination.reason, steps)
        };
        let (reason, all) = until(usize::MAX);
        assert_eq!(reason, StopReason::Converged);
        for last in (1..=all).step_by(stride) {
            assert_eq!(until(last), (StopReason::Interrupted, last));
        }
    }
}
