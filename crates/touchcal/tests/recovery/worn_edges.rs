//! Pegs and holes whose edges are rounder than declared.

use crate::support::solve;
use touchcal::experiment;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::Block;
use touchcal::sim::{self, Preset};

/// The radius of edges with a tolerance is found with the arm, five times better than declared.
#[test]
fn the_radius_of_worn_edges_is_found() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Workcell.scenario(robot).expect("parts");
    scenario.touches[0].edge_radius_sigma = 0.1e-3;
    for seed in [1, 2, 3] {
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let problem = experiment::problem(&scenario, &simulated);
        let estimate = solve(&problem);
        let deviation = |name: &str| {
            let entry = estimate.parameters.iter().find(|entry| entry.parameter.name == name).expect("estimated");
            let (error, sigma) = (entry.value - simulated.truth.value(entry.parameter.id), entry.sigma.expect("known"));
            (error / sigma, sigma)
        };
        let (off, sigma) = deviation("edge_radius.hole");
        println!("seed {seed}: edges off by {off:.2} times ± {:.4} mm", 1e3 * sigma);
        assert!(off.abs() < 4.0 && sigma < 0.02e-3, "seed {seed}: {off} ± {sigma:e}");
        let offsets = estimate.parameters.iter().filter(|entry| entry.parameter.id.block() == Block::JointOffset);
        let worst = offsets.map(|entry| deviation(&entry.parameter.name).0.abs()).fold(0.0, f64::max);
        assert!(worst < 4.0, "seed {seed}: {worst}");
    }
}
