//! How well parameters could be known at best.

use nalgebra::{DMatrix, DVector};

use super::knowledge::covariance;
use super::problem::Problem;
use super::system::System;
use crate::robot::Column;

/// The Cramér–Rao bound: the covariance that no unbiased estimate from as many contacts can beat, of the parameters in the order of
/// [`Estimate::parameters`](super::Estimate).
///
/// The inverse of the information at the true parameters `truth` (0 for what is right): of the contacts, whose exact residuals have the declared encoder and contact
/// noise (errors in variables), of known distances and priors.
pub fn cramer_rao(problem: &Problem, truth: impl Fn(Column) -> f64) -> DMatrix<f64> {
    let system = System::new(problem);
    let each = system.parameters.iter().map(|parameter| truth(parameter.column));
    let theta = DVector::from_iterator(system.parameters.len(), each);
    let (contacts, _) = system.statistics(&theta);
    covariance(&(contacts + system.distance_information(&theta) + system.prior_information()), &system.scale())
}
