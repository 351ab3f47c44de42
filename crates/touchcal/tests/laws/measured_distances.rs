//! Distances that a simulation measures, and the problem that they are declared in.

use nalgebra::Vector3;
use touchcal::estimate::EXACT_DISTANCE_SIGMA;
use touchcal::experiment;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::ParameterId;
use touchcal::sim::{self, MeasuredDistance, PlaceError, Preset, Truth};

#[test]
fn distances_are_measured_with_the_error_declared() {
    const SIGMA: f64 = 0.2e-3;
    const SEEDS: u64 = 200;
    let mut scenario = Preset::Mukca.scenario(urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot).unwrap();
    scenario.touches[0].place_error = PlaceError { length: 1e-3, angle: 0.0 };
    let alone = scenario.clone();
    // From one block to another, and on one block, where the distance is known otherwise too.
    scenario.distances =
        vec![MeasuredDistance { between: (2, 0), sigma: SIGMA }, MeasuredDistance { between: (0, 1), sigma: 0.0 }];
    let origin = |f: usize| scenario.touches[f].base_from_fixture.translation.vector;
    let mut squares = 0.0;
    let mut sum = 0.0;
    for seed in 0..SEEDS {
        let truth = sim::draw_truth(&scenario, seed);
        // The axes of these fixtures are the base's.
        let moved = Vector3::from_fn(|k, _| truth.value(ParameterId::Fixture(0, k)));
        let length = (origin(2) - origin(0) - moved).norm();
        assert!((truth.distance(&scenario, 0) - length).abs() < 1e-12 && moved.norm() > 1e-5);
        let error = truth.measured_distance(&scenario, 0) - length;
        sum += error;
        squares += error * error;
        assert!((truth.measured_distance(&scenario, 1) - (origin(1) - origin(0)).norm()).abs() < 1e-12);
        // What else is drawn is the same without distances.
        assert_eq!(Truth { distance_error: Vec::new(), ..truth }, sim::draw_truth(&alone, seed));
    }
    let count = SEEDS as f64;
    // Four standard deviations of either statistic: 1/√n of the mean, 1/√(2n) of the spread.
    assert!(sum.abs() / count < 4.0 * SIGMA / count.sqrt(), "{:e}", sum / count);
    let spread = (squares / count).sqrt() / SIGMA;
    assert!((spread - 1.0).abs() < 4.0 / (2.0 * count).sqrt(), "{spread}");

    scenario.contacts = 2;
    let simulated = sim::simulate(&scenario, 1).unwrap();
    let known = experiment::problem(&scenario, &simulated).distances;
    let pairs: Vec<_> = known.iter().map(|known| known.between).collect();
    assert_eq!(pairs, [(2, 3), (4, 5), (2, 0), (0, 1)], "each once");
    assert_eq!(known[2].distance, simulated.truth.measured_distance(&scenario, 0));
    assert_eq!((known[2].sigma, known[3].sigma), (SIGMA, EXACT_DISTANCE_SIGMA));
    // Two fixtures at one place have no distance that could be declared.
    scenario.touches[2].base_from_fixture = scenario.touches[0].base_from_fixture;
    scenario.touches[0].place_error = PlaceError::default();
    scenario.distances[0].sigma = 0.0;
    let error = sim::simulate(&scenario, 1).unwrap_err().to_string();
    assert!(error.contains("distance of `left/0` and `front/0` is measured as 0.000 mm"), "{error}");
}
