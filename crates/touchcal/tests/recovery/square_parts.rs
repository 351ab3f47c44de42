//! Pegs and holes with a discrete rotational symmetry.

use crate::support::solve;
use touchcal::estimate::Warning;
use touchcal::experiment;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset};

/// A square peg fits a square hole in four ways, and contacts with a hole in an unknown place leave
/// all four possible. A rotation known to some degrees rules three of them out.
#[test]
fn a_free_hole_may_be_turned_by_quarters() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Workcell.scenario(robot).expect("parts");
    scenario.contacts = 300;
    for free in [true, false] {
        scenario.touches[0].free = free;
        let simulated = sim::simulate(&scenario, 1).expect("contacts");
        let estimate = solve(&experiment::problem(&scenario, &simulated));
        let turns: Vec<(&str, f64)> = estimate.warnings.iter().filter_map(symmetric_part).collect();
        if free {
            assert_eq!(turns, [("fixture.hole.rz", std::f64::consts::FRAC_PI_2)]);
        } else {
            assert_eq!(turns, []);
        }
    }
}

fn symmetric_part(warning: &Warning) -> Option<(&str, f64)> {
    match warning {
        Warning::SymmetricPart { name, angle } => Some((name, *angle)),
        _ => None,
    }
}
