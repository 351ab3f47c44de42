//! The resolution to which manifolds blend nearly equal gaps.

use nalgebra::DVector;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use crate::solver::Loss;
use crate::statistics::upper_median;

/// Sets the resolution to the median standard deviation (m) of every `stride`-th contact's residual
/// at `theta`.
pub(crate) fn set_resolution(model: &mut CalibrationModel<'_>, theta: &DVector<f64>, stride: usize) {
    let point = LinearizationPoint::new(model, theta);
    let mut factor = ContactFactor::new(&point, false);
    let sigma = |i| {
        factor.evaluate(&point, i, Objective::Residual(Loss::Squared));
        factor.sigma()
    };
    let sigmas: Vec<f64> = (0..model.problem.contacts.len()).step_by(stride).map(sigma).collect();
    model.noise.resolution = upper_median(sigmas).unwrap_or(0.0);
}
