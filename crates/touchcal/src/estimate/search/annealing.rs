//! From a cost so wide that contacts lead from afar to that of the problem.
//!
//! Two-sided contacts have a robust loss whose scale shrinks (graduated non-convexity: Yang,
//! Antonante, Tzoumas & Carlone 2020). One-sided contacts have the marginal likelihood with a noise
//! that shrinks (deterministic annealing: Ueda & Nakano, *Deterministic annealing EM algorithm*
//! (1998)): at first a contact may touch any surface near it, in the end only those that its noise
//! allows. With a loss of its least gap a contact would touch the nearest surface from the start.

use super::state::SearchState;
use crate::estimate::contact_mode::ContactModePrior;
use crate::estimate::model::{ContactFactor, Objective, set_resolution};
use crate::estimate::result::Observer;
use crate::parameter::ParameterId;
use crate::solver::Loss;

/// Fits the smallest subsample with a cost whose scale shrinks to the problem's: the marginal
/// likelihood of one-sided contacts, or the residuals of others.
pub(super) fn anneal(search: &mut SearchState<'_>, observe: Observer<'_>) {
    if search.model.has_one_sided_contacts() {
        anneal_noise(search, observe);
    } else {
        anneal_loss(search, observe);
    }
}

/// Fits the residuals with a loss that is wide at first, and shrinks.
pub(super) fn anneal_loss(search: &mut SearchState<'_>, observe: Observer<'_>) {
    let (loss, stride, options) = (search.model.problem.loss, search.stride(), search.options());
    search.model.noise.resolution = 0.0;
    let mut scale = initial_scale(search);
    while scale > 1.0 {
        search.minimize(Objective::Residual(loss.scaled(scale)), stride, options.anneal, observe);
        scale /= options.annealing_factor;
    }
    set_resolution(&mut search.model, &search.theta, stride);
    search.minimize(Objective::Residual(loss), stride, options.anneal, observe);
}

/// Fits the marginal likelihood with a noise that is large at first, and shrinks.
pub(super) fn anneal_noise(search: &mut SearchState<'_>, observe: Observer<'_>) {
    let (stride, options) = (search.stride(), search.options());
    search.model.noise.resolution = 0.0;
    let mut scale = initial_scale(search);
    let noise = search.model.noise.factor;
    let priors = search.model.mode_priors.clone();
    loop {
        search.model.noise.factor = noise * scale;
        let of_region = |prior: &ContactModePrior| prior.with_noise(scale);
        search.model.mode_priors = priors.iter().map(|regions| regions.iter().map(of_region).collect()).collect();
        search.minimize(Objective::ContactModes, stride, options.anneal_contact_modes, observe);
        if scale <= 1.0 || search.is_interrupted() {
            break;
        }
        scale = (scale / options.annealing_factor).max(1.0);
    }
    search.model.noise.factor = noise;
    search.model.mode_priors = priors;
    // Their width is estimated from zero on.
    for (k, parameter) in search.model.layout.parameters.iter().enumerate() {
        if matches!(parameter.id, ParameterId::DirectionalGapBias(..)) {
            search.theta[k] = 0.0;
        }
    }
    set_resolution(&mut search.model, &search.theta, stride);
}

/// Scale of the first cost over that of the problem's, so that most contacts lie within it; at
/// least 1.
fn initial_scale(search: &SearchState<'_>) -> f64 {
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
    let mut norms: Vec<f64> = (0..search.model.problem.contacts.len()).step_by(search.stride()).map(norm).collect();
    norms.sort_unstable_by(f64::total_cmp);
    let rank = (search.options().annealing_inliers * norms.len() as f64) as usize;
    (norms.get(rank).copied().unwrap_or(0.0) / k).max(1.0)
}
