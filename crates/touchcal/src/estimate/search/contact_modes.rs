//! From the least gap of each contact to the marginal likelihood over its contact modes.

use nalgebra::DVector;

use super::annealing::anneal;
use super::coarse_to_fine::fine;
use super::newton::newton;
use super::state::SearchState;
use crate::estimate::model::{
    Curvature, Expectation, Objective, contact_mode_statistics, distance_information, em_step, extended_or_own,
    fix_bearing, fix_modes, no_contact_bounds, prior_information, residual_stretches, with_unestimated_errors,
};
use crate::estimate::result::{Observer, PredictiveCheck, Progress, Stage};
use crate::estimate::uncertainty::{Sandwich, predictive_check, sandwich_covariance};
use crate::solver::{FreeParameters, LevenbergMarquardtOptions, StopReason};

/// Share of informative contacts that the steps of expectation–maximisation require, over that
/// required at their end. With the inflated noise of the first steps fewer are informative.
const EARLY_SHARE: f64 = 0.6;
/// Newton decrement (1), by the information of complete data, at which Newton's method takes over:
/// a step of one standard deviation.
const NEWTON_DECREMENT: f64 = 1.0;

/// From the coarse stage to the contact modes of a subsample, where contacts are one-sided.
pub(crate) fn approach_contact_modes(search: &mut SearchState<'_>, observe: Observer<'_>) {
    if search.model.has_one_sided_contacts() {
        anneal(search, observe);
        fit_contact_modes(search, observe);
    }
}

/// Whether enough contacts are informative for the marginal likelihood to be used.
pub(crate) fn uses_contact_modes(search: &SearchState<'_>) -> bool {
    is_informative(search, 1.0)
}

/// Whether more contacts are informative than `factor` times the shares required.
fn is_informative(search: &SearchState<'_>, factor: f64) -> bool {
    let [of_all, of_distinct] = search.model.problem.options.contact_mode.min_informative_share.map(|min| factor * min);
    search.informative_share.is_some_and(|share| share.of_all > of_all && share.of_distinct > of_distinct)
}

/// From a subsample, its contact modes fitted, to all contacts, with their marginal likelihood if
/// enough are informative.
pub(crate) fn refine(search: &mut SearchState<'_>, observe: Observer<'_>) {
    if uses_contact_modes(search) {
        let noise = &mut search.model.noise;
        if search.model.problem.noise.is_estimated {
            noise.factor *= std::mem::replace(&mut noise.mode_factor, 1.0);
        }
        fix_bearing(&mut search.model, &search.theta, &mut search.caches);
        let fine = search.options().fine_contact_modes;
        let near = LevenbergMarquardtOptions { decrement: NEWTON_DECREMENT.max(fine.decrement), ..fine };
        search.minimize(Objective::ContactModes, 1, near, observe);
        fix_bearing(&mut search.model, &search.theta, &mut search.caches);
        let is_converged = search.is_finished() && finish(search, observe);
        if !is_converged && search.termination.reason == StopReason::NoDescent {
            fix_modes(&mut search.model, &search.theta, &mut search.caches);
            finish(search, observe);
        }
    } else if search.model.has_one_sided_contacts() {
        fine(search, observe);
    }
}

/// Newton's method, again after Levenberg–Marquardt if it is not close enough; returns whether it
/// converged.
fn finish(search: &mut SearchState<'_>, observe: Observer<'_>) -> bool {
    let is_converged = newton(search, observe);
    if is_converged || search.is_interrupted() {
        return is_converged;
    }
    search.minimize(Objective::ContactModes, 1, search.options().fine_contact_modes, observe);
    search.is_finished() && newton(search, observe)
}

/// Estimates the odds of contact modes by expectation–maximisation and, with subsamples, finds the
/// parameters where their likelihood is greatest. Does nothing if the search was interrupted or
/// failed.
pub(super) fn fit_contact_modes(search: &mut SearchState<'_>, observe: Observer<'_>) {
    let options = search.model.problem.options.contact_mode;
    let is_applicable = search.model.has_one_sided_contacts() && search.is_finished();
    // Noise estimated from least gaps may be far too small: of many candidates the least hardly
    // scatters.
    search.model.noise.mode_factor = (1.0 / search.model.noise.factor).max(1.0);
    search.informative_share = is_applicable.then(|| {
        let subsample = (search.model.stride(options.em_subsample[0]), Curvature::Complete);
        let statistics = contact_mode_statistics(&search.model, &search.theta, subsample, &mut search.caches);
        statistics.informative_share(&search.model)
    });
    if !is_informative(search, EARLY_SHARE) {
        return;
    }
    search.model.noise.mode_factor *= options.em_initial_inflation;
    let of_least_gaps = search.theta.clone();
    maximize_expectation(search, observe);
    if !uses_contact_modes(search) {
        // With noise declared much too small, touching nothing is more likely than any contact.
        search.theta = of_least_gaps;
    }
}

/// Expectation–maximisation, until the odds of the larger subsample change little, or too few
/// contacts are informative.
fn maximize_expectation(search: &mut SearchState<'_>, observe: Observer<'_>) {
    let options = search.model.problem.options.contact_mode;
    let bounds = no_contact_bounds(&search.model, &search.theta, search.model.stride(options.em_subsample[0]));
    for subsample in options.em_subsample {
        let stride = search.model.stride(subsample);
        let expectation = Expectation { stride, no_contact_bounds: &bounds };
        // Fewer contacts determine the odds less.
        let tolerance = options.em_tolerance * options.em_subsample[1] as f64 / subsample as f64;
        for iteration in 1..=options.em_max_iterations {
            let change = iterate(search, expectation, iteration, observe);
            if search.is_interrupted() || !is_informative(search, EARLY_SHARE) {
                return;
            }
            if change < tolerance {
                break;
            }
        }
    }
}

/// One iteration of expectation–maximisation: the odds, then the parameters; returns the change of
/// the odds.
fn iterate(search: &mut SearchState<'_>, expectation: Expectation<'_>, iteration: usize, observe: Observer<'_>) -> f64 {
    let em = em_step(&mut search.model, &search.theta, &search.free, expectation, &mut search.caches);
    search.informative_share = Some(em.informative_share);
    if !is_informative(search, EARLY_SHARE) {
        return em.change;
    }
    // Short steps of expectation–maximisation descend; longer ones are searched for, because
    // candidates enter and leave the gate on the way.
    match em.step {
        Some(step) => {
            search.theta += step;
            search.termination.iterations += 1;
            if observe(&Progress { stage: Stage::Fine, iteration, cost: em.cost }).is_break() {
                search.termination.reason = StopReason::Interrupted;
            }
        }
        None => {
            let decrement = em.short_decrement;
            let options = LevenbergMarquardtOptions { decrement, ..search.options().fine_contact_modes };
            search.minimize(Objective::ContactModes, expectation.stride, options, observe);
        }
    }
    em.change
}

/// How far stretches of the log are from what the others predict, by the residuals: those of
/// contacts that are not one-sided, and the least gaps of others that have no marginal likelihood.
pub(crate) fn residual_prediction(search: &mut SearchState<'_>) -> Option<PredictiveCheck> {
    // A gradient descent, or a search that has not converged, is at no minimum of least gaps.
    let is_unconverged = search.model.has_one_sided_contacts() && search.informative_share.is_none();
    if is_unconverged || !search.model.problem.has_uncertainty() || search.is_interrupted() {
        return None;
    }
    let extended = with_unestimated_errors(&search.model);
    let (model, errors) = extended_or_own(&search.model, extended.as_ref());
    let theta = search.theta.clone().resize_vertically(model.layout.len(), 0.0);
    let known = distance_information(&search.model, &search.theta) + prior_information(&search.model);
    let (stretches, covariance) = residual_stretches(model, &theta, &mut search.caches);
    predictive_check(&stretches, (&covariance, 1.0), &known, &search.free, errors)
}

/// The parameters' covariance by the marginal likelihood of all contacts, and how far stretches of
/// the log are from what the others predict, errors as correlated as the design effect says; if the
/// likelihood was fitted to the end and enough contacts are informative.
pub(crate) fn sandwich(search: &mut SearchState<'_>) -> Option<(Sandwich, Option<PredictiveCheck>)> {
    if !uses_contact_modes(search) || search.is_interrupted() {
        return None;
    }
    let extended = with_unestimated_errors(&search.model);
    let (model, errors) = extended_or_own(&search.model, extended.as_ref());
    let (own, size) = (search.model.layout.len(), model.layout.len());
    let theta = search.theta.clone().resize_vertically(size, 0.0);
    let known = distance_information(model, &theta) + prior_information(model);
    let at_theta = || contact_mode_statistics(model, &theta, (1, Curvature::Observed), &mut search.caches);
    let statistics = search.statistics.take().unwrap_or_else(at_theta);
    // What is in error is not estimated.
    let free = FreeParameters::new(search.free.scale().clone().resize_vertically(size, 0.0));
    let sandwich = sandwich_covariance(&statistics, &known, &free, &model.mode_priors);
    let own_known = known.view((0, 0), (own, own)).into_owned();
    let covariance = (&statistics.score_outer_product.information, sandwich.design_effect);
    let check = predictive_check(&statistics.stretches, covariance, &own_known, &search.free, errors);
    let of_errors = errors.iter().map(|&(k, sigma)| DVector::from_fn(size, |of, _| if of == k { sigma } else { 0.0 }));
    let all: Vec<DVector<f64>> = model.shape_errors().into_iter().chain(of_errors).collect();
    let mut sandwich = sandwich.with_errors(&statistics, &all);
    sandwich.covariance = sandwich.covariance.map(|all| all.view((0, 0), (own, own)).into_owned());
    Some((sandwich, check))
}
