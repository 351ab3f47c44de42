//! A force sensor with a bias or a filter, where joints deflect under the load: are the error bars
//! true?

use touchcal::estimate::WrenchTolerance;
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset, Scenario};

use crate::nees::NeesSum;
use crate::support::{report, solve};

const TRIALS: u64 = 8;

/// An arm with joints of 1e4 N m/rad, whose peg explores a hole, and a sensor as good as is
/// assumed.
fn scenario() -> Scenario {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Paper.scenario(robot).expect("parts");
    scenario.errors.joint_compliance = 1e-4;
    scenario.contacts = 1500;
    let WrenchTolerance { force, torque, scale } = WrenchTolerance::DEFAULT;
    scenario.recorder.force_bias = force;
    scenario.recorder.torque_bias = torque;
    scenario.recorder.wrench_scale = scale;
    scenario
}

/// The sensor's bias and scale are drawn from their defaults. Left out they shift compliances and
/// offsets by many standard deviations, which contacts hardly show.
#[test]
fn errors_of_the_wrench_are_in_the_intervals() {
    let (mut declared, mut exact) = (NeesSum::default(), NeesSum::default());
    for seed in 1..=TRIALS {
        let scenario = scenario();
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let mut problem = problem(&scenario, &simulated);
        assert_eq!(problem.wrench, WrenchTolerance::DEFAULT);
        let estimate = solve(&problem);
        declared.add(&estimate, &simulated.truth);
        assert!(estimate.status.is_usable(), "seed {seed}: {:?}", estimate.warnings);
        if seed <= 2 {
            problem.wrench = WrenchTolerance::EXACT;
            exact.add(&solve(&problem), &simulated.truth);
        }
    }
    let [declared, exact] = [declared, exact].map(|sum| sum.per_parameter());
    report("wrench", &[("NEES for each parameter", declared), ("wrench exact", exact)]);
    assert!((0.5..1.7).contains(&declared), "{declared}");
    assert!(exact > 10.0, "{exact}");
}

/// A peg that sticks to walls, and a sensor with a filter, which shifts compliances and offsets
/// where it is left in the load.
#[test]
fn friction_and_a_filter_are_in_the_intervals() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Workcell.scenario(robot).expect("parts");
    scenario.errors.joint_compliance = 1e-4;
    scenario.friction = 0.25;
    assert!(scenario.recorder.force_lag > 0.0);
    let (mut declared, mut ignored) = (NeesSum::default(), NeesSum::default());
    for seed in 1..=TRIALS {
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let estimate = solve(&problem(&scenario, &simulated));
        assert!(estimate.status.is_usable(), "seed {seed}: {:?}", estimate.warnings);
        declared.add(&estimate, &simulated.truth);
        if seed <= 2 {
            let mut without = scenario.clone();
            without.recorder.force_lag = 0.0;
            ignored.add(&solve(&problem(&without, &simulated)), &simulated.truth);
        }
    }
    let [declared, ignored] = [declared, ignored].map(|sum| sum.per_parameter());
    report("friction and a filter", &[("NEES for each parameter", declared), ("filter ignored", ignored)]);
    assert!((0.5..1.7).contains(&declared), "{declared}");
    assert!(ignored > 3.0, "{ignored}");
}
