//! Somebody else's kind of touch: a stylus on a sphere of known radius, without any change to the
//! crate.

use std::sync::Arc;

use crate::support::solve;
use nalgebra::{UnitQuaternion, Vector3};
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::{Fixture, Loss, Method, Noise, PlacePrior, Problem, ShapeTolerance, Tool};
use touchcal::io::urdf::{self, Ends};
use touchcal::manifold::{ContactManifold, Residual};
use touchcal::parameter::joint_offset;
use touchcal::robot::{KinematicParameter, Kinematics};
use touchcal::se3::{self, Pose};
use touchcal::sim::follow;

// ANCHOR: sphere
/// Distance of the stylus tip from a sphere about the fixture's origin.
#[derive(Debug)]
struct Sphere {
    radius: f64,
}

impl ContactManifold for Sphere {
    fn name(&self) -> &'static str {
        "stylus on sphere"
    }

    fn residual(&self, fixture_from_tool: &Pose, _: f64, rows: &mut Residual) {
        let tip = fixture_from_tool.translation.vector;
        let normal_in_tool = fixture_from_tool.rotation.inverse() * tip.normalize();
        rows.push(tip.norm() - self.radius, se3::twist(&normal_in_tool, &Vector3::zeros()));
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2]
    }
}
// ANCHOR_END: sphere

#[test]
fn a_sphere_calibrates_the_joints_that_move_over_it() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let tip_from_tool = Pose::translation(0.03, 0.0, 0.12);
    let base_from_sphere = Pose::translation(0.55, 0.1, 0.2);
    let truth = [0.0, 0.02, -0.03, 0.01, 0.025, -0.015, 0.02];
    let columns: Vec<KinematicParameter> = (0..7).map(KinematicParameter::JointOffset).collect();
    let mut arm = Kinematics::new(&robot, &columns, tip_from_tool);
    arm.set(&truth);
    let posture = vec![0.1, 0.7, 0.2, -1.5, -0.2, 0.9, 0.1];
    let mut q = posture.clone();
    let mut contacts = ContactLog::new(7);
    for i in 0..300u32 {
        let phase = f64::from(i);
        let out = Vector3::new((phase * 0.37).sin(), (phase * 0.53).cos(), 1.2).normalize() * 0.1;
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(
            0.4 * (phase * 0.71).sin(),
            0.4 * (phase * 0.43).cos(),
            0.5 * (phase * 0.29).sin(),
        ));
        let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let bend: Vec<f64> = posture.iter().map(|q| q + 0.4 * (phase * 0.19 + q).sin()).collect();
        let target = base_from_sphere * Pose::from_parts(out.into(), turn * down);
        q = follow(&arm, &target, &q, &bend).expect("within reach");
        contacts.push(&q, 0, Source { file: 0, line: u64::from(i) + 1 });
    }
    let problem = Problem {
        parameters: joint_offset(&robot),
        robot,
        tool: Tool { tip_from_tool, prior: PlacePrior::Fixed },
        fixtures: vec![Fixture {
            name: "sphere".to_owned(),
            manifold: Arc::new(Sphere { radius: 0.1 }),
            base_from_fixture: Some(base_from_sphere),
            prior: PlacePrior::Fixed,
            tolerance: ShapeTolerance::EXACT,
            placement: String::new(),
        }],
        distances: Vec::new(),
        contacts,
        noise: Noise { encoder: 1e-6, contact: 1e-6, is_estimated: false },
        joint_drift: false,
        trend_variable: touchcal::estimate::TrendVariable::Log,
        wrench: touchcal::estimate::WrenchTolerance::DEFAULT,
        method: Method::LevenbergMarquardt,
        loss: Loss::Squared,
        options: touchcal::estimate::EstimatorOptions::default(),
        held_out: ContactLog::default(),
        acceptance: None,
        other_arms: Vec::new(),
    };
    let estimate = solve(&problem);
    assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
    for (estimated, truth) in estimate.parameters.iter().zip(truth) {
        assert!((estimated.value - truth).abs() < 1e-8, "{}: {}", estimated.parameter.name, estimated.value);
    }
}
