//! Play of joints, which rest at the side to which their torques push them.

use touchcal::contact::ContactLog;
use touchcal::estimate::{Estimate, Noise, Problem, Status, evaluate};
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{Block, joint_backlash, joint_offset};
use touchcal::robot::BACKLASH_TORQUE;
use touchcal::sim::{self, ArmErrors, Preset};

use super::ball_in_sockets::{SOCKETS, ball_in_sockets};
use crate::support::{report, solve, uniform};

/// Noise of joint positions (rad).
const ENCODER: f64 = 2e-5;

/// Half of the play of each joint (rad), all different.
fn plays() -> Vec<f64> {
    uniform(7, 7).iter().map(|v| 2e-4 * (1.0 + 0.5 * v)).collect()
}

/// The measured torques of a contact: either sign, and up to 30 N m.
fn torques(seed: u64) -> Vec<f64> {
    uniform(7, 50_000 + seed).iter().map(|v| 30.0 * v).collect()
}

/// A ball held in `sockets` by an arm with play, whose torques are measured; declared with `sign`.
fn touching(sockets: &[[f64; 3]], sign: f64) -> Problem {
    let plays = plays();
    let posed = ball_in_sockets(&[], sockets, |_, _, seed, q| {
        let noise = uniform(7, 1_000_000 + seed).into_iter().map(|v| 3f64.sqrt() * ENCODER * v);
        let side = torques(seed).into_iter().map(|torque| torque / torque.hypot(BACKLASH_TORQUE));
        let each = q.iter().zip(noise).zip(side).zip(&plays);
        (each.map(|(((q, noise), side), play)| q - play * side + noise).collect(), None)
    });
    let mut contacts = ContactLog::new(7);
    for i in 0..posed.contacts.len() {
        let source = posed.contacts.source(i);
        contacts.push(posed.contacts.q(i), posed.contacts.fixture(i), source);
        let seed = 1000 * posed.contacts.fixture(i) as u64 + source.line - 1;
        contacts.set_joint_torques(&torques(seed).iter().map(|torque| sign * torque).collect::<Vec<f64>>());
    }
    let parameters = [joint_backlash(&posed.robot), joint_offset(&posed.robot)].concat();
    let Problem { robot, tool, fixtures, .. } = posed;
    Problem::new(robot, tool, fixtures, contacts).with_parameters(parameters).with_noise(Noise {
        encoder: ENCODER,
        contact: 1e-6,
        is_estimated: false,
    })
}

/// Estimates of the plays (rad), and their standard deviations.
fn found(estimate: &Estimate) -> Vec<(f64, f64)> {
    let of_block = estimate.parameters.iter().filter(|entry| entry.parameter.id.block() == Block::JointBacklash);
    of_block.map(|entry| (entry.value, entry.sigma.expect("a standard deviation"))).collect()
}

#[test]
fn plays_are_found_from_measured_torques() {
    let (near, far) = SOCKETS.split_at(3);
    let posed = touching(near, 1.0);
    let estimate = solve(&posed);
    assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
    for ((value, sigma), truth) in found(&estimate).into_iter().zip(plays()) {
        report("play", &[("true", truth), ("found", value), ("sigma", sigma)]);
        assert!((value - truth).abs() < 4.0 * sigma && sigma < 3e-5, "{value} {truth} {sigma}");
    }
    assert!(estimate.robot.is_compliant() && estimate.robot.moving().all(|joint| joint.backlash > 0.0));

    // Contacts with another socket are predicted better than without.
    let without = solve(&posed.clone().with_parameters(joint_offset(&posed.robot)));
    let elsewhere = touching(far, 1.0);
    let [with, without] = [&estimate, &without]
        .map(|found| evaluate(&Problem { robot: found.robot.clone(), ..elsewhere.clone() }).all.mean);
    report("held out (mm)", &[("with", 1e3 * with), ("without", 1e3 * without)]);
    assert!(2.0 * with < without, "{with} {without}");

    // Torques of the opposite sign fit as well, and are noticed.
    let opposite = solve(&touching(near, -1.0));
    assert_eq!(opposite.status, Status::NotUsable);
    assert!(opposite.warnings.iter().any(|w| w.kind() == "deflection_against_torque"), "{:?}", opposite.warnings);
}

/// Sides of play follow from gravity and load where torques are not measured.
#[test]
fn plays_are_found_within_their_uncertainty_from_gravity_and_loads() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Mukca.scenario(robot).expect("parts");
    scenario.errors = ArmErrors { joint_offset: 2e-3, joint_backlash: 2e-4, ..ArmErrors::NONE };
    scenario.recorder.encoder_sigma = ENCODER;
    scenario.contacts = 40;
    let simulated = sim::simulate(&scenario, 5).expect("contacts");
    let posed = problem(&scenario, &simulated);
    assert!(posed.contacts.has_loads());
    let estimate = solve(&posed);
    assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
    let found = found(&estimate);
    println!("{found:?}");
    assert_eq!(found.len(), 7);
    assert!(found.iter().all(|(value, sigma)| (value - 2e-4).abs() < 3.5 * sigma), "{found:?}");
}
