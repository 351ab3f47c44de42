//! Tests of declarations that are drawn from their standard deviations.

use std::ops::ControlFlow;

use touchcal::estimate::{Acceptance, Declaration, Distance, ErrorFrame, Estimate, PriorTest, Problem, calibrate};
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset};

use crate::freed_effects::posed;
use crate::support::report;

fn solve(problem: &Problem) -> Estimate {
    calibrate(problem, &mut |_| ControlFlow::Continue(()))
}

/// Tool, hole and shapes off by draws from what is declared: tests of the posterior against the
/// prior reject none, and the statistics of each are those of so many directions, or somewhat less,
/// since estimates vary less than what they estimate.
#[test]
fn what_is_drawn_from_its_prior_agrees_with_it() {
    const KINDS: [&str; 3] = ["tool", "fixture.hole", "gap_bias.hole"];
    let (mut statistics, mut directions, mut least) = ([0.0; 3], [0; 3], 1.0_f64);
    for seed in 1..=16 {
        let (problem, _) = posed("all_drawn", seed);
        let tests = solve(&problem).prior_tests;
        for (k, name) in KINDS.into_iter().enumerate() {
            let test = tests.iter().find(|test| test.declaration.name() == name).expect("a test");
            statistics[k] += test.statistic;
            directions[k] += test.degrees_of_freedom;
        }
        least = tests.iter().map(|test| test.p_value).fold(least, f64::min);
    }
    assert!(least > 1e-3, "{least}");
    for (k, name) in KINDS.into_iter().enumerate() {
        let mean = statistics[k] / f64::from(u32::try_from(directions[k]).expect("few"));
        report(&format!("drawn from its prior: {name}"), &[("statistic a direction", mean)]);
        // Three standard errors of some fifty directions, the least of them less varied by half.
        assert!(mean > 0.3 && mean < 1.6, "{name}: {mean}");
    }
}

/// Balls in pairs of sockets: distances that are right agree, one that is declared 1 mm too long
/// with a standard deviation of 0.1 mm is contradicted, by an estimate that is drawn to it by a
/// part.
#[test]
fn a_distance_is_tested_against_its_standard_deviation() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let scenario = Preset::Mukca.scenario(robot).expect("parts");
    for seed in 1..=4 {
        let mut posed = problem(&scenario, &sim::simulate(&scenario, seed).expect("contacts"));
        posed.distances.iter_mut().for_each(|distance| distance.sigma = 1e-4);
        let of_distance = |estimate: &Estimate, posed: &Problem, distance: Distance| -> PriorTest {
            let (a, b) = distance.between;
            let between = [a, b].map(|f| posed.fixtures[f].name.clone());
            let declaration = Declaration::Distance { between };
            estimate.prior_tests.iter().find(|test| test.declaration == declaration).expect("a test").clone()
        };
        let right = solve(&posed);
        for &distance in &posed.distances {
            let test = of_distance(&right, &posed, distance);
            assert!(test.p_value > 1e-2, "seed {seed}: {test:?}");
        }
        posed.distances[0].distance += 1e-3;
        let test = of_distance(&solve(&posed), &posed, posed.distances[0]);
        let found = test.values[0].value;
        assert!(test.p_value < 1e-5 && found < -0.5e-3 && found > -1.1e-3, "seed {seed}: {test:?}");
    }
}

/// A task of one pose does not make the arm better known.
#[test]
fn unseen_effects_widen_by_what_they_do_everywhere() {
    let (mut problem, _) = posed("nothing", 1);
    let without = solve(&problem);
    let position = problem.contacts.q(0).to_vec();
    let asked = Acceptance {
        distance: 1e-3,
        angle: None,
        confidence: 0.95,
        frame: ErrorFrame::Base,
        positions: vec![position],
    };
    problem.acceptance = Some(asked);
    let with = solve(&problem);
    assert!(problem.allows_for_unseen_effects() && with.acceptance.is_some());
    assert_eq!(with.covariance, without.covariance);
}
