//! How well an arm explains contacts that it need not have been fitted to.

use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use super::model::{CalibrationModel, LinearizationPoint};
use super::problem::{PlacePrior, Problem};
use super::result::{Score, Spread};
use crate::manifold::{Residual, ResidualKind};
use crate::parameter::{ParameterId, encoder_errors};
use crate::robot::{KinematicParameter, subtract_encoder_errors};
use crate::se3::{self, Pose, Twist};

/// Number, mean, root mean square and maximum (m) of the contacts' distances from their manifolds,
/// over all contacts and for each fixture, by the problem's arm as it is, with tool and fixtures at
/// their nominal poses; nothing is estimated. All are 0 without contacts. A contact's distance is
/// that of [`contact_distances`]. Panics if a contact's fixture is not in [`Problem::fixtures`].
pub fn evaluate(problem: &Problem) -> Score {
    let model = CalibrationModel::new(problem);
    score(&LinearizationPoint::new(&model, &DVector::zeros(model.layout.len())))
}

/// Distance (m, ≥ 0) of each contact from its manifold, in the order of the log, at parameters
/// `values` (SI, one for each parameter, in the order of
/// [`Estimate::values`](super::Estimate::values); zeros are the problem's arm as it is, and missing
/// ones count as 0). Drifts, trends and walks of encoders and gap biases among them have no effect:
/// they are of one log.
///
/// A contact's distance is the norm of its manifold's residual, of at most its first three rows:
/// for a projection the distance of the positions. For a point manifold (ball in socket) it is the
/// distance from the mean offset of all contacts with that socket. [`Score`] summarizes these
/// distances. Panics if a contact's fixture is not in [`Problem::fixtures`].
pub fn contact_distances(problem: &Problem, values: &DVector<f64>) -> Vec<f64> {
    distances(&LinearizationPoint::new(&CalibrationModel::new(problem), values))
}

/// The residual (m) of each contact, of which [`contact_distances`] is the norm, in the order of
/// the log: the first three rows of its manifold's residual, zero where it has fewer; of a point
/// manifold the offset from the mean of that socket's contacts. Rows, signs and frames are those of
/// [`ResidualKind`]. `values` are as there. Panics if a contact's fixture is not in
/// [`Problem::fixtures`].
pub fn contact_residuals(problem: &Problem, values: &DVector<f64>) -> Vec<Vector3<f64>> {
    residuals(&LinearizationPoint::new(&CalibrationModel::new(problem), values))
}

/// Pose `fixture_from_tool` (m) of each contact with the fixture of index `fixture` in
/// [`Problem::fixtures`], by the problem's arm as it is and the fixture's nominal pose, in the
/// order of the log; empty if there is no such contact. Of a calibrated arm these are samples of
/// the fixture's contact manifold.
pub fn contact_poses(problem: &Problem, fixture: usize) -> Vec<Pose> {
    let model = CalibrationModel::new(problem);
    let point = LinearizationPoint::new(&model, &DVector::zeros(model.layout.len()));
    let contacts = (0..problem.contacts.len()).filter(|&i| problem.contacts.fixture(i) == fixture);
    let fixture_from_tool = |i: usize| {
        let pose = point.pose_without_drift(i);
        problem.contacts.target(i).map_or(pose, |target| target * pose)
    };
    contacts.map(fixture_from_tool).collect()
}

/// Moves tool and fixtures of `problem` to the poses that a calibration found, and fixes them
/// there. `value(name)` is the estimate of the parameter of that name (m, rad), `tool.x` or
/// `fixture.hole.rz`: a component of the local twist `[v; ω]` on the nominal pose; `None`, for what
/// was not estimated, counts as 0. It is asked only for what `problem` itself estimates: a tool or
/// fixture whose prior is [`PlacePrior::Fixed`] stays.
///
/// A fixture without a nominal pose is left as it is: its parameters are relative to contacts of
/// another log, and the score of a socket does not need its pose.
pub fn apply_estimated_places(problem: &mut Problem, value: impl Fn(&str) -> Option<f64>) {
    let mut tool = Twist::zeros();
    let mut fixtures = vec![Twist::zeros(); problem.fixtures.len()];
    for parameter in CalibrationModel::new(problem).layout.parameters {
        let value = value(&parameter.name).unwrap_or(0.0);
        match parameter.id {
            ParameterId::Kinematic(KinematicParameter::Tool(k)) => tool[k] = value,
            ParameterId::Fixture(f, k) => fixtures[f][k] = value,
            _ => {}
        }
    }
    problem.tool.tip_from_tool *= se3::exp(&tool);
    problem.tool.prior = PlacePrior::Fixed;
    for (fixture, twist) in problem.fixtures.iter_mut().zip(&fixtures) {
        if let Some(base_from_fixture) = &mut fixture.base_from_fixture {
            *base_from_fixture *= se3::exp(twist);
            fixture.prior = PlacePrior::Fixed;
        }
    }
}

/// Gives `problem` all that a calibration found beside its arm: the places of tool and fixtures
/// ([`apply_estimated_places`], with `value` as there), and joint positions of the contacts without
/// the errors of encoders that depend on the position, as `correction.json` corrects them.
pub fn apply_estimate(problem: &mut Problem, value: impl Fn(&str) -> Option<f64>) {
    apply_estimated_places(problem, &value);
    let errors = encoder_errors(&problem.robot, value);
    if !errors.is_empty() {
        let measured = problem.contacts.clone();
        problem.contacts = measured.with_positions(|i, q| subtract_encoder_errors(&errors, measured.q(i), q));
    }
}

/// The score of all contacts.
pub(super) fn score(point: &LinearizationPoint<'_>) -> Score {
    let problem = point.model.problem;
    let mut score = Score { all: Spread::default(), per_fixture: vec![Spread::default(); problem.fixtures.len()] };
    for (i, distance) in distances(point).into_iter().enumerate() {
        score.all.add(distance);
        score.per_fixture[problem.contacts.fixture(i)].add(distance);
    }
    score
}

/// Distances (m) of all contacts, in the order of the log.
fn distances(point: &LinearizationPoint<'_>) -> Vec<f64> {
    residuals(point).iter().map(Vector3::norm).collect()
}

/// Residuals (m) of all contacts, in the order of the log, those with a point about their mean.
fn residuals(point: &LinearizationPoint<'_>) -> Vec<Vector3<f64>> {
    let problem = point.model.problem;
    let each = (0..problem.contacts.len()).into_par_iter();
    let values: Vec<Vector3<f64>> = each.map_init(Residual::new, |rows, i| point.residual_vector(i, rows)).collect();
    let mut mean = vec![(Vector3::zeros(), 0usize); problem.fixtures.len()];
    for (i, value) in values.iter().enumerate() {
        let f = problem.contacts.fixture(i);
        if problem.fixtures[f].manifold.residual_kind() == ResidualKind::PointOffset {
            mean[f].0 += value;
            mean[f].1 += 1;
        }
    }
    let centered = values.iter().enumerate().map(|(i, value)| {
        let (sum, count) = mean[problem.contacts.fixture(i)];
        value - sum / count.max(1) as f64
    });
    centered.collect()
}
