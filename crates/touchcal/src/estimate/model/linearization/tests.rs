//! Derivatives by errors of encoders against central differences.

use std::sync::Arc;

use super::*;
use crate::contact::{ContactLog, Source};
use crate::estimate::problem::{Fixture, PlacePrior, Problem, ShapeTolerance, Tool};
use crate::io::urdf::{self, Ends};
use crate::manifold::BallInSocket;
use crate::parameter::{joint_harmonic, joint_offset, joint_trend};

/// Five contacts of an arm whose encoders have offsets, trends and harmonics.
fn problem() -> Problem {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut contacts = ContactLog::new(robot.dof());
    for line in 0..5 {
        let q: Vec<f64> = (0..7).map(|joint| (0.3 + 1.7 * joint as f64 + 0.9 * line as f64).sin()).collect();
        contacts.push(&q, 0, Source { file: 0, line });
    }
    let socket = Fixture {
        name: "socket".to_owned(),
        manifold: Arc::new(BallInSocket),
        base_from_fixture: Some(Pose::identity()),
        prior: PlacePrior::Fixed,
        tolerance: ShapeTolerance::EXACT,
        placement: String::new(),
    };
    let parameters = [joint_offset(&robot), joint_trend(&robot), joint_harmonic(&robot)].concat();
    let tool = Tool { tip_from_tool: Pose::translation(0.0, 0.0, 0.1), prior: PlacePrior::Fixed };
    Problem::new(robot, tool, vec![socket], contacts).with_parameters(parameters)
}

#[test]
fn derivatives_by_errors_of_encoders_are_those_of_differences() {
    const STEP: f64 = 1e-6;
    let problem = problem();
    let model = CalibrationModel::new(&problem);
    let theta = DVector::from_fn(model.layout.len(), |k, _| 0.01 * (k as f64).cos());
    let at = LinearizationPoint::new(&model, &theta);
    let (mut q, mut scratch) = (vec![0.0; at.dof()], at.scratch());
    for i in 0..problem.contacts.len() {
        let pose = at.pose_and_jacobian(i, &mut q, &mut scratch);
        for k in 0..theta.len() {
            let moved = |by: f64| {
                let mut theta = theta.clone();
                theta[k] += by;
                let point = LinearizationPoint::new(&model, &theta);
                se3::log(&(pose.inverse() * point.pose(i, &mut [0.0; 7])))
            };
            let difference = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
            for row in 0..6 {
                let unit = Twist::from_fn(|r, _| f64::from(u8::from(r == row)));
                let derivative = at.derivative((k, i), &unit, None, &scratch);
                let name = &model.layout.parameters[k].name;
                // A harmonic is that of the measured position, so that derivatives are exact.
                assert!(
                    (derivative - difference[row]).abs() < 1e-7,
                    "{name}, contact {i}: {derivative} {}",
                    difference[row]
                );
            }
        }
    }
}
