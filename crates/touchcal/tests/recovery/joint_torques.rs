//! Joint torques that are measured: joints deflect by them, whatever the arm weighs.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use touchcal::contact::ContactLog;
use touchcal::estimate::{
    Estimate, EstimatorOptions, Problem, Status, Warning, apply_estimated_places, evaluate, tool_uncertainty,
};
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{Block, joint_offset};
use touchcal::robot::{Inertia, Joint, JointKind, Robot};
use touchcal::sim::{self, ArmErrors, Preset, Scenario, SimulatedTrial};

use crate::support::{report, solve};

fn iiwa() -> Robot {
    urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot
}

/// An iiwa 14 whose links have masses, which joints of 5e-5 rad/(N m) carry, with a ball in
/// sockets.
fn bending() -> Scenario {
    let weighed = |joint: &Joint| {
        let inertia = Inertia { mass: 4.0, center: Vector3::new(0.02, -0.03, 0.1) };
        Joint { inertia: (joint.kind != JointKind::Fixed).then_some(inertia), ..joint.clone() }
    };
    let iiwa = iiwa();
    let joints = iiwa.joints().iter().map(weighed).collect();
    let robot = Robot::new(iiwa.name(), iiwa.base(), joints).expect("a chain");
    let mut scenario = Preset::Mukca.scenario(robot).expect("parts");
    scenario.errors = ArmErrors { joint_offset: 2e-3, joint_compliance: 5e-5, ..ArmErrors::NONE };
    scenario.recorder.joint_torque_sigma = 0.1;
    scenario.contacts = 40;
    scenario
}

/// The problem of a trial, with an arm of unknown masses.
fn weightless(scenario: &Scenario, simulated: &SimulatedTrial) -> Problem {
    let posed = problem(scenario, simulated);
    assert!(posed.contacts.has_joint_torques() && !posed.contacts.has_loads());
    let robot = iiwa();
    assert!(!robot.has_masses());
    Problem { robot: robot.with_measured_torques(), ..posed }
}

/// The problem with these torques in place of the measured ones.
fn with_torques(problem: &Problem, torque: impl Fn(f64) -> f64) -> Problem {
    let measured = &problem.contacts;
    let mut contacts = ContactLog::new(measured.dof());
    for file in measured.files() {
        contacts.add_file(file);
    }
    for i in 0..measured.len() {
        contacts.push(measured.q(i), measured.fixture(i), measured.source(i));
        let torques: Vec<f64> = measured.joint_torques(i).expect("measured").iter().map(|t| torque(*t)).collect();
        contacts.set_joint_torques(&torques);
    }
    Problem { contacts, ..problem.clone() }
}

/// Errors of the parameters of a block over their standard deviations.
fn deviations(estimate: &Estimate, simulated: &SimulatedTrial, block: Block) -> Vec<f64> {
    let of_block = estimate.parameters.iter().filter(|entry| entry.parameter.id.block() == block);
    let deviation = |entry: &touchcal::estimate::ParameterEstimate| {
        (entry.value - simulated.truth.value(entry.parameter.id)) / entry.sigma.expect("a standard deviation")
    };
    of_block.map(deviation).collect()
}

#[test]
fn compliances_are_found_from_measured_torques_without_masses() {
    let scenario = bending();
    let simulated = sim::simulate(&scenario, 3).expect("contacts");
    let posed = weightless(&scenario, &simulated);
    let estimate = solve(&posed);
    assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
    let found = deviations(&estimate, &simulated, Block::JointCompliance);
    println!("{found:?}");
    assert_eq!(found.len(), 7);
    assert!(found.iter().all(|deviation| deviation.abs() < 3.5), "{found:?}");
    let known = |entry: &&touchcal::estimate::ParameterEstimate| entry.sigma.is_some_and(|sigma| sigma < 5e-6);
    let of_block = estimate.parameters.iter().filter(|p| p.parameter.id.block() == Block::JointCompliance);
    assert!(of_block.filter(known).count() >= 4, "{:?}", estimate.parameters);

    // What is uncertain of the compliances moves the tool, as far as the usual torques deflect
    // joints.
    let mut unsure = estimate.clone();
    for k in 0..unsure.parameters.len() {
        if unsure.parameters[k].parameter.id.block() == Block::JointCompliance {
            unsure.covariance.row_mut(k).scale_mut(1e3);
            unsure.covariance.column_mut(k).scale_mut(1e3);
        }
    }
    let sigma = |estimate: &Estimate| {
        let q = vec![0.3; 7];
        tool_uncertainty(&posed, estimate, std::iter::once(q.as_slice())).expect("known")[0].position
    };
    assert!(sigma(&unsure) > 2.0 * sigma(&estimate), "{} {}", sigma(&unsure), sigma(&estimate));

    // Other contacts by the same arm, whose torques are measured too.
    let others = sim::run(&scenario, &simulated.truth, 77, &mut |_| ControlFlow::Continue(())).expect("contacts");
    let others = weightless(&scenario, &SimulatedTrial { logs: others, truth: simulated.truth.clone() });
    let rigid = solve(&posed.clone().with_parameters(joint_offset(&posed.robot)));
    let [bending, rigid] = [&estimate, &rigid].map(|estimate| {
        let mut others = Problem { robot: estimate.robot.clone(), ..others.clone() };
        apply_estimated_places(&mut others, |name| estimate.parameter(name).map(|entry| entry.value));
        evaluate(&others).all.mean
    });
    report("held out (mm)", &[("bending", 1e3 * bending), ("rigid", 1e3 * rigid)]);
    assert!(3.0 * bending < rigid, "{bending} {rigid}");

    // Torques of the opposite sign fit as well, and no joint deflects against its torque.
    let opposite = solve(&with_torques(&posed, |torque| -torque));
    assert_eq!(opposite.status, Status::NotUsable);
    let is_against = |warning: &Warning| warning.kind() == "deflection_against_torque";
    assert!(opposite.warnings.iter().any(is_against), "{:?}", opposite.warnings);
    assert!(!estimate.warnings.iter().any(is_against));
}

/// A compliance that the model leaves out is significant by measured torques too, where no gravity
/// deflects joints.
#[test]
fn compliance_that_is_left_out_is_found_by_measured_torques() {
    let mut scenario = bending();
    scenario.errors.joint_compliance = 1e-5;
    let simulated = sim::simulate(&scenario, 4).expect("contacts");
    let posed = weightless(&scenario, &simulated);
    let robot = posed.robot.clone().with_gravity(Vector3::zeros());
    let options = EstimatorOptions::default();
    let rigid = Problem { parameters: joint_offset(&robot), robot, options, ..posed };
    let estimate = solve(&rigid);
    let of_compliance = estimate.effect_tests.iter().find(|test| test.effect.name() == "joint_compliance");
    assert!(
        of_compliance.is_some_and(|test| test.p_value < 1e-6),
        "{:?} {:?}",
        estimate.effect_tests,
        estimate.untested
    );
}
