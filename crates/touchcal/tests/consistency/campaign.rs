//! Campaigns: the Cramér–Rao bound against differences, and rows that follow from scenario and seed
//! alone.

use nalgebra::{DMatrix, Matrix3, Vector3};
use touchcal::estimate::{Noise, cramer_rao};
use touchcal::experiment::{campaign_trial, problem};
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{KinematicParameter, Kinematics};
use touchcal::sim::{self, Preset, Scenario};

fn scenario(preset: Preset, arm: &str, contacts: usize) -> Scenario {
    let robot = urdf::read_builtin(arm, Ends::default()).expect("built in").robot;
    Scenario { contacts, ..preset.scenario(robot).expect("a preset") }
}

/// Balls in sockets of which all is known: `(Σ Jᵀ (G Σ Gᵀ + σ² I)⁻¹ J + Λ)⁻¹` with J and G by
/// central differences of the ball's place.
#[test]
fn the_bound_is_that_of_differences() {
    let scenario = scenario(Preset::Mukca, "panda", 40);
    let simulated = sim::simulate(&scenario, 5).expect("contacts");
    let mut problem = problem(&scenario, &simulated);
    // Places known, so that only the arm is left.
    for (fixture, touch) in problem.fixtures.iter_mut().zip(&scenario.touches) {
        fixture.base_from_fixture = Some(touch.base_from_fixture);
        fixture.prior = touchcal::estimate::PlacePrior::Fixed;
    }
    problem.tool.prior = touchcal::estimate::PlacePrior::Fixed;
    problem.distances.clear();
    let Noise { encoder, contact, .. } = problem.noise;
    let columns: Vec<KinematicParameter> =
        problem.parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect();
    let truth = |column| simulated.truth.value(column);
    let bound = cramer_rao(&problem, truth);
    assert_eq!(bound.nrows(), columns.len());

    let theta: Vec<f64> = columns.iter().map(|&column| truth(column.into())).collect();
    let place = |theta: &[f64], q: &[f64]| -> Vector3<f64> {
        let mut arm = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
        arm.set(theta);
        arm.pose(q).translation.vector
    };
    let difference = |at: &[f64], k: usize, f: &dyn Fn(&[f64]) -> Vector3<f64>| {
        let moved = |by: f64| {
            let mut moved = at.to_vec();
            moved[k] += by;
            f(&moved)
        };
        (moved(1e-6) - moved(-1e-6)) / 2e-6
    };
    let mut information = DMatrix::zeros(columns.len(), columns.len());
    for (k, parameter) in problem.parameters.iter().enumerate() {
        information[(k, k)] = parameter.prior_sigma().map_or(0.0, |sigma| sigma.powi(-2));
    }
    for i in 0..problem.contacts.len() {
        let q = problem.contacts.q(i);
        let slopes: Vec<Vector3<f64>> =
            (0..columns.len()).map(|k| difference(&theta, k, &|theta| place(theta, q))).collect();
        let mut noise = Matrix3::identity() * contact.powi(2);
        for k in 0..q.len() {
            let along = difference(q, k, &|q| place(&theta, q)) * encoder;
            noise += along * along.transpose();
        }
        let inverse = noise.try_inverse().expect("regular");
        for a in 0..columns.len() {
            for b in 0..columns.len() {
                information[(a, b)] += slopes[a].dot(&(inverse * slopes[b]));
            }
        }
    }
    let expected = information.cholesky().expect("priors").inverse();
    for k in 0..columns.len() {
        let (bound, expected) = (bound[(k, k)].sqrt(), expected[(k, k)].sqrt());
        assert!((bound / expected - 1.0).abs() < 1e-5, "{:?}: {bound} and {expected}", columns[k]);
    }
}

#[test]
fn a_row_follows_from_scenario_and_seed() {
    let scenario = scenario(Preset::Workcell, "iiwa14", 1000);
    let row = |trial| campaign_trial(&scenario, 7, trial).expect("contacts");
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    assert_eq!(row(2), one_thread.install(|| row(2)));
    assert_eq!((row(2).seed, row(2).trial), (9, 2));
    assert_ne!(row(2).nees, row(3).nees);
    // A millimetre and a third of a degree before.
    assert!(row(2).offset_error < 0.2f64.to_radians() && row(2).tool_distance < 3e-3, "{:?}", row(2));
}
