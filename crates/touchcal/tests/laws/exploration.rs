//! Paths along which a simulated arm explores a hole.

use nalgebra::Vector3;
use touchcal::sim::{self, Preset, Scenario};

use crate::simulation::{hole, iiwa, paper};

/// Places of the tool in the hole's frame (m), a hundred a second.
fn path(scenario: &Scenario, seed: u64) -> Vec<Vector3<f64>> {
    let log = sim::simulate(scenario, seed).expect("contacts").logs.remove(0);
    log.truth.iter().map(|row| row.fixture_from_tool.translation.vector).collect()
}

/// With random phases each trial has a path of its own, and in each the first press, of 5.9 s,
/// takes the tool deep into the hole; without them all trials follow the same path.
#[test]
fn random_phases_are_other_paths_that_enter_the_hole() {
    let mut scenario = Scenario { contact_sigma: 0.0, friction: 0.1, ..paper(600) };
    scenario.recorder.rate = 100.0;
    assert_eq!(path(&scenario, 1), path(&scenario, 2));
    scenario.touches[0].exploration.random_phases = true;
    let paths: Vec<_> = (1..=8).map(|seed| path(&scenario, seed)).collect();
    for pair in paths.windows(2) {
        let apart = pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).norm());
        assert!(apart.fold(0.0, f64::max) > 0.5e-3);
    }
    for path in &paths {
        let deepest = path.iter().take(590).map(|at| at.z).fold(0.0, f64::min);
        assert!(deepest < -0.8 * hole(&scenario).depth(), "{deepest}");
    }
    assert_eq!(path(&scenario, 3), paths[2]);
}

/// Where a tool with friction comes to an edge, steps of the search for its rest alternate between
/// the faces beside it: in these trials 29.16 s and 25.48 s after the start, without and with edges
/// that are worn and a tool that leaves its hole.
#[test]
fn a_tool_at_an_edge_comes_to_rest() {
    let mut worn = Preset::Workcell.scenario(iiwa()).expect("parts");
    worn.errors.joint_compliance = 1e-4;
    worn.recorder.force_bias = 0.5;
    worn.touches[0].clearance_sigma = 0.03e-3;
    worn = Scenario { friction: 0.1, contact_sigma: 0.02e-3, ..worn };
    let mut sharp = Scenario { friction: 0.25, ..worn.clone() };
    let touch = &mut sharp.touches[0];
    (touch.edge_radius_sigma, touch.unequal_clearance_sigma, touch.exploration.lift) = (0.0, 0.0, 0.0);
    for (scenario, seed, time) in [(sharp, 801, 29.16), (worn, 5450, 25.48)] {
        let log = sim::simulate(&scenario, seed).expect("a rest").logs.remove(0);
        assert_eq!(log.contacts().count(), scenario.contacts);
        assert!(log.time.last() > Some(&time), "{seed}");
    }
}
