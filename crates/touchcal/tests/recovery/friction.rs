//! Pegs that stick where they are pressed.

use crate::support::solve;
use touchcal::experiment;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset};

/// Friction stops the peg 2 mm above the floor of its hole and keeps it near that depth for most of
/// the contacts. Only contacts at the rim, which have no likelihood, show that the floor is deeper.
#[test]
fn where_a_peg_sticks_there_is_no_floor() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Workcell.scenario(robot).expect("parts");
    // At this rate the log ends within the first press, which along this path does not reach the
    // floor.
    scenario.recorder.rate = 300.0;
    let exploration = &mut scenario.touches[0].exploration;
    (exploration.random_phases, exploration.lift) = (false, 0.0);
    scenario.friction = 0.25;
    scenario.contact_sigma = 20e-6;
    scenario.touches[0].clearance_sigma = 30e-6;
    scenario.contacts = 1500;
    for seed in [1, 2, 3] {
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let deepest = simulated.logs[0].truth.iter().map(|row| row.fixture_from_tool.translation.z).reduce(f64::min);
        assert!(deepest.is_some_and(|z| z > -29e-3), "{deepest:?}");
        let estimate = solve(&experiment::problem(&scenario, &simulated));
        assert!(estimate.contacts.rejected < 75, "seed {seed}: {} rejected", estimate.contacts.rejected);
        let height = estimate.parameters.iter().find(|entry| entry.parameter.name == "fixture.hole.z").expect("height");
        let (error, sigma) = (height.value - simulated.truth.value(height.parameter.id), height.sigma.expect("known"));
        println!("seed {seed}: height off by {:.3} mm ± {:.3}", 1e3 * error, 1e3 * sigma);
        assert!(error.abs() < 1e-3 && error.abs() < 4.0 * sigma, "seed {seed}: {error:e} ± {sigma:e}");
    }
}
