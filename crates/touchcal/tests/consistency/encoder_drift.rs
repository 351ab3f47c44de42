//! Encoders that drift over the log: are the error bars true?

use touchcal::estimate::Problem;
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

/// Random walks are drawn from what the problem declares. Where they are not declared, stretches of
/// the log that contradict each other widen the intervals by as much as is not chance.
#[test]
fn random_walks_of_encoders_are_in_the_intervals() {
    let (mut declared, mut undeclared) = (NeesSum::default(), NeesSum::default());
    for seed in 1..=8 {
        let (mut problem, simulated) = trial(|recorder| recorder.encoder_walk = 0.01f64.to_radians(), seed);
        declared.add(&solve(&problem), &simulated.truth);
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
