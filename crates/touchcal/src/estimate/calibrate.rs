//! The recipe of a calibration.

use super::declaration_checks::declaration_warning;
use super::options::Method;
use super::problem::Problem;
use super::result::{Estimate, Observer};
use super::search::{SearchState, coarse_to_fine, descend, estimate_variance_components, fit_from_starts, refine};
use super::summarize::{estimated_noise_factor, summarize};
use super::untouched::without_distances_to_unknown_places;

/// Largest number of searches that start from the noise that the one before found.
const MAX_NOISE_RESTARTS: usize = 3;
/// Estimated noise over its start (1) above which the search is repeated.
const MIN_NOISE_RATIO: f64 = 1.25;

/// Estimates the parameters of a problem.
///
/// Minimizes, from zero, first the distance of a subsample's poses from their manifolds' envelopes,
/// then `Σ ρ(‖W r(θ)‖²) + Σ (θₖ/σₖ)² + Σ ((dᵢⱼ − d̂ᵢⱼ)/σᵢⱼ)²`. `r` (m) is a contact's residual, `W`
/// (1/m) whitens encoder and contact noise, and `ρ` is the problem's loss, its scale shrinking from
/// one that is nearly least squares; `θₖ` are the parameters with priors of standard deviations
/// `σₖ`, and `dᵢⱼ` the distances (m) of fixtures `i` and `j`, declared as `d̂ᵢⱼ` with standard
/// deviation `σᵢⱼ`. One-sided contacts finally contribute `−2 ln L` instead, the marginal
/// likelihood over their contact modes. Parameters without prior that nothing determines are fixed
/// at zero. The place of a fixture without contacts and without a declared place is no parameter,
/// and distances to it are not used. `observe` is called at each step and may end the estimation:
/// the result is then that of the parameters reached. [`Method::GradientDescent`] has its own
/// search; [`Method`] names the sources. With one-sided contacts, noise that is estimated and ends
/// more than a quarter above its start is the start of another search, at most three times: too
/// small a noise leads to another minimum.
///
/// The covariance of two-sided contacts is that of an M-estimator, `(A²/B · Σ JᵀJ + Λ)⁻¹`, with `J`
/// the derivative of the whitened residual by the parameters, `A` the mean of ψ′ (at least 0.05)
/// and `B` that of ψ² over all residual rows, `ψ(r) = ρ′(r²) r`, and `Λ` the information of priors
/// and known distances, for at least the declared noise (Huber, *Robust statistics* (1981), section
/// 7.6). With one-sided contacts it is the sandwich of their marginal likelihood times the design
/// effect of correlated contacts; where that is not used, the former one times the square of
/// [`ContactModeOptions::least_gap_inflation`](super::ContactModeOptions::least_gap_inflation). All
/// are times the square of [`PredictiveCheck::widening`](super::PredictiveCheck::widening).
///
/// There is no error: an estimate that must not be used has the [`Status`](super::Status)
/// not usable, and [`Warning`](super::Warning)s with the cause; so has a problem without contacts.
/// Panics if a contact or distance has a fixture that is not in [`Problem::fixtures`].
pub fn calibrate(problem: &Problem, observe: Observer<'_>) -> Estimate {
    let fitted = without_distances_to_unknown_places(problem);
    summarize(fit(&fitted, observe), problem)
}

/// The search that [`calibrate`] makes, at its end: a minimum, unless it was interrupted or did not
/// converge. `problem` has no distances to unknown places.
pub(super) fn fit<'p>(problem: &'p Problem, observe: Observer<'_>) -> SearchState<'p> {
    let mut search = SearchState::new(problem);
    minimize(&mut search, observe);
    let mut start = 1.0;
    for _ in 0..MAX_NOISE_RESTARTS {
        let factor = estimated_noise_factor(&search);
        let is_larger = factor.is_finite() && factor > MIN_NOISE_RATIO * start;
        if !is_larger || !search.model.has_one_sided_contacts() || search.is_interrupted() {
            break;
        }
        let iterations = search.termination.iterations;
        search = SearchState::new(problem);
        (search.model.noise.factor, search.termination.iterations) = (factor, iterations);
        minimize(&mut search, observe);
        start = factor;
    }
    search
}

/// Leaves the parameters of the minimum in `search`.
fn minimize(search: &mut SearchState<'_>, observe: Observer<'_>) {
    match &search.model.problem.method {
        Method::GradientDescent(options) => descend(search, options, observe),
        Method::LevenbergMarquardt => {
            let after_coarse = coarse_to_fine(search, observe);
            estimate_variance_components(search, observe);
            // With a declaration that is wrong in kind every minimum is wrong.
            let has_mistake = |search: &SearchState<'_>| declaration_warning(search).is_some();
            fit_from_starts(search, &after_coarse, has_mistake, observe);
            // In the last steps rows that are grossly wrong have little weight anyway.
            search.model.gross_rows.clear();
            refine(search, observe);
        }
    }
}
