//! The recipe of a calibration.

use super::problem::{Method, Problem};
use super::result::{Estimate, Observer};
use super::search::{
    SearchState, coarse_to_fine, descend, estimate_variance_components, find_competing_minimum, refine,
};
use super::summarize::summarize;

/// Estimates the parameters of a problem.
///
/// Minimizes, from zero, first the distance of all contact poses from their manifolds' envelopes,
/// then `Σ ρ(‖W r(θ)‖²) + Σ (θₖ/σₖ)² + Σ ((dᵢⱼ − d̂ᵢⱼ)/σᵢⱼ)²`. `r` is a contact's residual, `W`
/// whitens encoder and contact noise, and `ρ` is the problem's loss, its scale shrinking from one
/// that is nearly least squares. One-sided contacts finally contribute `−2 ln L` instead, the
/// marginal likelihood over their contact modes. Parameters without prior that nothing determines
/// are fixed at zero. `observe` is called at each step and may end the estimation.
/// [`Method::GradientDescent`] has its own search.
///
/// The covariance of two-sided contacts is that of an M-estimator, `(A²/B · Σ JᵀJ + Λ)⁻¹`, with `A`
/// the mean of ψ′, `B` that of ψ² over all contacts and `Λ` the priors, for at least the declared
/// noise (Huber, *Robust statistics* (1981), section 7.6). With one-sided contacts it is the
/// sandwich of their marginal likelihood times the design effect of correlated contacts.
pub fn calibrate(problem: &Problem, observe: Observer<'_>) -> Estimate {
    let mut search = SearchState::new(problem);
    match &problem.method {
        Method::GradientDescent(options) => descend(&mut search, options, observe),
        Method::LevenbergMarquardt => {
            let after_coarse = coarse_to_fine(&mut search, observe);
            estimate_variance_components(&mut search, observe);
            search.has_competing_minimum = find_competing_minimum(&mut search, &after_coarse, observe);
            refine(&mut search, observe);
        }
    }
    summarize(search)
}
