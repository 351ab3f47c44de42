//! Distances of sockets that are declared nearly exact: simulated contacts with a ball.

use touchcal::estimate::{OmittedEffect, Problem, Status, Warning};
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset};

use crate::support::solve;

/// Six sockets in pairs, whose distances are declared with 0.01 mm; the first with an error of `by`
/// (m).
fn sockets(seed: u64, by: f64) -> Problem {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let scenario = Preset::Mukca.scenario(robot).expect("parts");
    let mut problem = problem(&scenario, &sim::simulate(&scenario, seed).expect("contacts"));
    problem.distances[0].distance += by;
    problem
}

/// Contacts follow a distance that is nearly exact, so that it is tested by its score: a right one
/// agrees, and the value of one that is 0.05 mm off is that error.
#[test]
fn a_distance_is_tested_where_contacts_follow_it() {
    for seed in 1..=4 {
        for by in [0.0, 0.05e-3] {
            let estimate = solve(&sockets(seed, by));
            let is_distance = |effect: &OmittedEffect| matches!(effect, OmittedEffect::Distance { .. });
            let tests: Vec<_> = estimate.effect_tests.iter().filter(|test| is_distance(&test.effect)).collect();
            assert_eq!(tests.len(), 3, "{:?}", estimate.untested);
            assert!(tests.iter().all(|test| test.p_value > 1e-3), "seed {seed}: {tests:?}");
            let first = tests.iter().find(|test| test.effect.name() == "distance.front/0.front/1").expect("a test");
            let found = &first.values[0];
            let deviations = (found.value + by) / found.sigma;
            assert!(found.sigma < 0.1e-3 && deviations.abs() < 3.0, "seed {seed}, {by}: {found:?}");
        }
    }
}

/// A distance that is so wrong that contacts with one of its sockets are rejected, all of them.
#[test]
fn without_the_contacts_of_a_socket_no_result_is_usable() {
    for seed in 1..=4 {
        let estimate = solve(&sockets(seed, 1.2e-3));
        assert_eq!(estimate.status, Status::NotUsable, "seed {seed}");
        let is_of_socket = |warning: &Warning| matches!(warning, Warning::ManyRejected { fixture: Some(name), share, .. } if name.starts_with("front/") && *share > 0.9);
        let is_far = |warning: &Warning| matches!(warning, Warning::FarFromPrior { .. });
        let is_said = estimate.warnings.iter().any(|warning| is_of_socket(warning) || is_far(warning));
        assert!(is_said, "seed {seed}: {:?}", estimate.warnings);
    }
}
