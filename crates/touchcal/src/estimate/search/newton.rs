//! The last steps to the minimum of the marginal likelihood.
//!
//! Levenberg–Marquardt takes the information of complete data, as if it were known what each
//! contact touches. In directions in which this is hardly known it is many times the information
//! observed, and steps are as many times too short: the search would end on the way, standard
//! deviations from the minimum. Newton's method with the observed information (Louis 1982) takes
//! one or two steps.

use nalgebra::DVector;

use super::state::SearchState;
use crate::estimate::model::{
    CalibrationModel, ContactModeStatistics, Curvature, contact_mode_statistics, extended_or_own, observed_equations,
    with_unestimated_errors,
};
use crate::estimate::result::{Observer, Progress, Stage};
use crate::solver::{DampedInformation, KINK_TOLERANCE, NormalEquations, StopReason, Termination};

/// Most steps.
const MAX_STEPS: usize = 10;
/// Shares of a step that are tried, one after the other.
const STEP_SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// The model with the errors that are not estimated, see [`with_unestimated_errors`].
type Extended<'e, 'p> = Option<&'e (CalibrationModel<'p>, Vec<(usize, f64)>)>;

/// The marginal likelihood at some parameters.
struct Linearization {
    theta: DVector<f64>,
    /// Sums over the contacts, by parameters that are not estimated too.
    statistics: ContactModeStatistics,
    /// Normal equations of the estimated parameters.
    normal: NormalEquations,
}

impl Linearization {
    /// At `theta`; counts as an iteration of the search.
    fn new(search: &mut SearchState<'_>, extended: Extended<'_, '_>, theta: DVector<f64>) -> Self {
        search.termination.iterations += 1;
        let (model, _) = extended_or_own(&search.model, extended);
        let all = theta.clone().resize_vertically(model.layout.len(), 0.0);
        let statistics = contact_mode_statistics(model, &all, (1, Curvature::Observed), &mut search.caches);
        let normal = observed_equations(&search.model, &theta, &statistics);
        Linearization { theta, statistics, normal }
    }
}

/// Minimizes the marginal likelihood of all contacts, from parameters close to its minimum; returns
/// whether what is left of the Newton decrement is below its limit, or within ten times the limit
/// where no step is good, on a kink. Otherwise the parameters are those of the last good step: the
/// information was not positive definite, no share of the next step was good, there were ten steps,
/// or the observer ended the search. The sums over the contacts stay in the search.
pub(super) fn newton(search: &mut SearchState<'_>, observe: Observer<'_>) -> bool {
    let extended = with_unestimated_errors(&search.model);
    let mut here = Linearization::new(search, extended.as_ref(), search.theta.clone());
    let is_converged = descend(search, extended.as_ref(), &mut here, observe);
    search.theta = here.theta;
    search.statistics = Some(here.statistics);
    is_converged
}

/// Takes the steps of [`newton`] from `here`, and leaves the last good one there.
fn descend(
    search: &mut SearchState<'_>,
    extended: Extended<'_, '_>,
    here: &mut Linearization,
    observe: Observer<'_>,
) -> bool {
    let options = search.options().fine_contact_modes;
    for iteration in 1..=MAX_STEPS.min(options.max_iterations) {
        if observe(&Progress { stage: Stage::Fine, iteration, cost: here.normal.cost }).is_break() {
            search.termination.reason = StopReason::Interrupted;
            return false;
        }
        let Some(information) = here.normal.damped(&search.free, 0.0) else { return false };
        let before = information.decrement(&here.normal.gradient);
        let better = good_step(search, extended, here, (&information, before));
        let is_better = better.is_some();
        let mut measured = before;
        if let Some((next, after)) = better {
            (*here, measured) = (next, after);
        }
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

/// The likelihood after the largest share of a Newton step from `here` that is good, and the
/// decrement left there, by the same `information`. A share λ is good if it takes the decrement
/// below `(1 − λ/4)²` of the one `before` (restricted monotonicity test: Deuflhard, *Newton
/// methods for nonlinear problems* (2004), section 3.3). The cost must fall as well if the step is
/// so long that the cost would judge a step of Levenberg–Marquardt.
fn good_step(
    search: &mut SearchState<'_>,
    extended: Extended<'_, '_>,
    here: &Linearization,
    (information, before): (&DampedInformation, f64),
) -> Option<(Linearization, f64)> {
    let gradient_test_below = search.options().fine_contact_modes.gradient_test_below;
    let step = information.step(&here.normal.gradient);
    STEP_SHARES.into_iter().find_map(|share| {
        let next = Linearization::new(search, extended, &here.theta + &step * share);
        let (normal, cost) = (&next.normal, here.normal.cost);
        let after = information.decrement(&normal.gradient);
        let is_short = before <= gradient_test_below.powi(2) * normal.rows;
        let is_good = after <= (1.0 - share / 4.0).powi(2) * before && (is_short || normal.cost < cost);
        (is_good && normal.cost.is_finite()).then_some((next, after))
    })
}
