//! Contacts that contradict what was declared: the result must not be called usable.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking"
)]

mod common;

use common::{mujoco_trial, solve};
use touchcal::estimate::{Estimate, Freedom, Status, Warning};
use touchcal::geometry::extrusion::PegAndHole;
use touchcal::geometry::profile::Profile;
use touchcal::manifold::PegInHole;

fn warned(estimate: &Estimate, kind: &str) -> bool {
    estimate.warnings.iter().any(|warning: &Warning| warning.kind() == kind)
}

#[test]
fn noise_declared_much_too_small_is_contradicted() {
    let (mut problem, _) = mujoco_trial("extrusion/rich/trial_00");
    problem.noise.encoder *= 0.1;
    problem.noise.contact *= 0.1;
    let estimate = solve(&problem);
    assert!(warned(&estimate, "noise_contradicted"), "{} {:?}", estimate.noise_factor, estimate.warnings);
    assert_eq!(estimate.status, Status::NotUsable);
}

#[test]
fn noise_declared_a_little_too_small_is_a_warning() {
    let (mut problem, _) = mujoco_trial("extrusion/rich/trial_00");
    problem.noise.encoder /= 3.0;
    problem.noise.contact /= 3.0;
    let estimate = solve(&problem);
    assert!(warned(&estimate, "noise_exceeded"), "{} {:?}", estimate.noise_factor, estimate.warnings);
    assert_eq!(estimate.status, Status::Converged);
}

#[test]
fn a_hole_declared_too_wide_is_not_touched() {
    let (mut problem, _) = mujoco_trial("extrusion/rich/trial_00");
    let peg = Profile::extrusion25();
    let hole = peg.offset_mitred(1.3e-3).expect("an outline");
    let shapes = PegAndHole::new(peg, 0.04, hole, 0.03).expect("parts");
    problem.fixtures[0].manifold = Box::new(PegInHole::new(shapes));
    let estimate = solve(&problem);
    assert!(warned(&estimate, "not_touching"), "{:?}", estimate.warnings);
    assert_eq!(estimate.status, Status::NotUsable);
}

/// With nothing known of the hole's place, little elbow motion can lead into a wrong minimum: it must not pass for a result.
#[test]
fn a_wrong_minimum_is_not_called_usable() {
    for trial in ["extrusion/paper/trial_25", "square/paper/trial_00"] {
        let (mut problem, truth) = mujoco_trial(trial);
        problem.fixtures[0].freedom = Freedom::Free;
        let estimate = solve(&problem);
        // The first offset cannot be told from the hole's yaw.
        let errors = estimate.parameters[2..8].iter().zip(&truth.offset[1..]).map(|(p, truth)| (p.value - truth).abs());
        let worst = errors.fold(0.0, f64::max).to_degrees();
        println!("{trial}: {:?}, worst offset error {worst:.2}°", estimate.status);
        assert!(worst < 0.5 || estimate.status == Status::NotUsable, "{trial}: {worst}° {:?}", estimate.warnings);
    }
}
