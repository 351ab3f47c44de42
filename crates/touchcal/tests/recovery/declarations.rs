//! Declarations that are false: tolerated as far as they are declared uncertain, and contradicted
//! where they are declared exact.

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::{DVector, Translation3, UnitQuaternion};
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::{
    Acceptance, Decision, ErrorFrame, Estimate, Fixture, OmittedEffect, ParameterPosterior, PlacePrior, Problem,
    ShapeTolerance, Status, Tool, UnseenEffects, Warning, acceptance, apply_estimate, calibrate_with_freed_effects,
    evaluate, evaluate_held_out, workspace_configurations,
};
use touchcal::experiment::problem;
use touchcal::geometry::{Polygon, PrismPair};
use touchcal::io::urdf::{self, Ends};
use touchcal::manifold::{BallInSocket, PegInHole};
use touchcal::parameter::{joint_harmonic, joint_offset, joint_trend};
use touchcal::robot::Kinematics;
use touchcal::se3::Pose;
use touchcal::sim::{self, Preset};

use crate::support::{Truth, mujoco_trial, report, solve};

/// 99.9 % quantile of χ² with eight degrees of freedom.
const NEES_LIMIT: f64 = 26.12;
/// Logs with little and with much motion of the elbow.
const TRIALS: [&str; 4] =
    ["extrusion/paper/trial_00", "extrusion/paper/trial_02", "extrusion/rich/trial_01", "extrusion/rich/trial_20"];

/// Squared error of strain and offsets over their covariance.
fn nees(estimate: &Estimate, truth: &Truth) -> f64 {
    let errors = std::iter::once(truth.strain).chain(truth.offset.iter().copied()).zip(&estimate.parameters);
    let error = DVector::from_iterator(8, errors.map(|(truth, entry)| entry.value - truth));
    let covariance = estimate.covariance.view((0, 0), (8, 8)).into_owned();
    error.dot(&covariance.cholesky().expect("a covariance").solve(&error))
}

/// Priors and tolerances as a problem file has them that declares none.
fn with_defaults(mut problem: Problem) -> Problem {
    problem.tool.prior = PlacePrior::DEFAULT_TOOL;
    problem.fixtures[0].prior = PlacePrior::DEFAULT_FIXTURE;
    problem.fixtures[0].tolerance = ShapeTolerance::DEFAULT;
    problem
}

/// With the hole declared off its place by a motion in its own frame (m, rad).
fn hole_moved(mut problem: Problem, by: [f64; 3], yaw: f64) -> Problem {
    let motion = Pose::from_parts(Translation3::from(by), UnitQuaternion::from_euler_angles(0.0, 0.0, yaw));
    let place = problem.fixtures[0].base_from_fixture.as_mut().expect("a place");
    *place *= motion;
    problem
}

/// With a hole declared wider than it is by so much on each side (m).
fn hole_wider(mut problem: Problem, by: f64) -> Problem {
    let peg = Polygon::extrusion25();
    let hole = peg.offset_mitred(0.5e-3 + by).expect("an outline");
    problem.fixtures[0].manifold = Arc::new(PegInHole::new(PrismPair::new(peg, 0.04, hole, 0.03).expect("parts")));
    problem
}

/// With the encoder of `joint` drifting from −`half` to `half` (rad) over the log.
fn drifting(mut problem: Problem, joint: usize, half: f64) -> Problem {
    let old = &problem.contacts;
    let mut contacts = ContactLog::new(old.dof());
    let last = (old.len() - 1) as f64;
    for i in 0..old.len() {
        let mut q = old.q(i).to_vec();
        q[joint] += half * (2.0 * i as f64 / last - 1.0);
        contacts.push(&q, old.fixture(i), old.source(i));
    }
    problem.contacts = contacts;
    problem
}

fn shown(estimate: &Estimate) -> Vec<&OmittedEffect> {
    let each = estimate.warnings.iter();
    each.filter_map(|warning| if let Warning::OmittedEffect { effect, .. } = warning { Some(effect) } else { None })
        .collect()
}

#[test]
fn what_is_true_and_declared_exact_is_not_contradicted() {
    for trial in TRIALS {
        let estimate = solve(&mujoco_trial(trial).0);
        assert_eq!(shown(&estimate), Vec::<&OmittedEffect>::new(), "{trial}");
        // Compliance, segments, origins, harmonics, trend, walk, tool, fixture, edges.
        assert_eq!(estimate.effect_tests.len(), 9, "{trial}");
    }
}

#[test]
fn a_hole_beside_its_place_is_found_where_its_place_is_uncertain() {
    let mut worst: f64 = 0.0;
    for trial in TRIALS {
        for by in [[0.0; 3], [0.3e-3, -0.6e-3, 0.6e-3]] {
            let (problem, truth) = mujoco_trial(trial);
            let estimate = solve(&hole_moved(with_defaults(problem), by, 0.003));
            assert!(estimate.status.is_usable(), "{trial}, {by:?}: {:?}", estimate.warnings);
            worst = worst.max(nees(&estimate, &truth));
        }
    }
    report("hole beside its place, default tolerance", &[("greatest NEES", worst)]);
    assert!(worst < NEES_LIMIT, "{worst}");
}

/// A hole half a millimetre beside a place that is declared exact: the result is not
/// usable and the cause is named.
#[test]
fn a_hole_beside_a_place_declared_exact_is_contradicted() {
    for trial in ["extrusion/rich/trial_01", "extrusion/rich/trial_20", "extrusion/rich/trial_25"] {
        let (problem, _) = mujoco_trial(trial);
        let estimate = solve(&hole_moved(problem, [0.3e-3, -0.3e-3, 0.3e-3], 2e-3));
        assert_eq!(estimate.status, Status::NotUsable, "{trial}");
        let of_hole = OmittedEffect::FixturePlace { fixture: "hole".to_owned() };
        assert!(shown(&estimate).contains(&&of_hole), "{trial}: {:?}", estimate.warnings);
    }
}

#[test]
fn a_clearance_that_is_off_is_within_its_tolerance() {
    let mut worst: f64 = 0.0;
    for trial in TRIALS {
        for by in [-0.05e-3, 0.05e-3] {
            let (problem, truth) = mujoco_trial(trial);
            let estimate = solve(&hole_wider(with_defaults(problem), by));
            assert!(estimate.status.is_usable(), "{trial}, {by}: {:?}", estimate.warnings);
            worst = worst.max(nees(&estimate, &truth));
        }
    }
    report("clearance off by 0.05 mm, default tolerance", &[("greatest NEES", worst)]);
    assert!(worst < NEES_LIMIT, "{worst}");
}

/// A clearance that is off by 0.03 mm, declared exact: the result is refused, the test of the gaps
/// has the error of the declared clearance, and with a freed tolerance the result is right.
#[test]
fn a_clearance_that_is_off_and_declared_exact_is_contradicted() {
    for trial in TRIALS {
        for by in [-0.03e-3, 0.03e-3] {
            let (problem, truth) = mujoco_trial(trial);
            let problem = hole_wider(problem, by);
            let estimate = solve(&problem);
            assert_eq!(estimate.status, Status::NotUsable, "{trial}, {by}");
            let of_gap =
                |warning: &Warning| matches!(warning, Warning::FarFromPrior { name, .. } if name == "gap_bias.hole");
            assert!(estimate.warnings.iter().any(of_gap), "{trial}, {by}: {:?}", estimate.warnings);
            let test =
                estimate.prior_tests.iter().find(|test| test.declaration.name() == "gap_bias.hole").expect("a test");
            assert!(test.p_value < 1e-5 && (test.values[0].value - by).abs() < 0.01e-3, "{trial}, {by}: {test:?}");
            let (_, freed) = calibrate_with_freed_effects(&problem, &mut |_| ControlFlow::Continue(()));
            assert!(freed.status.is_usable(), "{trial}, {by}: {:?}", freed.warnings);
            assert!(nees(&freed, &truth) < NEES_LIMIT, "{trial}, {by}: {}", nees(&freed, &truth));
        }
    }
}

/// A hole that is off by half of its standard deviation, and one that is off by eight of them: the
/// first agrees with what is declared. The reported motion is that of the tool in a calibration
/// with a place that is declared exact.
#[test]
fn a_place_is_tested_against_its_standard_deviation() {
    let (problem, _) = mujoco_trial("extrusion/rich/trial_01");
    let p_value = |by: f64| {
        let mut moved = hole_moved(with_defaults(problem.clone()), [0.0, 0.0, by], 0.0);
        moved.options.unseen_effects = UnseenEffects::Ignore;
        let estimate = solve(&moved);
        estimate.prior_tests.iter().find(|test| test.declaration.name() == "fixture.hole").expect("a test").p_value
    };
    let found = [0.5e-3, 8e-3].map(p_value);
    assert!(found[0] > 1e-2 && found[1] < 1e-5, "{found:?}");

    let mut moved = hole_moved(problem, [0.1e-3, -0.1e-3, 0.1e-3], 0.0);
    moved.options.unseen_effects = UnseenEffects::Ignore;
    let exact = solve(&moved);
    moved.fixtures[0].prior = PlacePrior::DEFAULT_FIXTURE;
    let with_prior = solve(&moved);
    let test = with_prior.prior_tests.iter().find(|test| test.declaration.name() == "fixture.hole").expect("a test");
    let positions = workspace_configurations(&moved.robot, 100);
    let place = |estimate: &Estimate, q: &[f64]| {
        Kinematics::new(&estimate.robot, &[], moved.tool.tip_from_tool).pose(q).translation.vector
    };
    let square = |q: &Vec<f64>| (place(&exact, q) - place(&with_prior, q)).norm_squared();
    let expected = (positions.iter().map(square).sum::<f64>() / 100.0).sqrt();
    let found = test.displacement.expect("a motion");
    assert!((found / expected - 1.0).abs() < 0.1, "{found} m, expected {expected} m");
}

/// An encoder that drifts by 0.04° over the log: shown where it is left out, and found with
/// `joint_trend`.
#[test]
fn an_encoder_that_drifts_is_shown_and_found() {
    let half = 0.02_f64.to_radians();
    for joint in [1, 3] {
        let (problem, truth) = mujoco_trial("extrusion/rich/trial_01");
        let problem = drifting(problem, joint, half);
        let without = solve(&problem);
        let test = without.effect_tests.iter().find(|test| test.effect == OmittedEffect::JointTrend).expect("a test");
        assert!(test.p_value < 1e-5, "{}", test.p_value);

        let trends = problem.parameters.iter().cloned().chain(joint_trend(&problem.robot)).collect();
        let with = solve(&problem.clone().with_parameters(trends));
        assert!(with.status.is_usable(), "{:?}", with.warnings);
        let name = format!("joint_trend.joint_a{}", joint + 1);
        let trend = with.parameter(&name).expect("a trend");
        let deviations = (trend.value - half) / trend.sigma.expect("a standard deviation");
        assert!(deviations.abs() < 4.0 && trend.value > 0.9 * half, "{name}: {} ({deviations} σ)", trend.value);
        let worst = nees(&with, &truth);
        assert!(worst < NEES_LIMIT, "{worst}");
    }
}

/// With an encoder of `joint` that reads too much by `amplitude` (rad) times the sine of its
/// position.
fn with_harmonic(mut problem: Problem, joint: usize, amplitude: f64) -> Problem {
    let old = &problem.contacts;
    let mut contacts = ContactLog::new(old.dof());
    for i in 0..old.len() {
        let mut q = old.q(i).to_vec();
        q[joint] += amplitude * q[joint].sin();
        contacts.push(&q, old.fixture(i), old.source(i));
    }
    problem.contacts = contacts;
    problem
}

/// Harmonics that were estimated are not in the calibrated arm: the warning says how far they move
/// the tool, and a tolerance below that is not passed. Distances from contact, those of the
/// calibration and of an evaluation, are corrected by them.
#[test]
fn harmonics_count_as_errors_of_the_calibrated_arm() {
    let amplitude = 0.05_f64.to_radians();
    let (problem, truth) = mujoco_trial("extrusion/rich/trial_01");
    let problem = with_harmonic(problem, 3, amplitude);
    let harmonics = problem.parameters.iter().cloned().chain(joint_harmonic(&problem.robot)).collect();
    let problem = problem.with_parameters(harmonics);
    let estimate = solve(&problem);
    assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
    assert!(nees(&estimate, &truth) < NEES_LIMIT, "{}", nees(&estimate, &truth));

    let value = |name: String| estimate.parameter(&name).expect("a harmonic").value;
    let kinematics = Kinematics::new(&estimate.robot, &[], problem.tool.tip_from_tool);
    let place = |q: &[f64]| kinematics.pose(q).translation.vector;
    let names: Vec<String> = problem.robot.moving().map(|joint| joint.name.clone()).collect();
    let displacement = |q: &Vec<f64>| {
        let error = |(name, q): (&String, f64)| {
            let of_phase = |phase| value(format!("joint_harmonic.{name}.{phase}"));
            of_phase("sin") * q.sin() + of_phase("cos") * q.cos()
        };
        let corrected: Vec<f64> = names.iter().zip(q).map(|(name, &q)| q - error((name, q))).collect();
        (place(q) - place(&corrected)).norm()
    };
    let positions = workspace_configurations(&problem.robot, 100);
    let expected = (positions.iter().map(|q| displacement(q).powi(2)).sum::<f64>() / 100.0).sqrt();
    let found = estimate.warnings.iter().find_map(|warning| match warning {
        Warning::HarmonicsNotInRobot { displacement } => Some(*displacement),
        _ => None,
    });
    let found = found.expect("a warning");
    assert!((found / expected - 1.0).abs() < 1e-2, "{found} m, expected {expected} m");

    let asked = Acceptance { distance: found, angle: None, confidence: 0.95, frame: ErrorFrame::Base, positions };
    let result = acceptance(&asked, &problem, &estimate);
    assert_eq!(result.decision, Decision::Fail, "{:?}", result.errors);

    let uncorrected = Problem { robot: estimate.robot.clone(), ..problem.clone() };
    let mut corrected = uncorrected.clone();
    apply_estimate(&mut corrected, |name| Some(estimate.parameter(name)?.value));
    let [without, with] = [&uncorrected, &corrected].map(|problem| evaluate(problem).all.rms);
    assert!((with / estimate.postfit.all.rms - 1.0).abs() < 1e-9 && without > 2.0 * with, "{without} {with}");
    let found = evaluate_held_out(&problem, &corrected, ParameterPosterior::of_estimate(&estimate).as_ref());
    assert_eq!((found.score.all.rms, found.agrees()), (with, Some(true)), "{found:?}");
}

/// A drift is freed without being asked for by name, and found; where nothing is false nothing is
/// freed. A harmonic of 0.05° contacts take for several effects: the result is refused, or its
/// intervals hold the truth.
#[test]
fn what_contacts_contradict_is_freed() {
    let free = |problem: &Problem| calibrate_with_freed_effects(problem, &mut |_| ControlFlow::Continue(()));
    let (problem, truth) = mujoco_trial("extrusion/rich/trial_01");
    let (same, estimate) = free(&problem);
    assert!(estimate.freed_effects.is_empty() && same.parameters == problem.parameters);

    let (posed, estimate) = free(&drifting(problem.clone(), 3, 0.02_f64.to_radians()));
    let effects: Vec<&OmittedEffect> = estimate.freed_effects.iter().map(|freed| &freed.effect).collect();
    assert!(effects.contains(&&OmittedEffect::JointTrend), "{effects:?}");
    assert!(estimate.freed_effects.iter().all(|freed| freed.gain > 10.0 && freed.p_value < 1e-5));
    assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
    assert!(posed.parameters.len() >= problem.parameters.len() + 7);
    assert!(nees(&estimate, &truth) < NEES_LIMIT, "{}", nees(&estimate, &truth));

    for trial in ["extrusion/rich/trial_01", "extrusion/rich/trial_20"] {
        let (problem, truth) = mujoco_trial(trial);
        let (_, estimate) = free(&with_harmonic(problem, 5, 0.05_f64.to_radians()));
        assert!(!estimate.freed_effects.is_empty(), "{trial}");
        let honest = !estimate.status.is_usable() || nees(&estimate, &truth) < NEES_LIMIT;
        assert!(honest, "{trial}: {}", nees(&estimate, &truth));
    }
}

/// A ball in simulated sockets, one encoder with another offset in the last third of the log, as
/// after a collision: stretches of the log contradict each other, which they do not otherwise.
#[test]
fn an_encoder_that_jumps_is_contradicted_by_the_stretches() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let scenario = Preset::Mukca.scenario(robot).expect("parts");
    for seed in 1..=4 {
        let right = problem(&scenario, &sim::simulate(&scenario, seed).expect("contacts"));
        let found = solve(&right).predictive_check.expect("a predictive check");
        assert!(found.p_value > 1e-3 && found.ratio < 1.3, "seed {seed}: {found:?}");
        let mut wrong = right.clone();
        wrong.contacts = ContactLog::new(right.contacts.dof());
        for i in 0..right.contacts.len() {
            let mut q = right.contacts.q(i).to_vec();
            q[3] += if 3 * i > 2 * right.contacts.len() { 0.1_f64.to_radians() } else { 0.0 };
            wrong.contacts.push(&q, right.contacts.fixture(i), right.contacts.source(i));
        }
        let estimate = solve(&wrong);
        let found = estimate.predictive_check.as_ref().expect("a predictive check");
        assert!(found.p_value < 1e-5 && found.ratio > 1.3, "seed {seed}: {found:?}");
        let of_prediction = |warning: &Warning| matches!(warning, Warning::PredictionContradicted { .. });
        assert!(estimate.warnings.iter().any(of_prediction), "seed {seed}: {:?}", estimate.warnings);
    }
}

/// An arm of three sliding joints has no compliance, no harmonics and no segments to be tested.
#[test]
fn an_arm_without_turning_joints_is_answered() {
    let joint = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name='{name}' type='prismatic'><parent link='{parent}'/><child link='{child}'/>\
             <axis xyz='{axis}'/><limit lower='-1' upper='1'/></joint>"
        )
    };
    let joints = [("x", "a", "b", "1 0 0"), ("y", "b", "c", "0 1 0"), ("z", "c", "d", "0 0 1")];
    let joints: String = joints.iter().map(|(name, parent, child, axis)| joint(name, parent, child, axis)).collect();
    let links: String = ["a", "b", "c", "d"].iter().map(|name| format!("<link name='{name}'/>")).collect();
    let text = format!("<robot name='gantry'>{links}{joints}</robot>");
    let robot = urdf::read(&text, "gantry.urdf", Ends::default()).expect("an arm");
    let mut contacts = ContactLog::new(3);
    for line in 1..=40 {
        let wobble = |k: f64| 1e-5 * (k * line as f64).sin();
        contacts.push(&[0.1 + wobble(1.0), 0.2 + wobble(2.0), 0.3 + wobble(3.0)], 0, Source { file: 0, line });
    }
    let socket = Fixture {
        name: "socket".to_owned(),
        manifold: Arc::new(BallInSocket),
        base_from_fixture: Some(Pose::translation(0.1, 0.2, 0.3)),
        prior: PlacePrior::Fixed,
        tolerance: ShapeTolerance::EXACT,
        placement: String::new(),
    };
    let tool = Tool { tip_from_tool: Pose::identity(), prior: PlacePrior::Fixed };
    let offsets = joint_offset(&robot);
    let estimate = solve(&Problem::new(robot, tool, vec![socket], contacts).with_parameters(offsets));
    assert!(estimate.effect_tests.iter().all(|test| !test.values.is_empty() && test.p_value <= 1.0));
    for entry in &estimate.parameters {
        assert!(entry.value.abs() < 1e-4, "{}: {}", entry.parameter.name, entry.value);
    }
}
