//! What presses on the tool, as a log's wrench says it: joints give way to it.

use super::ball_in_sockets::{SOCKETS, ball_in_sockets};
use crate::support::{report, solve, uniform};
use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};
use touchcal::contact::{AngleUnit, ContactLog, Load, LoadFrame, LoadOn};
use touchcal::estimate::{Estimate, Noise, OmittedEffect, Problem, Status, Warning, WrenchTolerance};
use touchcal::experiment::problem;
use touchcal::io::contact_csv;
use touchcal::io::contact_log::Options;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{Block, ParameterId, Prior, joint_compliance, joint_offset};
use touchcal::robot::{KinematicParameter, Kinematics, Robot};
use touchcal::se3::{self, Pose, Twist, Wrench};
use touchcal::sim::{self, Preset, SimulatedTrial};

fn iiwa() -> Robot {
    urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot
}

/// An arm whose joints give way like stiff harmonic drives, its peg in a hole, recorded with noise.
fn soft_arm(seed: u64) -> (Problem, SimulatedTrial) {
    let mut scenario = Preset::Paper.scenario(iiwa()).expect("parts");
    scenario.errors.joint_compliance = 1e-5;
    scenario.recorder.force_sigma = 0.5;
    scenario.contacts = 2000;
    let simulated = sim::simulate(&scenario, seed).expect("contacts");
    (problem(&scenario, &simulated), simulated)
}

/// Errors of the arm's parameters and their covariance.
fn errors(estimate: &Estimate, simulated: &SimulatedTrial) -> (DVector<f64>, DMatrix<f64>) {
    let of_arm = |k: &usize| !estimate.parameters[*k].parameter.id.block().is_nuisance();
    let arm: Vec<usize> = (0..estimate.parameters.len()).filter(of_arm).collect();
    let error = |&k: &usize| estimate.parameters[k].value - simulated.truth.value(estimate.parameters[k].parameter.id);
    let covariance = DMatrix::from_fn(arm.len(), arm.len(), |i, j| estimate.covariance[(arm[i], arm[j])]);
    (DVector::from_iterator(arm.len(), arm.iter().map(error)), covariance)
}

/// Mean error of the encoder offsets (rad).
fn offset_error(estimate: &Estimate, simulated: &SimulatedTrial) -> f64 {
    let offsets = estimate.parameters.iter().filter(|p| p.parameter.id.block() == Block::JointOffset);
    let each: Vec<f64> = offsets.map(|p| (p.value - simulated.truth.value(p.parameter.id)).abs()).collect();
    each.iter().sum::<f64>() / each.len() as f64
}

#[test]
fn joints_that_give_way_are_found_where_the_load_is_known_and_contradict_where_it_is_not() {
    let (mut squares, mut count) = (0.0, 0);
    for seed in 1..5 {
        let (mut problem, simulated) = soft_arm(seed);
        let estimate = solve(&problem);
        assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
        let (error, covariance) = errors(&estimate, &simulated);
        squares += error.dot(&(covariance.try_inverse().expect("a covariance") * &error));
        count += error.len();
        let known = offset_error(&estimate, &simulated);

        let mut without = ContactLog::new(7);
        for i in 0..problem.contacts.len() {
            without.push(problem.contacts.q(i), 0, problem.contacts.source(i));
        }
        problem.contacts = without;
        let estimate = solve(&problem);
        let unknown = offset_error(&estimate, &simulated);
        let errors = [("with", known.to_degrees()), ("without", unknown.to_degrees())];
        report(&format!("load, seed {seed}"), &errors);
        assert!(unknown > 10.0 * known, "{known} {unknown}");
        assert_eq!(estimate.status, Status::NotUsable);
        assert!(estimate.warnings.iter().any(|w| w.kind() == "correlated_errors"), "{:?}", estimate.warnings);
    }
    // 4 times 15 parameters: chi-squared of 60 lies between 35.5 and 92.0 in 99 % of cases.
    report("load", &[("NEES", squares), ("of", count as f64)]);
    assert_eq!(count, 60);
    assert!((35.5..92.0).contains(&squares), "{squares}");
}

/// A log of wrenches, in degrees.
fn log_text(simulated: &SimulatedTrial, load: impl Fn(&[f64], &Wrench) -> Wrench) -> String {
    let log = &simulated.logs[0];
    let mut text = "q1,q2,q3,q4,q5,q6,q7,fx,fy,fz,tx,ty,tz,contact\n".to_owned();
    for row in 0..log.len() {
        let q = log.q(row).iter().map(|q| q.to_degrees());
        let cells: Vec<String> = q.chain(load(log.q(row), &log.wrench[row])).map(|v| format!("{v:.12}")).collect();
        text += &format!("{},{}\n", cells.join(","), u8::from(log.contact[row]));
    }
    text
}

fn read(text: &str, load: Option<Load>) -> ContactLog {
    let options = Options { unit: AngleUnit::Degree, load, ..Options::default() };
    let mut log = ContactLog::new(7);
    contact_csv::read(text.as_bytes(), "log.csv", &iiwa(), &options, &mut log).expect("a log");
    log
}

#[test]
fn a_load_is_the_same_whosever_wrench_and_in_whatever_frame() {
    let (problem, simulated) = soft_arm(1);
    let arm = Kinematics::new(&iiwa(), &[], Pose::identity());
    let turned = |sign: f64, in_base: bool| {
        let arm = &arm;
        move |q: &[f64], wrench: &Wrench| -> Wrench {
            let turn = if in_base { arm.pose(q).rotation } else { Pose::identity().rotation };
            let (force, torque) = (Vector3::from_row_slice(&wrench[..3]), Vector3::from_row_slice(&wrench[3..]));
            let (force, torque) = (turn * force * sign, turn * torque * sign);
            std::array::from_fn(|k| if k < 3 { force[k] } else { torque[k - 3] })
        }
    };
    for (on, sign) in [(LoadOn::Tool, 1.0), (LoadOn::Fixture, -1.0)] {
        for (frame, in_base) in [(LoadFrame::Tip, false), (LoadFrame::Base, true)] {
            let log = read(&log_text(&simulated, turned(sign, in_base)), Some(Load { on, frame, lag: 0.0 }));
            assert_eq!(log.len(), problem.contacts.len());
            for i in 0..log.len() {
                let (found, expected) = (Twist::from(log.load(i)), Twist::from(problem.contacts.load(i)));
                assert!((found - expected).amax() < 1e-8, "{on:?} {frame:?}: {found} {expected}");
            }
        }
    }
    let without = read(&log_text(&simulated, turned(1.0, false)), None);
    assert!(!without.has_loads() && without.load(3) == [0.0; 6]);
}

/// The wrench of a sensor with a low-pass filter, read with the filter's lag, is that of a sensor
/// without one, but for rounding to 1e-4.
#[test]
fn a_load_without_its_lag_is_that_before_the_filter() {
    const LAG: f64 = 5.5;
    let mut scenario = Preset::Paper.scenario(iiwa()).expect("parts");
    scenario.contacts = 300;
    let exact = sim::simulate(&scenario, 1).expect("contacts");
    // A filter whose lag is LAG, in a log of 300 Hz.
    scenario.recorder.force_lag = 1.0 / (300.0 * (1.0 / LAG).ln_1p());
    let filtered = sim::simulate(&scenario, 1).expect("contacts");
    let text = log_text(&filtered, |_, wrench| *wrench);
    let error = |lag: f64| {
        let log = read(&text, Some(Load { on: LoadOn::Tool, frame: LoadFrame::Tip, lag }));
        // Line 1 is the header.
        let row = |i: usize| log.source(i).line as usize - 2;
        let known = (0..log.len()).filter(|&i| row(i) < exact.logs[0].len());
        let off = |i: usize| (Twist::from(log.load(i)) - Twist::from(exact.logs[0].wrench[row(i)])).amax();
        known.map(off).fold(0.0, f64::max)
    };
    let (declared, ignored) = (error(LAG), error(0.0));
    report("lag", &[("declared", declared), ("ignored", ignored)]);
    assert!(declared < 1e-4 * (1.0 + LAG) && ignored > 1.0, "{declared} {ignored}");
}

/// Joint positions near `q` at which the tool of `arm` is at `target` under `load`: steps of least
/// norm.
fn reached(arm: &Kinematics, target: &Vector3<f64>, load: &Wrench, mut q: Vec<f64>) -> Vec<f64> {
    let mut scratch = arm.scratch();
    for _ in 0..20 {
        let pose = arm.pose_and_jacobian_under(&q, load, &mut scratch);
        let missing = pose.rotation.inverse() * (target - pose.translation.vector);
        let jacobian = Matrix3xX::from_columns(&scratch.joints.iter().map(se3::linear).collect::<Vec<_>>());
        let step = jacobian.pseudo_inverse(1e-9).expect("a rank") * missing;
        q.iter_mut().zip(step.iter()).for_each(|(q, step)| *q += step);
    }
    assert!((arm.pose_under(&q, load).translation.vector - target).norm() < 1e-12);
    q
}

/// Compliances of about 1e-4 rad/(N m) and offsets of an arm.
fn soft_errors() -> Vec<(KinematicParameter, f64)> {
    let each = (0..7).zip(uniform(7, 7).into_iter().zip(uniform(7, 8)));
    let errors = each.flat_map(|(i, (c, b))| {
        let compliance = (KinematicParameter::JointCompliance(i), 1e-4 * (1.0 + 0.5 * c));
        [compliance, (KinematicParameter::JointOffset(i), 0.02 * b)]
    });
    errors.collect()
}

/// A ball held in sockets under loads of up to 20 N and 2 N m by an arm of [`soft_errors`], as the
/// model has it, with encoders that are off by up to `noise` (rad); the wrench is measured with
/// `bias` and `scale`.
fn held(bias: &Wrench, scale: f64, noise: f64) -> Problem {
    let problem = ball_in_sockets(&soft_errors(), &SOCKETS, |arm, socket, seed, q| {
        let draw = uniform(6, 30_000 + seed);
        let load: Wrench = std::array::from_fn(|k| if k < 3 { 20.0 * draw[k] } else { 2.0 * draw[k] });
        let mut measured = reached(arm, &Vector3::from_row_slice(socket), &load, q.to_vec());
        measured.iter_mut().zip(uniform(7, 40_000 + seed)).for_each(|(q, n)| *q += noise * n);
        (measured, Some(std::array::from_fn(|k| (1.0 + scale) * load[k] + bias[k])))
    });
    // A prior would pull by its share.
    let parameters = [joint_compliance(&problem.robot), joint_offset(&problem.robot)].concat();
    let parameters = parameters.into_iter().map(|parameter| parameter.with_prior(Prior::Flat)).collect();
    Problem { wrench: WrenchTolerance { force: 1e3, torque: 1e3, scale: 1e3, ..WrenchTolerance::EXACT }, ..problem }
        .with_parameters(parameters)
        .with_noise(Noise { encoder: noise.max(1e-6) / 3f64.sqrt(), contact: 1e-6, is_estimated: false })
}

/// Beside gravity, whose torques are known, the scale of the wrench is one of the compliances'
/// effects that contacts tell apart.
#[test]
fn without_noise_bias_and_scale_of_the_wrench_are_found() {
    let errors = soft_errors();
    let (bias, scale) = ([0.5, -0.8, 0.3, 0.05, -0.03, 0.08], 0.04);
    let problem = held(&bias, scale, 0.0);
    let estimate = solve(&problem);
    assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
    for entry in &estimate.parameters {
        let truth = match (entry.parameter.id, entry.parameter.id.kinematic()) {
            (_, Some(parameter)) => errors.iter().find(|(known, _)| *known == parameter).expect("an error").1,
            (ParameterId::WrenchBias(k), _) => bias[k],
            (ParameterId::WrenchScale, _) => scale,
            other => panic!("{other:?}"),
        };
        let relative = (entry.value - truth).abs() / entry.parameter.scale;
        assert!(relative < 1e-6, "{}: {} {truth}", entry.parameter.name, entry.value);
    }
    assert_eq!(estimate.parameters.len(), 21);
}

/// Contacts in many postures under many loads tell a bias from all else; without one they do not
/// see any, and what is not declared exact needs no test.
#[test]
fn contacts_contradict_a_wrench_that_is_falsely_exact() {
    const NOISE: f64 = 3e-5;
    let estimate = |size: f64, wrench: WrenchTolerance| {
        let bias = [size, -size, size, 0.1 * size, -0.1 * size, 0.1 * size];
        solve(&Problem { wrench, ..held(&bias, 0.0, NOISE) })
    };
    let found = estimate(0.5, WrenchTolerance::EXACT);
    let first = &found.effect_tests[0];
    assert!(first.effect == OmittedEffect::Wrench && first.p_value < 1e-10, "{first:?}");
    let names: Vec<&str> = first.values.iter().map(|value| value.name.as_str()).collect();
    assert_eq!((names.len(), names[0], names[6]), (7, "wrench_bias.fx", "wrench_scale"));
    let is_wrench = |warning: &Warning| matches!(warning, Warning::OmittedEffect { effect: OmittedEffect::Wrench, .. });
    assert!(found.status == Status::NotUsable && found.warnings.iter().any(is_wrench), "{:?}", found.warnings);

    let none = estimate(0.0, WrenchTolerance::EXACT);
    let test = none.effect_tests.iter().find(|test| test.effect == OmittedEffect::Wrench).expect("a test");
    assert!(none.status.is_usable() && test.p_value > 0.01, "{test:?}");

    let declared = estimate(0.5, WrenchTolerance::DEFAULT);
    assert!(declared.status.is_usable(), "{:?}", declared.warnings);
    assert!(declared.effect_tests.iter().all(|test| test.effect != OmittedEffect::Wrench));
}
