//! The last steps to the minimum of the marginal likelihood.
//!
//! Levenberg–Marquardt takes the information of complete data, as if it were known what each
//! contact touches. In directions in which this is hardly known it is many times the information
//! observed, and steps are as many times too short: the search would end on the way, standard
//! deviations from the minimum. Newton's method with the observed information (Louis 1982) takes
//! one or two steps.

use nalgebra::DVector;

use super::state::SearchState;
use crate::estimate::model::{Objective, observed_equations};
use crate::estimate::result::{Observer, Progress, Stage};
use crate::solver::{DampedInformation, KINK_TOLERANCE, StopReason, Termination};

/// Most steps.
const MAX_STEPS: usize = 10;
/// Shares of a step that are tried, one after the other.
const STEP_SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// Minimizes the marginal likelihood of all contacts, from parameters close to its minimum; returns
/// whether what is left of the Newton decrement is below its limit, or within ten times the limit
/// where no step is good, on a kink. Otherwise the parameters are those of the last good step: the
/// information was not positive definite, no share of the next step was good, there were ten steps,
/// or the observer ended the search.
pub(super) fn newton(search: &mut SearchState<'_>, observe: Observer<'_>) -> bool {
    let options = search.options().fine_contact_modes;
    for iteration in 1..=MAX_STEPS.min(options.max_iterations) {
        let normal = observed_equations(&search.model, &search.theta, &mut search.caches);
        search.termination.iterations += 1;
        if observe(&Progress { stage: Stage::Fine, iteration, cost: normal.cost }).is_break() {
            search.termination.reason = StopReason::Interrupted;
            return false;
        }
        let Some(information) = normal.damped(&search.free, 0.0) else { return false };
        let before = information.decrement(&normal.gradient);
        let better = good_step(search, &information, &normal.gradient, (before, normal.cost));
        let is_better = better.is_some();
        let (theta, measured) = better.unwrap_or((search.theta.clone(), before));
        search.theta = theta;
        let is_converged = measured <= if is_better { 1.0 } else { KINK_TOLERANCE } * options.decrement;
        let reason = match (is_converged, is_better) {
            (true, _) => StopReason::Converged,
            (false, true) => StopReason::IterationLimit,
            (false, false) => StopReason::NoDescent,
        };
        let iterations = search.termination.iterations;
        search.termination = Termination { reason, measured, threshold: options.decrement, iterations };
        if is_converged || !is_better {
            return is_converged;
        }
    }
    false
}

/// The parameters after the largest share of a Newton step that is good, and the decrement left
/// there, by the same information. A share λ is good if it takes the decrement below `(1 − λ/4)²`
/// of the one `before` (restricted monotonicity test: Deuflhard, *Newton methods for nonlinear
/// problems* (2004), section 3.3). The cost must fall as well if the step is so long that the cost
/// would judge a step of Levenberg–Marquardt.
fn good_step(
    search: &mut SearchState<'_>,
    information: &DampedInformation,
    gradient: &DVector<f64>,
    (before, cost): (f64, f64),
) -> Option<(DVector<f64>, f64)> {
    let gradient_test_below = search.options().fine_contact_modes.gradient_test_below;
    let step = information.step(gradient);
    STEP_SHARES.into_iter().find_map(|share| {
        let theta = &search.theta + &step * share;
        search.termination.iterations += 1;
        let normal = search.normal_equations(&theta, Objective::ContactModes, 1);
        let after = information.decrement(&normal.gradient);
        let is_short = before <= gradient_test_below.powi(2) * normal.rows;
        let is_good = after <= (1.0 - share / 4.0).powi(2) * before && (is_short || normal.cost < cost);
        (is_good && normal.cost.is_finite()).then_some((theta, after))
    })
}
