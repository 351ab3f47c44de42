//! Scatter and distances of held-out contacts are as predicted, and contradicted where the
//! calibration has a false declaration.

use std::ops::ControlFlow;

use nalgebra::{Cholesky, DMatrix, DVector, Vector3};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use touchcal::contact::ContactLog;
use touchcal::estimate::{
    Contradiction, Estimate, Evaluation, ParameterPosterior, Problem, Status, Warning, apply_estimate,
    evaluate_held_out,
};
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{ParameterId, kinematic_part};
use touchcal::robot::Kinematics;
use touchcal::sim::{self, PlaceError, Preset, Scenario, SimulatedTrial};

use crate::support::{report, solve};

fn scenario(preset: Preset, contacts: usize) -> Scenario {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("an arm").robot;
    Scenario { contacts, ..preset.scenario(robot).expect("a scenario") }
}

/// The arm and the places of one seed, recorded with the noise of another.
fn recorded(scenario: &Scenario, seed: u64, noise_seed: u64) -> Problem {
    let truth = sim::draw_truth(scenario, seed);
    let logs = sim::run(scenario, &truth, noise_seed, &mut |_| ControlFlow::Continue(())).expect("logs");
    problem(scenario, &SimulatedTrial { truth, logs })
}

/// With the contacts of some fixtures only.
fn of_fixtures(mut problem: Problem, wanted: impl Fn(usize) -> bool) -> Problem {
    let all = problem.contacts.clone();
    problem.contacts = all.filtered(|i| wanted(all.fixture(i)));
    problem
}

fn held_out(check: &Problem, estimate: &Estimate) -> Evaluation {
    let mut evaluated = check.clone();
    apply_estimate(&mut evaluated, |name| estimate.parameter(name).map(|entry| entry.value));
    evaluated.robot = estimate.robot.clone();
    evaluate_held_out(check, &evaluated, ParameterPosterior::of_estimate(estimate).as_ref())
}

/// What evaluations with true declarations make.
#[derive(Default)]
struct Tally {
    evaluations: f64,
    squares: f64,
    distances: f64,
    squared_deviations: f64,
}

impl Tally {
    fn add(&mut self, evaluation: &Evaluation) {
        assert_eq!(evaluation.contradictions, [], "{:?}", evaluation.scatter);
        let scatter = evaluation.scatter.expect("a prediction");
        assert!(scatter.ratio() > scatter.by_chance[0], "{scatter:?}");
        self.evaluations += 1.0;
        self.squares += scatter.ratio().powi(2);
        self.distances += evaluation.distances.len() as f64;
        self.squared_deviations += evaluation.distances.iter().map(|d| d.deviations().powi(2)).sum::<f64>();
    }

    /// Mean squares of scatter found over predicted, and of distances in standard deviations.
    fn means(&self, what: &str) -> (f64, f64) {
        let means = (self.squares / self.evaluations, self.squared_deviations / self.distances.max(1.0));
        report(what, &[("mean square ratio", means.0), ("mean square deviation", means.1)]);
        means
    }
}

/// Calibrated in front, evaluated on the left and on the right, where the arm is off by more than
/// noise: with six contacts a socket two and a half times as much.
#[test]
fn sockets_elsewhere_scatter_as_predicted() {
    for contacts in [6, 30] {
        let scenario = scenario(Preset::Mukca, contacts);
        let mut tally = Tally::default();
        for seed in 1..=40 {
            let estimate = solve(&of_fixtures(recorded(&scenario, seed, seed), |f| f < 2));
            tally.add(&held_out(&of_fixtures(recorded(&scenario, seed, 1000 + seed), |f| f >= 2), &estimate));
        }
        let (squares, deviations) = tally.means(&format!("sockets elsewhere, {contacts} contacts each"));
        // Four standard deviations of a mean of forty with five degrees of freedom each; two
        // distances of an arm share its errors.
        assert!((squares - 1.0).abs() < 4.0 * (2.0 / 200.0_f64).sqrt(), "{squares}");
        assert!((deviations - 1.0).abs() < 4.0 * (2.0 / 40.0_f64).sqrt(), "{deviations}");
    }
}

/// Sockets of unknown place without contacts that are fitted, held out or forgotten, have known
/// distances: the arm is that of a problem without these sockets, and held-out ones are measured.
#[test]
fn sockets_that_no_fitted_contact_touches_change_nothing() {
    let all = recorded(&scenario(Preset::Mukca, 30), 3, 3);
    assert_eq!((all.fixtures.len(), all.distances.len()), (6, 3));
    let fitted = of_fixtures(all.clone(), |f| f < 4);
    let mut without = fitted.clone();
    without.fixtures.truncate(4);
    without.distances.truncate(2);
    let without = solve(&without);
    let held = of_fixtures(all.clone(), |f| f >= 4).contacts;
    let estimate = solve(&Problem { held_out: held, ..fitted.clone() });
    let evaluation = estimate.held_out.as_ref().expect("contacts that are held out");
    let [distance] = evaluation.distances.as_slice() else { panic!("{:?}", evaluation.distances) };
    assert!(distance.deviations().abs() < 4.0, "{distance:?}");
    let is_of_tool = |warning: &Warning| matches!(warning, Warning::ToolNotInRobot { .. });
    for (found, forgotten) in [(&estimate, 0), (&solve(&fitted), 2)] {
        assert_eq!(found.status, Status::Usable, "{:?}", found.warnings);
        let warnings: Vec<&Warning> = found.warnings.iter().filter(|warning| !is_of_tool(warning)).collect();
        assert_eq!(warnings.len(), forgotten, "{warnings:?}");
        assert!(warnings.iter().all(|warning| matches!(warning, Warning::FixtureWithoutContacts { .. })));
        for entry in &without.parameters {
            let same = found.parameter(&entry.parameter.name).expect("the same parameter");
            let sigma = entry.sigma.expect("a standard deviation");
            assert!((same.value - entry.value).abs() < 1e-3 * sigma, "{entry:?} {same:?}");
            assert!((same.sigma.unwrap() / sigma - 1.0).abs() < 1e-3, "{entry:?} {same:?}");
        }
    }
    // One of a pair is forgotten: the other one is not pulled to where the search starts.
    let estimate = solve(&of_fixtures(all, |f| f != 4));
    assert_eq!((estimate.status, estimate.contacts.rejected), (Status::Usable, 0), "{:?}", estimate.warnings);
}

/// A second hole, away from the first.
fn two_holes(place_error: PlaceError) -> Scenario {
    let mut scenario = scenario(Preset::Paper, 700);
    scenario.touches[0].place_error = place_error;
    let mut second = scenario.touches[0].clone();
    second.name = "second".to_owned();
    second.base_from_fixture.translation.vector += Vector3::new(-0.15, -0.35, 0.1);
    second.postures[0][0] -= 0.6;
    scenario.touches.push(second);
    scenario
}

#[test]
fn pegs_in_holes_scatter_as_predicted_and_holes_are_located() {
    let scenario = two_holes(PlaceError::default());
    let mut again = scenario.clone();
    again.touches.iter_mut().for_each(|touch| touch.exploration.swing = 0.4);
    let mut tally = Tally::default();
    for seed in 1..=8 {
        let estimate = solve(&recorded(&scenario, seed, seed));
        let evaluation = held_out(&recorded(&again, seed, 1000 + seed), &estimate);
        assert_eq!(evaluation.distances.len(), 1);
        assert!(evaluation.distances[0].sigma < 20e-6, "{:?}", evaluation.distances);
        tally.add(&evaluation);
    }
    let (squares, deviations) = tally.means("pegs in two holes");
    // The least of several gaps is predicted to 2.5 %; it locates a hole with a bias of a few
    // micrometres, which the standard deviation allows for.
    assert!((squares - 1.0).abs() < 0.05, "{squares}");
    assert!(deviations < 1.5, "{deviations}");
}

/// Two holes a millimetre from where they are declared: the distance of their places is off by as
/// much, and the standard deviation says so.
#[test]
fn a_distance_of_uncertain_places_has_their_standard_deviation() {
    let scenario = two_holes(PlaceError { length: 1e-3, angle: 0.0 });
    let estimate = solve(&recorded(&scenario, 3, 3));
    let evaluation = held_out(&recorded(&scenario, 3, 1003), &estimate);
    let [distance] = evaluation.distances.as_slice() else { panic!("{:?}", evaluation.distances) };
    assert!((distance.sigma / 2f64.sqrt() - 1e-3).abs() < 0.02e-3, "{distance:?}");
    let truth = sim::draw_truth(&scenario, 3);
    let [a, b] = [0, 1].map(|f| truth.base_from_fixture(&scenario, f).translation.vector);
    assert!((distance.found - (b - a).norm()).abs() < 0.1e-3, "{distance:?}");
}

/// Sockets 80 mm apart, declared 80.5 mm for the calibration and 80 mm for the evaluation.
#[test]
fn a_false_spacing_of_the_calibration_is_seen() {
    let mut scenario = scenario(Preset::Mukca, 30);
    scenario.touches.iter_mut().skip(1).step_by(2).for_each(|touch| touch.base_from_fixture.translation.x += 0.03);
    for sigma in [0.05e-3, 0.1e-3] {
        let declared = |noise_seed: u64, by: f64| {
            let mut problem = recorded(&scenario, 1, noise_seed);
            problem.distances.iter_mut().for_each(|distance| {
                distance.distance += by;
                distance.sigma = sigma;
            });
            problem
        };
        let right = held_out(&declared(2, 0.0), &solve(&declared(1, 0.0)));
        assert_eq!(right.contradictions, [], "{right:?}");
        let estimate = solve(&declared(1, 0.5e-3));
        assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
        let wrong = held_out(&declared(2, 0.0), &estimate);
        assert!(wrong.distances.iter().all(|distance| distance.deviations() > 3.0), "{:?}", wrong.distances);
        let [Contradiction::CommonStrain { strain, .. }] = wrong.contradictions.as_slice() else {
            panic!("{:?}", wrong.contradictions)
        };
        // Priors of the joints' origins keep a part of it.
        assert!((strain - 0.5 / 80.0).abs() < 0.3 * 0.5 / 80.0, "{strain}");
        assert!(!wrong.scatter.expect("a prediction").is_exceeded(), "scatter does not see it");
    }
}

/// An encoder that slipped by 0.05° since the calibration; there is no warning without a
/// posterior.
#[test]
fn an_arm_that_changed_is_contradicted() {
    let scenario = scenario(Preset::Paper, 500);
    let estimate = solve(&recorded(&scenario, 1, 1));
    let mut check = recorded(&scenario, 1, 2);
    assert_eq!(held_out(&check, &estimate).contradictions, []);
    let before = check.contacts;
    let mut contacts = ContactLog::new(before.dof());
    for i in 0..before.len() {
        let mut q = before.q(i).to_vec();
        q[1] += 0.05_f64.to_radians();
        contacts.push(&q, before.fixture(i), before.source(i));
    }
    check.contacts = contacts;
    let [Contradiction::Scatter { fixture: None, ratio, limit }] = held_out(&check, &estimate).contradictions[..]
    else {
        panic!("{:?}", held_out(&check, &estimate).contradictions)
    };
    assert!(ratio > 4.0 * limit, "{ratio} {limit}");
    let alone = evaluate_held_out(&check, &Problem { robot: estimate.robot, ..check.clone() }, None);
    assert!(alone.scatter.expect("a prediction").ratio() > 2.0 && alone.contradictions.is_empty());
}

/// Against arms drawn from the covariance, with drawn noise of the encoders: of few contacts in
/// front, so that the arm is off on the left and on the right.
#[test]
fn predicted_scatter_is_that_of_drawn_arms() {
    const DRAWS: usize = 4000;
    let mut scenario = scenario(Preset::Mukca, 10);
    scenario.contact_sigma = 0.0;
    let estimate = solve(&of_fixtures(recorded(&scenario, 1, 1), |f| f < 2));
    let check = of_fixtures(recorded(&scenario, 1, 2), |f| f >= 2);
    let scatter = held_out(&check, &estimate).scatter.expect("a prediction");

    let ids: Vec<ParameterId> = estimate.parameters.iter().map(|entry| entry.parameter.id).collect();
    let of_kinematics = |theta: &DVector<f64>| kinematic_part(ids.iter().copied().zip(theta.iter().copied()));
    let (parameters, values) = of_kinematics(&estimate.values());
    let mut kinematics = Kinematics::new(&check.robot, &parameters, check.tool.tip_from_tool);
    kinematics.set(&values);
    let contacts = &check.contacts;
    let place = |kinematics: &Kinematics, q: &[f64]| kinematics.pose(q).translation.vector;
    let middle: Vec<Vector3<f64>> = (0..contacts.len()).map(|i| place(&kinematics, contacts.q(i))).collect();
    let scale = DVector::from_iterator(ids.len(), estimate.covariance.diagonal().iter().map(|v| v.sqrt().max(1e-12)));
    let scaled = DMatrix::from_fn(ids.len(), ids.len(), |i, j| {
        estimate.covariance[(i, j)] / (scale[i] * scale[j]) + if i == j { 1e-9 } else { 0.0 }
    });
    let factor = Cholesky::new(scaled).expect("a covariance").l();
    let mut chance = Pcg64::seed_from_u64(1);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut chance) };
    let (mut squares, mut beyond) = (0.0, 0);
    for _ in 0..DRAWS {
        let theta = estimate.values() + (&factor * DVector::from_fn(ids.len(), |_, _| normal())).component_mul(&scale);
        kinematics.set(&of_kinematics(&theta).1);
        let mut of_fixture = vec![Vec::new(); check.fixtures.len()];
        for (i, middle) in middle.iter().enumerate() {
            let q: Vec<f64> = contacts.q(i).iter().map(|q| q + check.noise.encoder * normal()).collect();
            of_fixture[contacts.fixture(i)].push(place(&kinematics, &q) - middle);
        }
        let about_mean = |motions: &Vec<Vector3<f64>>| -> f64 {
            let mean = motions.iter().sum::<Vector3<f64>>() / motions.len().max(1) as f64;
            motions.iter().map(|motion| (motion - mean).norm_squared()).sum()
        };
        let square = of_fixture.iter().map(about_mean).sum::<f64>() / contacts.len() as f64;
        squares += square / DRAWS as f64;
        let ratio = square.sqrt() / scatter.predicted;
        beyond += usize::from(ratio < scatter.by_chance[0] || ratio > scatter.by_chance[1]);
    }
    let (ratio, share) = (squares.sqrt() / scatter.predicted, beyond as f64 / DRAWS as f64);
    report("scatter of drawn arms", &[("ratio", ratio), ("share beyond chance", share)]);
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    // A thousandth is expected; tails of a sum of squares are a little heavier than those of χ².
    assert!(share < 4e-3, "{share}");
}
