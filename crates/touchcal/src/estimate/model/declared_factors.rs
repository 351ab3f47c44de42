//! Factors of known distances and of priors.

use nalgebra::{DMatrix, DVector};

use super::calibration_model::CalibrationModel;
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use crate::estimate::problem::Distance;
use crate::parameter::{Parameter, ParameterId};
use crate::se3::{self, Twist};
use crate::solver::NormalEquations;

/// Adds the known distances between fixtures' origins. Their errors are parameters in extended
/// models alone, where they are zero.
pub(crate) fn add_distances(point: &LinearizationPoint<'_>, normal: &mut NormalEquations) {
    let parameters = &point.model.layout.parameters;
    for (d, distance) in point.model.problem.distances.iter().enumerate() {
        let (mut row, length) = distance_row(point, distance);
        let error = parameters.iter().position(|parameter| parameter.id == ParameterId::Distance(d));
        row.extend(error.map(|k| (k, -1.0)));
        let (index, jacobian): (Vec<usize>, Vec<f64>) =
            row.into_iter().map(|(k, slope)| (k, slope / distance.sigma)).unzip();
        let residual = (length - distance.distance) / distance.sigma;
        normal.add_row(&index, &jacobian, residual, 1.0);
        normal.cost += residual * residual;
    }
}

/// Indices of the parameters that the distance between two fixtures' origins depends on, with its
/// derivative by each (SI), and that distance (m).
pub(crate) fn distance_row(point: &LinearizationPoint<'_>, distance: &Distance) -> (Vec<(usize, f64)>, f64) {
    let (a, b) = distance.between;
    let [from, to] = [a, b].map(|f| point.fixtures[f].base_from_fixture.translation.vector);
    let span = to - from;
    let length = span.norm();
    let along = span / length.max(f64::MIN_POSITIVE);
    let slope = |(k, parameter): (usize, &Parameter)| match parameter.id {
        ParameterId::Fixture(f, component) if f == a || f == b => {
            let fixture = &point.fixtures[f];
            let local: Twist = fixture.right_jacobian.column(component).into();
            let motion = fixture.base_from_fixture.rotation * se3::linear(&local);
            Some((k, along.dot(&motion) * if f == b { 1.0 } else { -1.0 }))
        }
        _ => None,
    };
    (point.model.layout.parameters.iter().enumerate().filter_map(slope).collect(), length)
}

/// Adds the priors. In the coarse stage parameters without one get a Gaussian of their plausible
/// size, so that nothing collapses (an arm of no length touches a free socket perfectly).
pub(crate) fn add_priors(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    objective: Objective,
    normal: &mut NormalEquations,
) {
    for (k, parameter) in model.layout.parameters.iter().enumerate() {
        let plausible = (objective == Objective::Envelope).then_some(parameter.scale);
        if let Some(sigma) = parameter.prior_sigma().or(plausible) {
            let residual = theta[k] / sigma;
            normal.add_row(&[k], &[1.0 / sigma], residual, 1.0);
            normal.cost += residual * residual;
        }
    }
}

/// Information of the known distances at `theta`.
pub(crate) fn distance_information(model: &CalibrationModel<'_>, theta: &DVector<f64>) -> DMatrix<f64> {
    let mut normal = NormalEquations::new(model.layout.len());
    add_distances(&LinearizationPoint::new(model, theta), &mut normal);
    normal.complete().information
}

/// Information of the priors.
pub(crate) fn prior_information(model: &CalibrationModel<'_>) -> DMatrix<f64> {
    let parameters = &model.layout.parameters;
    let each = parameters.iter().map(|p| p.prior_sigma().map_or(0.0, |sigma| sigma.powi(-2)));
    DMatrix::from_diagonal(&DVector::from_iterator(parameters.len(), each))
}
