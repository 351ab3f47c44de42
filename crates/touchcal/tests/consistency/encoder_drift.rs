//! Encoders that drift over the log: are the error bars true?

use touchcal::estimate::Status;
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset};

use crate::nees::NeesSum;
use crate::support::{report, solve};

/// Linear trends are drawn from what the problem declares.
#[test]
fn trends_of_encoders_are_in_the_intervals() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let (mut declared, mut undeclared) = (NeesSum::default(), NeesSum::default());
    for seed in 1..=4 {
        let mut scenario = Preset::Paper.scenario(robot.clone()).expect("parts");
        scenario.contacts = 1000;
        scenario.recorder.encoder_trend = 0.01f64.to_radians();
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let mut problem = problem(&scenario, &simulated);
        let estimate = solve(&problem);
        declared.add(&estimate, &simulated.truth);
        assert_eq!(estimate.status, Status::Converged, "seed {seed}: {:?}", estimate.warnings);
        problem.parameters.retain(|parameter| !parameter.name.starts_with("joint_trend"));
        undeclared.add(&solve(&problem), &simulated.truth);
    }
    let [declared, undeclared] = [declared, undeclared].map(|sum| sum.per_parameter());
    report("encoder trends", &[("NEES for each parameter", declared), ("trends left out", undeclared)]);
    assert!((0.5..1.7).contains(&declared), "{declared}");
    assert!(undeclared > 10.0, "{undeclared}");
}
