//! A hole with a depth tolerance far above the noise.

use touchcal::experiment::problem;
use touchcal::geometry::{Parts, PrismPair};
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Preset, Recorder};

use crate::support::{report, solve};

/// A depth that is off by its standard deviation, ten times the noise: each estimate changes by no
/// more than its standard deviation. In one direction contacts hardly tell what they touch, and the
/// information of complete data is much larger than the observed information; a search that ends by
/// the information of complete data changes encoder offsets by five standard deviations.
#[test]
fn a_depth_that_is_off_moves_estimates_by_no_more_than_they_allow() {
    const OFF: f64 = 0.02e-3;
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Workcell.scenario(robot).expect("parts");
    scenario.errors.joint_compliance = 1e-4;
    (scenario.friction, scenario.contact_sigma) = (0.0, 0.002e-3);
    let exact = Recorder::exact(scenario.recorder.rate, scenario.recorder.force_threshold);
    scenario.recorder = Recorder { encoder_sigma: 0.0002f64.to_radians(), ..exact };
    scenario.touches.iter_mut().for_each(|touch| (touch.depth_sigma, touch.unequal_clearance_sigma) = (0.0, 0.0));
    let simulated = sim::simulate(&scenario, 4).expect("contacts");
    scenario.touches.iter_mut().for_each(|touch| touch.depth_sigma = OFF);
    let right = solve(&problem(&scenario, &simulated));
    for touch in &mut scenario.touches {
        let Parts::PegInHole(pair) = &touch.parts else { panic!("a peg in a hole") };
        let deeper = PrismPair::new(pair.peg().clone(), pair.length(), pair.hole().clone(), pair.depth() + OFF);
        touch.parts = Parts::PegInHole(Box::new(deeper.expect("parts")));
    }
    let off = solve(&problem(&scenario, &simulated));
    let mut largest: f64 = 0.0;
    for (one, other) in right.parameters.iter().zip(&off.parameters) {
        if let (false, Some(sigma)) = (one.parameter.id.block().is_nuisance(), other.sigma) {
            largest = largest.max((one.value - other.value).abs() / sigma);
        }
    }
    report("depth off by a standard deviation", &[("largest change in standard deviations", largest)]);
    assert!((0.1..1.1).contains(&largest), "{largest}");
}
