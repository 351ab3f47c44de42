//! Encoders that drift over the log: are the error bars true?

use touchcal::estimate::{Problem, Status, TrendVariable};
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset, Recorder, SimulatedTrial};

use crate::nees::NeesSum;
use crate::support::{report, solve};

/// A trial of 1000 contacts of the paper's arm, with encoders that `change`, and its problem.
fn trial(change: impl Fn(&mut Recorder), seed: u64) -> (Problem, SimulatedTrial) {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Paper.scenario(robot).expect("parts");
    scenario.contacts = 1000;
    change(&mut scenario.recorder);
    let simulated = sim::simulate(&scenario, seed).expect("contacts");
    (problem(&scenario, &simulated), simulated)
}

/// Linear trends are drawn from what the problem declares. Left out, contacts contradict the model.
#[test]
fn trends_of_encoders_are_in_the_intervals() {
    let mut declared = NeesSum::default();
    for seed in 1..=4 {
        let (mut problem, simulated) = trial(|recorder| recorder.encoder_trend = 0.01f64.to_radians(), seed);
        let estimate = solve(&problem);
        declared.add(&estimate, &simulated.truth);
        assert!(estimate.status.is_usable(), "seed {seed}: {:?}", estimate.warnings);
        problem.parameters.retain(|parameter| !parameter.name.starts_with("joint_trend"));
        let without = solve(&problem);
        assert!(!without.status.is_usable(), "seed {seed}: {:?}", without.warnings);
    }
    let declared = declared.per_parameter();
    report("encoder trends", &[("NEES for each parameter", declared)]);
    assert!((0.5..1.7).contains(&declared), "{declared}");
}

/// Trends that are linear in temperature: with the temperature they are found, and with the number
/// of the contact in its place the model is contradicted.
#[test]
fn trends_over_temperature_are_in_the_intervals() {
    let mut declared = NeesSum::default();
    for seed in 1..=4 {
        let warming = |recorder: &mut Recorder| {
            (recorder.encoder_trend, recorder.warm_up) = (0.02f64.to_radians(), 10.0);
        };
        let (mut problem, simulated) = trial(warming, seed);
        let estimate = solve(&problem);
        declared.add(&estimate, &simulated.truth);
        assert!(estimate.status.is_usable(), "seed {seed}: {:?}", estimate.warnings);
        for joint in 0..7 {
            let name = format!("joint_trend.joint_a{}", joint + 1);
            let found = estimate.parameter(&name).expect("a trend");
            let deviations = (found.value - simulated.truth.value(found.parameter.id)) / found.sigma.expect("a sigma");
            assert!(deviations.abs() < 4.5, "seed {seed}, {name}: {deviations} standard deviations");
        }
        problem.trend_variable = TrendVariable::Log;
        let over_log = solve(&problem);
        let is_contradicted = over_log.predictive_check.as_ref().is_none_or(|check| check.p_value < 1e-3);
        assert!(is_contradicted, "seed {seed}: {:?}", over_log.predictive_check);
    }
    let declared = declared.per_parameter();
    report("encoder trends over temperature", &[("NEES for each parameter", declared)]);
    assert!((0.5..1.7).contains(&declared), "{declared}");
}

/// Random walks are drawn from what the problem declares. Where they are not declared, stretches of
/// the log that contradict each other widen the intervals by as much as is not chance.
#[test]
fn random_walks_of_encoders_are_in_the_intervals() {
    let (mut declared, mut undeclared) = (NeesSum::default(), NeesSum::default());
    for seed in 1..=8 {
        let (mut problem, simulated) = trial(|recorder| recorder.encoder_walk = 0.01f64.to_radians(), seed);
        let estimate = solve(&problem);
        declared.add(&estimate, &simulated.truth);
        // Half-waves that are too short to be estimated are no contradiction.
        let is_predicted = estimate.predictive_check.as_ref().is_some_and(|check| check.p_value > 1e-3);
        assert!(estimate.status == Status::Usable && is_predicted, "seed {seed}: {:?}", estimate.warnings);
        problem.parameters.retain(|parameter| !parameter.name.starts_with("joint_walk"));
        let estimate = solve(&problem);
        if estimate.status.is_usable() {
            undeclared.add(&estimate, &simulated.truth);
        }
    }
    let [declared, undeclared] = [declared, undeclared].map(|sum| sum.per_parameter());
    report("encoder walks", &[("NEES for each parameter", declared), ("walks left out", undeclared)]);
    assert!((0.3..1.7).contains(&declared), "{declared}");
    assert!(undeclared < 2.2, "{undeclared}");
}
