//! Rows of a log in which nothing is touched.

use nalgebra::DVector;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use crate::solver::Loss;

/// For each fixture the largest number (1) of contacts with candidates that touch nothing, for each
/// that touches something, from every `stride`-th contact at `theta`.
///
/// Least gaps of rows that are no contacts are spread evenly over distances much larger than the
/// gate: there are as many of them within the gate as in the two ranges of its width beyond. One
/// more is allowed.
pub(crate) fn no_contact_bounds(model: &CalibrationModel<'_>, theta: &DVector<f64>, stride: usize) -> Vec<f64> {
    let gate = model.problem.options.contact_mode.gate.powi(2);
    let point = LinearizationPoint::new(model, theta);
    let mut factor = ContactFactor::new(&point, false);
    let mut counts = vec![(0.0, 0.0); model.problem.fixtures.len()];
    for i in (0..model.problem.contacts.len()).step_by(stride).filter(|&i| model.is_one_sided(i)) {
        factor.evaluate(&point, i, Objective::Residual(Loss::Squared));
        let (within, beyond) = &mut counts[model.problem.contacts.fixture(i)];
        match factor.squared_norm() {
            squared if squared <= gate => *within += 1.0,
            squared if squared <= 4.0 * gate => *beyond += 1.0,
            _ => {}
        }
    }
    counts.iter().map(|(within, beyond): &(f64, f64)| (beyond + 1.0) / (within - beyond).max(1.0)).collect()
}
