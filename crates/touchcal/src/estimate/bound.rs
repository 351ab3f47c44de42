//! How well parameters could be known at best.

use nalgebra::{DMatrix, DVector};

use super::knowledge::covariance;
use super::problem::Problem;
use super::system::System;
use crate::robot::Column;

/// Most steps of learning how often walls are touched.
const STEPS: usize = 10;
/// About so many contacts say that.
const ENOUGH: usize = 3000;
/// Change that ends it: bounds then differ by a thousandth from where they settle.
const SETTLED: f64 = 0.25;

/// The Cramér–Rao bound: the covariance that no unbiased estimate from as many contacts can beat, of the parameters in the order of
/// [`Estimate::parameters`](super::Estimate).
///
/// The inverse of the information at the true parameters `truth` (0 for what is right): of the contacts, whose exact residuals have the declared encoder and contact
/// noise (errors in variables), of known distances and priors. One-sided contacts have the likelihood of the walls that they may touch: their information is the
/// mean square of its slope.
pub fn cramer_rao(problem: &Problem, truth: impl Fn(Column) -> f64) -> DMatrix<f64> {
    let mut system = System::new(problem);
    let each = system.parameters.iter().map(|parameter| truth(parameter.column));
    let theta = DVector::from_iterator(system.parameters.len(), each);
    let scale = system.scale();
    let contacts = if system.has_walls() {
        system.set_resolution(&theta, 1);
        let stride = system.stride(ENOUGH);
        for _ in 0..STEPS {
            if system.learn_walls(&theta, &scale, stride).change < SETTLED {
                break;
            }
        }
        let size = system.parameters.len();
        system.wall_statistics(&theta, 1, true).squares_of_slope.information.view((0, 0), (size, size)).into_owned()
    } else {
        system.statistics(&theta).0
    };
    covariance(&(contacts + system.distance_information(&theta) + system.prior_information()), &scale)
}
