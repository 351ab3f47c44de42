//! Pegs and holes whose edges are rounder than declared.

use std::ops::ControlFlow;

use crate::support::solve;
use touchcal::estimate::{Estimate, OmittedEffect, calibrate_with_freed_effects};
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

/// Intervals of encoder offsets allow for the tolerance of edges: they hold the truth where edges
/// are worn.
#[test]
fn intervals_allow_for_worn_edges() {
    for seed in [1, 2, 3] {
        let (estimate, truth) = solved(&cell(0.0, 0.1e-3), seed);
        for entry in estimate.parameters.iter().filter(|entry| entry.parameter.id.block() == Block::JointOffset) {
            let off = (entry.value - truth.value(entry.parameter.id)) / entry.sigma.expect("known");
            assert!(off.abs() < 3.0, "seed {seed}: {} off by {off} standard deviations", entry.parameter.name);
        }
    }
}

/// The edges of this trial are worn by 0.12 mm, declared to 0.05 mm: the tool's z ends 4.6 standard
/// deviations of its prior away, as far as edges may move it. While the search takes its last
/// steps contacts pass the rim of the hole, whose height is poorly known: without these the search
/// continues.
#[test]
fn contacts_that_pass_the_rim_do_not_end_a_search() {
    let (estimate, truth) = solved(&cell(0.0, 0.05e-3), 5029);
    let termination = estimate.termination;
    assert!(estimate.status.is_usable(), "{termination:?} {:?}", estimate.warnings);
    for entry in estimate.parameters.iter().filter(|entry| entry.parameter.id.kinematic().is_some()) {
        let off = (entry.value - truth.value(entry.parameter.id)) / entry.sigma.expect("known");
        assert!(off.abs() < 3.0, "{} off by {off} standard deviations", entry.parameter.name);
    }
}

/// Where the same contacts are declared with a tolerance of edges, estimates are the same, and
/// intervals are wider, some by half.
#[test]
fn a_tolerance_of_edges_widens_intervals_alone() {
    let scenario = cell(0.0, 0.0);
    let exact = experiment::problem(&scenario, &sim::simulate(&scenario, 1).expect("contacts"));
    let mut tolerant = exact.clone();
    tolerant.fixtures[0].tolerance.edge_radius = 0.1e-3;
    let (exact, tolerant) = (solve(&exact), solve(&tolerant));
    assert_eq!(exact.values(), tolerant.values());
    let sigmas =
        exact.parameters.iter().zip(&tolerant.parameters).map(|(exact, tolerant)| (exact.sigma, tolerant.sigma));
    let ratios: Vec<f64> = sigmas.map(|(exact, tolerant)| tolerant.expect("known") / exact.expect("known")).collect();
    assert!(ratios.iter().all(|ratio| *ratio > 0.999), "{ratios:?}");
    assert!(ratios.iter().any(|ratio| *ratio > 1.5), "{ratios:?}");
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

/// With a tolerance instead, which contradicted edges get, intervals hold the truth.
#[test]
fn worn_edges_declared_exact_are_freed() {
    let scenario = cell(0.2e-3, 0.0);
    let simulated = sim::simulate(&scenario, 1).expect("contacts");
    let problem = experiment::problem(&scenario, &simulated);
    let (_, estimate) = calibrate_with_freed_effects(&problem, &mut |_| ControlFlow::Continue(()));
    let edges = OmittedEffect::EdgeRadius { fixture: "hole".to_owned() };
    assert!(estimate.freed_effects.iter().any(|freed| freed.effect == edges), "{:?}", estimate.freed_effects);
    for entry in estimate.parameters.iter().filter(|entry| entry.parameter.id.block() == Block::JointOffset) {
        let off = (entry.value - simulated.truth.value(entry.parameter.id)) / entry.sigma.expect("known");
        assert!(off.abs() < 3.0, "{} off by {off} standard deviations", entry.parameter.name);
    }
}
