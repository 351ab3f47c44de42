//! Derivatives by errors of encoders and of the wrench against central differences.

use std::sync::Arc;

use super::*;
use crate::contact::{ContactLog, Source, target_pose};
use crate::estimate::problem::{Fixture, PlacePrior, Problem, ShapeTolerance, Tool, WrenchTolerance};
use crate::io::urdf::{self, Ends};
use crate::manifold::{BallInSocket, Target};
use crate::parameter::{
    Parameter, joint_backlash, joint_compliance, joint_gear_ratio, joint_harmonic, joint_harmonic_2, joint_offset,
    joint_origin, joint_trend, joint_walk,
};

/// Five contacts of an arm whose encoders have offsets, trends, harmonics and gear ratios.
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
    let of_log = [joint_trend(&robot), joint_walk(&robot, 1e-3)].concat();
    let of_encoders = [joint_harmonic(&robot), joint_harmonic_2(&robot), joint_gear_ratio(&robot)].concat();
    let parameters = [joint_offset(&robot), of_log, of_encoders].concat();
    let tool = Tool { tip_from_tool: Pose::translation(0.0, 0.0, 0.1), prior: PlacePrior::Fixed };
    Problem::new(robot, tool, vec![socket], contacts).with_parameters(parameters)
}

/// The same contacts, those of an even number under a load, by an arm whose compliances are
/// estimated.
fn wrench_problem() -> Problem {
    let mut problem = problem();
    let measured = std::mem::take(&mut problem.contacts);
    problem.contacts = ContactLog::new(measured.dof());
    for i in 0..measured.len() {
        problem.contacts.push(measured.q(i), 0, measured.source(i));
        if i % 2 == 0 {
            problem.contacts.set_load(std::array::from_fn(|k| 10.0 * (i as f64 + 2.0 * k as f64).cos()));
        }
    }
    let parameters = joint_compliance(&problem.robot);
    problem.with_parameters(parameters)
}

/// A load that is not known has no bias.
#[test]
fn derivatives_by_errors_of_the_wrench_are_those_of_differences() {
    const STEP: f64 = 1e-3;
    let problem = wrench_problem();
    let model = CalibrationModel::new(&problem);
    let value = |id| match id {
        ParameterId::WrenchBias(k) => 0.5 * (k as f64).sin(),
        ParameterId::WrenchScale => 0.05,
        _ => 1e-4,
    };
    let theta = DVector::from_iterator(model.layout.len(), model.layout.parameters.iter().map(|p| value(p.id)));
    let at = LinearizationPoint::new(&model, &theta);
    let (mut q, mut scratch) = (vec![0.0; at.dof()], at.scratch());
    for i in 0..problem.contacts.len() {
        let pose = at.pose_and_jacobian(i, &mut q, &mut scratch);
        for k in joint_compliance(&problem.robot).len()..theta.len() {
            let moved = |by: f64| {
                let mut theta = theta.clone();
                theta[k] += by;
                let point = LinearizationPoint::new(&model, &theta);
                se3::log(&(pose.inverse() * point.pose(i, &mut [0.0; 7])))
            };
            let difference = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
            let motion = at.tool_motion((k, i), None, &scratch);
            for (row, derivative) in motion.iter().enumerate() {
                let name = &model.layout.parameters[k].name;
                assert_eq!(difference.amax() > 1e-6, i % 2 == 0, "{name}, contact {i}");
                // Of up to 4e-3 rad for a scale of 1, and what a cubic term adds.
                assert!((derivative - difference[row]).abs() < 1e-8, "{name}, contact {i}: {derivative} {difference}");
            }
        }
    }
}

/// The same contacts, those of an even number with measured joint torques, by an arm whose origins
/// compliances and backlashes are estimated.
fn torque_problem() -> Problem {
    let mut problem = problem();
    let measured = std::mem::take(&mut problem.contacts);
    let mut contacts = ContactLog::new(measured.dof());
    for i in 0..measured.len() {
        contacts.push(measured.q(i), 0, measured.source(i));
        if i % 2 == 0 {
            let torques: Vec<f64> = (0..7).map(|k| 40.0 * (i as f64 + 2.0 * f64::from(k)).cos()).collect();
            contacts.set_joint_torques(&torques);
        }
    }
    let Problem { robot, tool, fixtures, .. } = problem;
    let deflections = [joint_compliance(&robot), joint_backlash(&robot)].concat();
    let parameters = [deflections, joint_origin(&robot), joint_offset(&robot)].concat();
    Problem::new(robot, tool, fixtures, contacts).with_parameters(parameters)
}

/// Measured torques deflect joints, whatever the posture; without them nothing does, not even
/// gravity.
#[test]
fn derivatives_by_deflections_under_measured_torques_are_those_of_differences() {
    let problem = torque_problem();
    let model = CalibrationModel::new(&problem);
    let theta = DVector::from_fn(model.layout.len(), |k, _| 1e-3 * (k as f64).cos());
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
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            let Parameter { name, id, .. } = &model.layout.parameters[k];
            if id.block().is_deflection() {
                assert_eq!(difference.amax() > 1e-3, i % 2 == 0, "{name}, contact {i}");
            }
            let motion = at.tool_motion((k, i), None, &scratch);
            assert!((motion - difference).amax() < 1e-7, "{name}, contact {i}: {motion} {difference}");
        }
    }
}

/// The wrench has parameters where joints deflect under a known load, those that are not exact.
#[test]
fn the_wrench_has_parameters_where_it_is_used() {
    let names = |problem: &Problem| {
        let parameters = CalibrationModel::new(problem).layout.parameters.into_iter();
        parameters.map(|p| p.name).filter(|name| name.starts_with("wrench")).collect::<Vec<_>>()
    };
    let all = ["fx", "fy", "fz", "tx", "ty", "tz"].map(|part| format!("wrench_bias.{part}"));
    let all = [&all[..], &["wrench_scale".to_owned()]].concat();
    let mut problem = wrench_problem();
    assert_eq!(names(&problem), all);
    problem.wrench = WrenchTolerance { force: 0.0, ..WrenchTolerance::DEFAULT };
    assert_eq!(names(&problem), all[3..]);
    problem.wrench = WrenchTolerance::EXACT;
    assert_eq!(names(&problem), [""; 0]);
    problem.wrench = WrenchTolerance::DEFAULT;
    let stiff = problem.clone().with_parameters(joint_offset(&problem.robot));
    assert_eq!(names(&stiff), [""; 0]);
    let compliance = joint_compliance(&problem.robot);
    let columns: Vec<_> = compliance.iter().filter_map(|parameter| parameter.id.kinematic()).collect();
    let bending = crate::robot::calibrated(&problem.robot, &columns, &[1e-5; 7]);
    assert_eq!(names(&Problem { robot: bending, ..stiff }), all);
    problem.contacts = ContactLog::new(7);
    assert_eq!(names(&problem), [""; 0]);
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
            let motion = at.tool_motion((k, i), None, &scratch);
            for (row, derivative) in motion.iter().enumerate() {
                let name = &model.layout.parameters[k].name;
                // Harmonics and gear ratios are of the measured position, so that derivatives are
                // exact.
                assert!(
                    (derivative - difference[row]).abs() < 1e-7,
                    "{name}, contact {i}: {derivative} {}",
                    difference[row]
                );
            }
        }
    }
}

/// A force of 10 N along x at the tip of a tool whose frame is 0.1 m further along z.
#[test]
fn the_load_on_the_tool_is_about_its_origin() {
    let mut problem = wrench_problem();
    problem.contacts.set_load([10.0, 0.0, 0.0, 0.0, 0.0, 2.0]);
    let model = CalibrationModel::new(&problem);
    let at = LinearizationPoint::new(&model, &DVector::zeros(model.layout.len()));
    let found = at.load_on_tool(problem.contacts.len() - 1);
    assert!((found - Twist::from([10.0, 0.0, 0.0, 0.0, -1.0, 2.0])).amax() < 1e-12, "{found}");
}

/// A fixture of unknown place whose contacts have targets, all but the first.
#[test]
fn derivatives_by_the_place_of_targets_are_those_of_differences() {
    const STEP: f64 = 1e-6;
    let mut problem = problem();
    let measured = std::mem::replace(&mut problem.contacts, ContactLog::new(7));
    for i in 0..measured.len() {
        problem.contacts.push(measured.q(i), 0, measured.source(i));
        if i > 0 {
            let place = Vector3::new(0.3, -0.2 * i as f64, 0.1);
            problem.contacts.set_target(target_pose(place, Some(Vector3::new(1.0, 0.4, i as f64))).expect("a normal"));
        }
    }
    let fixture = &mut problem.fixtures[0];
    (fixture.manifold, fixture.prior) = (Arc::new(Target::Point), PlacePrior::Flat);
    fixture.base_from_fixture = Some(se3::exp(&Twist::new(0.5, 0.1, 0.2, 0.3, -0.4, 1.1)));
    let problem = problem.with_parameters(Vec::new());
    let model = CalibrationModel::new(&problem);
    assert_eq!(model.layout.len(), 6);
    let theta = DVector::from_fn(6, |k, _| 0.1 * (k as f64).cos());
    let at = LinearizationPoint::new(&model, &theta);
    let (mut q, mut scratch) = (vec![0.0; at.dof()], at.scratch());
    for i in 0..problem.contacts.len() {
        let pose = at.pose_and_jacobian(i, &mut q, &mut scratch);
        let target = problem.contacts.target(i).copied().unwrap_or_default();
        let base_from_tool = at.kinematics.pose_under(&q, &problem.contacts.load(i));
        let expected = target.inverse() * at.fixtures[0].fixture_from_base * base_from_tool;
        assert!(se3::log(&(pose.inverse() * expected)).amax() < 1e-12);
        let motion = at.fixture_motion(i, &pose).expect("an estimated place");
        for k in 0..theta.len() {
            let moved = |by: f64| {
                let mut theta = theta.clone();
                theta[k] += by;
                let point = LinearizationPoint::new(&model, &theta);
                se3::log(&(pose.inverse() * point.pose(i, &mut [0.0; 7])))
            };
            let difference = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
            assert!((motion.column(k) - difference).amax() < 1e-8, "contact {i}: {} {difference}", motion.column(k));
        }
    }
}
