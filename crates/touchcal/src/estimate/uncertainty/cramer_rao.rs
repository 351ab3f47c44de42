//! The Cramér–Rao bound.

use nalgebra::{DMatrix, DVector};

use crate::estimate::model::{
    CalibrationModel, Curvature, Expectation, contact_caches, contact_mode_statistics, distance_information, em_step,
    no_contact_bounds, prior_information, set_resolution, whitened_norms,
};
use crate::estimate::problem::Problem;
use crate::parameter::ParameterId;
use crate::solver::FreeParameters;

/// Maximum number of iterations for the odds of contact modes, the number of contacts they use, and
/// the change that ends them: bounds then differ by a thousandth from where they settle.
const EM_ITERATIONS: usize = 10;
const EM_SUBSAMPLE: usize = 3000;
const EM_TOLERANCE: f64 = 0.25;

/// The Cramér–Rao bound: the covariance (SI) that no unbiased estimate from contacts at the same
/// joint positions can beat, where loads are known none from the surfaces that bear them; square,
/// rows and columns in the order of
/// [`Estimate::parameters`](crate::estimate::Estimate::parameters).
///
/// It is the inverse of the information at the true parameters: `truth(id)` is the true value of
/// each (SI, 0 for what is right). The information is that of the contacts, whose exact residuals
/// have the declared noise of encoders, contacts and loads (errors in variables), of known
/// distances and of priors. One-sided contacts have the marginal likelihood over their contact
/// modes, whose odds are estimated from them, as are widths of priors: their information is the sum
/// of the outer products of scores. If it is singular, the pseudo-inverse is returned; zeros if it
/// is not finite. Panics if a contact or distance has a fixture that is not in
/// [`Problem::fixtures`].
///
/// Source: Rao, *Information and the accuracy attainable in the estimation of statistical
/// parameters* (1945); Cramér, *Mathematical methods of statistics* (1946), chapter 32.
pub fn cramer_rao(problem: &Problem, truth: impl Fn(ParameterId) -> f64) -> DMatrix<f64> {
    let mut model = CalibrationModel::new(problem);
    let each = model.layout.parameters.iter().map(|parameter| truth(parameter.id));
    let theta = DVector::from_iterator(model.layout.len(), each);
    let free = FreeParameters::new(model.layout.scale());
    let mut caches = contact_caches(&model);
    let contacts = if model.has_one_sided_contacts() {
        set_resolution(&mut model, &theta, 1);
        let stride = model.stride(EM_SUBSAMPLE);
        let bounds = no_contact_bounds(&model, &theta, stride);
        let expectation = Expectation { stride, no_contact_bounds: &bounds };
        for _ in 0..EM_ITERATIONS {
            if em_step(&mut model, &theta, &free, expectation, &mut caches).change < EM_TOLERANCE {
                break;
            }
        }
        let size = model.layout.len();
        let statistics = contact_mode_statistics(&model, &theta, (1, Curvature::Observed), &mut caches);
        statistics.score_outer_product.information.view((0, 0), (size, size)).into_owned()
    } else {
        whitened_norms(&model, &theta, &mut caches).0
    };
    free.covariance(&(contacts + distance_information(&model, &theta) + prior_information(&model)))
}
