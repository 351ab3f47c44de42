//! Encoders that drift over the log: are the error bars true?

use touchcal::estimate::Status;
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset};

use crate::nees::NeesSum;
use crate::support::{report, solve};

/// Trends and random walks are drawn from what the problem declares. Linear trends leave of a walk
/// what scatters about a straight line.
#[test]
fn drifts_of_encoders_are_in_the_intervals() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut sums = [NeesSum::default(), NeesSum::default(), NeesSum::default()];
    for seed in 1..=6 {
        let mut scenario = Preset::Paper.scenario(robot.clone()).expect("parts");
        scenario.contacts = 1500;
        let [declared, walking, undeclared] = &mut sums;
        scenario.recorder.encoder_trend = 0.01f64.to_radians();
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let mut problem_of_trend = problem(&scenario, &simulated);
        let estimate = solve(&problem_of_trend);
        declared.add(&estimate, &simulated.truth);
        assert_eq!(estimate.status, Status::Converged, "seed {seed}: {:?}", estimate.warnings);
        problem_of_trend.parameters.retain(|parameter| !parameter.name.starts_with("joint_trend"));
        undeclared.add(&solve(&problem_of_trend), &simulated.truth);

        scenario.recorder.encoder_trend = 0.0;
        scenario.recorder.encoder_walk = 0.01f64.to_radians();
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        walking.add(&solve(&problem(&scenario, &simulated)), &simulated.truth);
    }
    let [declared, walking, undeclared] = sums.map(|sum| sum.per_parameter());
    report("encoder drift", &[("trends", declared), ("walks", walking), ("undeclared", undeclared)]);
    assert!((0.5..1.7).contains(&declared), "{declared}");
    assert!((0.3..2.0).contains(&walking), "{walking}");
    assert!(undeclared > 3.0, "{undeclared}");
}
