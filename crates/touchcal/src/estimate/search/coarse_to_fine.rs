//! From zero to the minimum of the residuals, with more contacts from stage to stage.

use nalgebra::DVector;

use super::annealing::anneal;
use super::state::SearchState;
use crate::estimate::model::{Objective, gross_rows};
use crate::estimate::result::Observer;
use crate::solver::Loss;

/// Largest shares of a fixture's contacts (1) that are left out as grossly wrong: before the first
/// minimization, where contacts in another posture may be far off because the nominal arm is, and
/// after each.
const GROSS_SHARE_AT_ZERO: f64 = 0.01;
const GROSS_SHARE: f64 = 0.1;
/// Most minimizations: a smaller error shows only once larger ones are left out.
const MAX_ROUNDS: usize = 4;

/// From zero towards the manifolds' envelopes; with parameters fixed that nothing determines there,
/// once more.
pub(crate) fn coarse(search: &mut SearchState<'_>, observe: Observer<'_>) {
    towards_envelopes(search, observe);
    if search.fix_unobservable() {
        towards_envelopes(search, observe);
    }
}

/// From zero onto the manifolds, again as long as unobservable parameters are found; returns the
/// parameters after the coarse stage.
pub(crate) fn coarse_to_fine(search: &mut SearchState<'_>, observe: Observer<'_>) -> DVector<f64> {
    let mut after_coarse = search.theta.clone();
    for _ in 0..search.options().max_restarts {
        coarse(search, observe);
        after_coarse.copy_from(&search.theta);
        anneal(search, observe);
        // One-sided contacts proceed to their contact modes, for which a subsample leads close
        // enough, if annealing reached its last and smallest noise.
        if !search.model.has_one_sided_contacts() || !search.is_finished() {
            fine(search, observe);
        }
        if !search.fix_unobservable() {
            break;
        }
    }
    after_coarse
}

/// From zero towards the envelopes without contacts that are grossly wrong at zero, again without
/// those that are grossly wrong there: in squared distances one of them outweighs hundreds of
/// others. With a squared loss all contacts count.
fn towards_envelopes(search: &mut SearchState<'_>, observe: Observer<'_>) {
    search.theta.fill(0.0);
    if search.model.problem.loss != Loss::Squared {
        search.model.gross_rows = gross_rows(&search.model, &search.theta, (search.stride(), GROSS_SHARE_AT_ZERO));
    }
    for _ in 0..MAX_ROUNDS {
        search.theta.fill(0.0);
        search.minimize(Objective::Envelope, search.stride(), search.options().coarse, observe);
        if search.is_interrupted() || search.model.problem.loss == Loss::Squared {
            break;
        }
        let gross = gross_rows(&search.model, &search.theta, (search.stride(), GROSS_SHARE));
        if gross == search.model.gross_rows {
            break;
        }
        search.model.gross_rows = gross;
    }
}

/// Fits the residuals, from few contacts to all.
pub(crate) fn fine(search: &mut SearchState<'_>, observe: Observer<'_>) {
    let (objective, options) = (Objective::Residual(search.model.problem.loss), search.options());
    let mut stride = search.stride() / options.subsample_growth;
    while stride > 1 {
        search.minimize(objective, stride, options.anneal, observe);
        stride /= options.subsample_growth;
    }
    search.minimize(objective, 1, options.fine, observe);
}
