//! What presses on the tool, as a log's wrench says it: joints give way to it.

use crate::support::{report, solve};
use nalgebra::{DMatrix, DVector, Vector3};
use touchcal::contact::ContactLog;
use touchcal::contact::{AngleUnit, Load, LoadFrame, LoadOn};
use touchcal::estimate::{Estimate, Problem, Status};
use touchcal::experiment::problem;
use touchcal::io::contact_csv;
use touchcal::io::contact_log::Options;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::Block;
use touchcal::robot::{Kinematics, Robot};
use touchcal::se3::{Pose, Twist, Wrench};
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

/// Mean error of the joint offsets (rad).
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
        assert_eq!(estimate.status, Status::Converged, "{:?}", estimate.warnings);
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
            let log = read(&log_text(&simulated, turned(sign, in_base)), Some(Load { on, frame }));
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
