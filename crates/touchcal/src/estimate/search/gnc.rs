//! Graduated non-convexity: a robust loss whose scale shrinks from one that holds most contacts.

use super::state::SearchState;
use crate::estimate::model::{ContactFactor, Objective, set_resolution};
use crate::estimate::result::Observer;
use crate::solver::Loss;

/// Fits the residuals of the smallest subsample with a loss that shrinks to the problem's.
pub(super) fn anneal(search: &mut SearchState<'_>, observe: Observer<'_>) {
    let (loss, stride, options) = (search.model.problem.loss, search.stride(), search.options());
    search.model.noise.resolution = 0.0;
    let mut scale = initial_scale(search, stride);
    while scale > 1.0 {
        search.minimize(Objective::Residual(loss.scaled(scale)), stride, options.anneal, observe);
        scale /= options.gnc_factor;
    }
    set_resolution(&mut search.model, &search.theta, stride);
    search.minimize(Objective::Residual(loss), stride, options.anneal, observe);
}

/// Scale of the first loss over that of the problem's, so that most contacts lie within it; at
/// least 1.
fn initial_scale(search: &SearchState<'_>, stride: usize) -> f64 {
    let k = match search.model.problem.loss {
        Loss::Squared => return 1.0,
        Loss::Huber(k) | Loss::Cauchy(k) | Loss::GemanMcClure(k) => k,
    };
    let point = search.point();
    let mut factor = ContactFactor::new(&point, false);
    let norm = |i| {
        factor.evaluate(&point, i, Objective::Residual(Loss::Squared));
        factor.squared_norm().sqrt()
    };
    let mut norms: Vec<f64> = (0..search.model.problem.contacts.len()).step_by(stride).map(norm).collect();
    norms.sort_unstable_by(f64::total_cmp);
    let rank = (search.options().gnc_initial_inliers * norms.len() as f64) as usize;
    (norms.get(rank).copied().unwrap_or(0.0) / k).max(1.0)
}
