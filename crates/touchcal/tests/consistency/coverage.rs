//! Are the error bars true? Simulated insertions with known errors, many seeds, an estimate each.

use std::sync::Arc;

use crate::support::{solve, uniform};
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::{Estimate, Fixture, Loss, Method, Noise, PlacePrior, Problem, ShapeTolerance, Tool};
use touchcal::experiment::{CampaignSummary, Search, Trial, campaign_trial};
use touchcal::geometry::Parts;
use touchcal::io::urdf::{self, Ends};
use touchcal::manifold::{BallInSocket, PegInHole};
use touchcal::parameter::{joint_offset, strain};
use touchcal::robot::{KinematicParameter, Kinematics, Robot};
use touchcal::se3::Pose;
use touchcal::sim::{Distribution, Exploration, Preset, follow};

const ENCODER: f64 = 3.5e-5;
const CONTACT: f64 = 20e-6;

fn iiwa() -> Robot {
    urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot
}

/// True values of `strain` and the offsets for a seed.
fn truth(seed: u64) -> Vec<f64> {
    let draw = uniform(8, seed);
    (0..8).map(|k| if k == 0 { 0.05 * draw[0] } else { 5f64.to_radians() * draw[k] }).collect()
}

fn columns() -> Vec<KinematicParameter> {
    std::iter::once(KinematicParameter::Strain).chain((0..7).map(KinematicParameter::JointOffset)).collect()
}

fn problem(fixture: Fixture, tip_from_tool: Pose, contacts: ContactLog, noise: Noise) -> Problem {
    let robot = iiwa();
    let mut parameters = vec![strain()];
    parameters.extend(joint_offset(&robot));
    Problem {
        robot,
        tool: Tool { tip_from_tool, prior: PlacePrior::Fixed },
        fixtures: vec![fixture],
        distances: Vec::new(),
        contacts,
        noise,
        parameters,
        joint_drift: false,
        trend_variable: touchcal::estimate::TrendVariable::Log,
        wrench: touchcal::estimate::WrenchTolerance::DEFAULT,
        method: Method::LevenbergMarquardt,
        loss: Loss::GemanMcClure(3.0),
        options: touchcal::estimate::EstimatorOptions::default(),
        held_out: ContactLog::default(),
        acceptance: None,
        other_arms: Vec::new(),
    }
}

fn log_of(rows: &[Vec<f64>]) -> ContactLog {
    let mut contacts = ContactLog::new(7);
    for (i, q) in rows.iter().enumerate() {
        contacts.push(q, 0, Source { file: 0, line: i as u64 + 1 });
    }
    contacts
}

/// A T-slot peg in its hole, explored with elbow motion, and what is true.
fn insertion(seed: u64, contacts: usize, encoder_sigma: f64) -> (Problem, DVector<f64>) {
    let mut scenario = Preset::Paper.scenario(iiwa()).expect("parts");
    scenario.errors.distribution = Distribution::Uniform;
    scenario.contacts = contacts;
    scenario.contact_sigma = CONTACT;
    scenario.recorder.encoder_sigma = encoder_sigma;
    scenario.stiffness.rotation = 30.0;
    scenario.touches[0].exploration =
        Exploration { radius: 2e-3, tilt: 0.04, press: 3e-3, lift: 0.0, swing: 0.2, pace: 1.0, random_phases: false };
    let trial = Trial::simulated(&scenario, seed).expect("contacts");
    let Parts::PegInHole(parts) = &scenario.touches[0].parts else { panic!("a hole") };
    let noise = Noise { encoder: ENCODER, contact: CONTACT, is_estimated: false };
    let search = Search { method: Method::LevenbergMarquardt, noise, loss: Loss::GemanMcClure(3.0) };
    let truth = DVector::from_iterator(8, trial.truth.iter().map(|(_, value)| *value));
    (trial.problem(Box::new(PegInHole::new(parts.as_ref().clone())), search), truth)
}

/// A ball held in one known socket while the arm turns about it, without any noise.
fn socket(seed: u64) -> Problem {
    let tip_from_tool = Pose::translation(0.02, -0.03, 0.1);
    let mut arm = Kinematics::new(&iiwa(), &columns(), tip_from_tool);
    arm.set(&truth(seed));
    let posture = vec![0.1, 0.7, 0.2, -1.5, -0.2, 0.9, 0.1];
    let mut q = posture.clone();
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let mut rows = Vec::new();
    for i in 0..60u64 {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from_row_slice(&uniform(3, 1000 + i)) * 0.6);
        let bend: Vec<f64> = posture.iter().zip(uniform(7, 2000 + i)).map(|(q, d)| q + 0.5 * d).collect();
        let target = Pose::from_parts(Vector3::new(0.55, 0.05, 0.2).into(), turn * down);
        q = follow(&arm, &target, &q, &bend).expect("within reach");
        rows.push(q.clone());
    }
    let fixture = Fixture {
        name: "socket".to_owned(),
        manifold: Arc::new(BallInSocket),
        base_from_fixture: Some(Pose::translation(0.55, 0.05, 0.2)),
        prior: PlacePrior::Fixed,
        tolerance: ShapeTolerance::EXACT,
        placement: String::new(),
    };
    problem(fixture, tip_from_tool, log_of(&rows), Noise { encoder: 1e-6, contact: 1e-6, is_estimated: false })
}

/// Errors of the arm's parameters.
fn errors(estimate: &Estimate, truth: &[f64]) -> DVector<f64> {
    DVector::from_iterator(8, estimate.parameters.iter().zip(truth).map(|(p, truth)| p.value - truth))
}

#[test]
fn without_noise_the_truth_is_found_to_a_billionth() {
    for seed in 1..6 {
        let estimate = solve(&socket(seed));
        assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
        // The seventh joint turns about an axis near the ball: the rest must be exact.
        let worst = errors(&estimate, &truth(seed)).amax();
        assert!(worst < 1e-9, "seed {seed}: {worst:e}");
    }
}

#[test]
fn intervals_cover_the_truth_as_often_as_they_say() {
    const TRIALS: u64 = 40;
    let (mut inside, mut nees) = (0, 0.0);
    let mut bias = [0.0; 8];
    for seed in 1..=TRIALS {
        let (problem, truth) = insertion(seed, 1500, ENCODER);
        let estimate = solve(&problem);
        assert!(estimate.status.is_usable(), "seed {seed}: {:?}", estimate.termination);
        let error = errors(&estimate, truth.as_slice());
        let covariance: DMatrix<f64> = estimate.covariance.view((0, 0), (8, 8)).into_owned();
        nees += error.dot(&covariance.clone().cholesky().expect("positive definite").solve(&error)) / TRIALS as f64;
        println!(
            "seed {seed} nees {:.1} noise {:.2} rejected {} it {} interf {:.4}",
            error.dot(&covariance.clone().cholesky().unwrap().solve(&error)),
            estimate.noise_factor,
            estimate.contacts.rejected,
            estimate.termination.iterations,
            1e3 * estimate.parameters[8].value
        );
        for k in 0..8 {
            bias[k] += error[k] / covariance[(k, k)].sqrt();
        }
        inside += (0..8).filter(|&k| error[k].abs() < 1.96 * covariance[(k, k)].sqrt()).count();
    }
    let coverage = inside as f64 / (8 * TRIALS) as f64;
    println!("mean error / sigma {:.2?}", bias.iter().map(|v| v / TRIALS as f64).collect::<Vec<_>>());
    println!("coverage {coverage:.3} of 0.95, NEES {nees:.2} of 8");
    // 320 intervals, correlated within a trial: 0.95 ± 0.03 would be chance alone.
    assert!((0.92..=0.98).contains(&coverage), "{coverage}");
    // χ² with 320 degrees of freedom has a standard deviation of 0.63 on this scale.
    assert!((6.1..=9.9).contains(&nees), "{nees}");
}

/// Sockets of which nothing is known but their distance: base, fixtures and the arm's first joint
/// trade places, and only priors hold them.
#[test]
fn intervals_of_what_only_priors_bound_are_as_wide_as_these() {
    let scenario = Preset::Mukca.scenario(iiwa()).expect("parts");
    let mut summary = CampaignSummary::default();
    (0..20).for_each(|trial| summary.add(&campaign_trial(&scenario, 1, trial).expect("contacts")));
    let (nees, chance) = summary.nees();
    println!("coverage {:.3?}, NEES {nees:.3}, by chance {chance:.3?}", summary.coverage());
    assert_eq!(summary.usable, 20);
    assert!((chance[0]..chance[1]).contains(&nees), "{nees}");
    assert!((summary.coverage()[2] - 0.95).abs() < 0.03, "{:?}", summary.coverage());
}

/// Contacts scattered more than declared must widen the intervals.
#[test]
fn more_noise_than_declared_widens_the_intervals() {
    let quiet = solve(&insertion(3, 1500, ENCODER).0);
    let noisy = solve(&insertion(3, 1500, 3.0 * ENCODER).0);
    let sigma = |estimate: &Estimate| estimate.parameters[1].sigma.expect("a standard deviation");
    assert!(noisy.noise_factor > 1.8, "{}", noisy.noise_factor);
    assert!(sigma(&noisy) > 1.8 * sigma(&quiet), "{} {}", sigma(&noisy), sigma(&quiet));
}
