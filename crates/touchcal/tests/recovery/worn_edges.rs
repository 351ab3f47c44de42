//! Pegs and holes whose edges are rounder than declared.

use crate::support::solve;
use touchcal::estimate::{Estimate, OmittedEffect};
use touchcal::experiment;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::Block;
use touchcal::sim::{self, Preset, Scenario, Truth};

/// A stiff arm at a peg and hole whose edges are worn.
fn cell(edge_wear: f64, edge_radius_sigma: f64) -> Scenario {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Workcell.scenario(robot).expect("parts");
    (scenario.touches[0].edge_wear, scenario.touches[0].edge_radius_sigma) = (edge_wear, edge_radius_sigma);
    scenario
}

fn solved(scenario: &Scenario, seed: u64) -> (Estimate, Truth) {
    let simulated = sim::simulate(scenario, seed).expect("contacts");
    (solve(&experiment::problem(scenario, &simulated)), simulated.truth)
}

/// Intervals of encoder offsets allow for the tolerance of edges: they hold the truth, and are
/// wider than where edges count as exact.
#[test]
fn intervals_allow_for_worn_edges() {
    let (tolerant, exact) = (cell(0.0, 0.1e-3), cell(0.0, 0.0));
    for seed in [1, 2, 3] {
        let (estimate, truth) = solved(&tolerant, seed);
        let (sharp, _) = solved(&exact, seed);
        let offsets = |entry: &&touchcal::estimate::ParameterEstimate| entry.parameter.id.block() == Block::JointOffset;
        let mut wider: f64 = 0.0;
        for (entry, other) in estimate.parameters.iter().zip(&sharp.parameters).filter(|(entry, _)| offsets(entry)) {
            let sigma = entry.sigma.expect("known");
            let off = (entry.value - truth.value(entry.parameter.id)) / sigma;
            assert!(off.abs() < 4.0, "seed {seed}: {} off by {off} standard deviations", entry.parameter.name);
            wider = wider.max(sigma / other.sigma.expect("known"));
        }
        println!("seed {seed}: intervals up to {wider:.2} times as wide as with exact edges");
        assert!(wider > 1.2, "seed {seed}: {wider}");
    }
}

/// Edges that are declared sharp and exact and are not so show in a score test, which finds their
/// radius.
#[test]
fn worn_edges_declared_exact_are_told() {
    for seed in [1, 2, 3] {
        for (wear, is_worn) in [(0.2e-3, true), (0.0, false)] {
            let (estimate, _) = solved(&cell(wear, 0.0), seed);
            let edges = OmittedEffect::EdgeRadius { fixture: "hole".to_owned() };
            let test = estimate.effect_tests.iter().find(|test| test.effect == edges).expect("tested");
            let (value, sigma) = (test.values[0].value, test.values[0].sigma);
            println!("seed {seed}: p = {:.2e}, radius {:.3} ± {:.3} mm", test.p_value, 1e3 * value, 1e3 * sigma);
            assert_eq!(test.p_value < 1e-3, is_worn, "seed {seed}: {}", test.p_value);
            assert!((value - wear).abs() < 4.0 * sigma, "seed {seed}: {value} ± {sigma}");
        }
    }
}
