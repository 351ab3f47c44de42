//! Whether a declaration is wrong in kind: whether contacts that contradict the declarations agree
//! with them as soon as a unit, an axis, an order or a sign is another, or the arm.
//!
//! Declarations are compared by the cost of the coarse stage on a few contacts: squared distances
//! from the manifolds' envelopes, and squared deviations from priors and known distances. A wrong
//! declaration pays with one or the other, and a minimum closer to the contacts is not needed to
//! tell one kind from another.

mod alternatives;
mod coarse_fit;
mod other_arms;

use rayon::prelude::*;

use super::problem::{Fixture, PlacePrior, Problem};
use super::result::{DeclarationMistake, Warning};
use super::search::SearchState;
use alternatives::{possible_mistakes, without_mistake};
use coarse_fit::CoarseFit;
use other_arms::{better_than_places, other_arms, other_arms_with_another_tip};

/// Standard deviations (m, rad) of fixtures' places that are not declared.
const UNKNOWN: PlacePrior = PlacePrior::Gaussian { sigma: 1.0, sigma_angle: std::f64::consts::PI };
/// Least standard deviation (m) of known distances in a coarse fit: the scale of envelopes.
const MIN_DISTANCE_SIGMA: f64 = 0.5e-3;
/// Cost over that of the declarations (1), above which a fit without a mistake ends early: it would
/// have to come below a half of that.
const MAX_EARLY_COST: f64 = 10.0;
/// A first fit without each mistake has one in so many of the contacts. All contacts together
/// have the same weight whatever their number, so fewer of them are fitted no worse.
const CONTACTS_PER_FIRST: usize = 4;

/// The mistake without which contacts agree with the declarations far better, if there is one:
/// neither the parameters of `search` nor the minimum of the coarse stage come near. `None` for a
/// search that was interrupted.
pub(super) fn declaration_warning(search: &SearchState<'_>) -> Option<Warning> {
    let problem = search.model.problem;
    let options = &problem.options.declaration_check;
    let few = subsample(problem, options.contacts);
    // Where none of these few contacts has a known load there are no parameters of the wrench.
    if SearchState::new(&few).theta.len() != search.theta.len() {
        return None;
    }
    let found = CoarseFit::at(with_nominal_places(&few, search), search.theta.clone());
    if found.is_plausible(options) || search.is_interrupted() {
        return None;
    }
    let again = CoarseFit::minimum(few.clone(), problem.options.search.coarse.max_iterations);
    let declared = if again.cost < found.cost { again } else { found };
    if declared.is_plausible(options) {
        return None;
    }
    let fit_without = |mistake: &DeclarationMistake, problem: &Problem| {
        let without = without_mistake(problem, mistake);
        CoarseFit::minimum_below(without, options.max_iterations, MAX_EARLY_COST * declared.cost)
    };
    let fewer = subsample(&few, options.contacts.div_ceil(CONTACTS_PER_FIRST));
    let corrected = possible_mistakes(&few).into_par_iter().filter_map(|mistake| {
        let is_possible = fit_without(&mistake, &fewer).cost < declared.cost;
        let fit = is_possible.then(|| fit_without(&mistake, &few))?;
        Some((mistake, fit))
    });
    let mut candidates: Vec<(DeclarationMistake, CoarseFit)> = corrected.collect();
    let explains = |(_, fit): &(DeclarationMistake, CoarseFit)| {
        let is_plausible = fit.is_plausible(options) || fit.is_nearly_plausible_beside(declared.cost, options);
        is_plausible && fit.is_far_better_than(declared.cost, options)
    };
    candidates.retain(explains);
    let possible = |arms: Vec<_>| better_than_places(&few, arms.into_iter().filter(explains).collect());
    candidates.extend(possible(other_arms(&few)));
    if candidates.is_empty() {
        candidates = possible(other_arms_with_another_tip(&few));
    }
    candidates.sort_by(|(_, one), (_, other)| one.cost.total_cmp(&other.cost));
    let mut candidates = candidates.into_iter();
    let (mut mistake, corrected) = candidates.next()?;
    if let DeclarationMistake::FixturesExchanged { or, .. } = &mut mistake {
        let is_as_good = |(_, fit): &(DeclarationMistake, CoarseFit)| !corrected.is_far_better_than(fit.cost, options);
        or.extend(candidates.filter(is_as_good).filter_map(|(other, _)| match other {
            DeclarationMistake::FixturesExchanged { fixtures, .. } => Some(fixtures),
            _ => None,
        }));
    }
    Some(Warning::MistakenDeclaration { mistake, declared: declared.agreement(), corrected: corrected.agreement() })
}

/// The problem with about so many of its `contacts` (> 0), evenly spread over the log. Known
/// distances are no more accurate than a coarse fit; fixtures without a declared place may be
/// anywhere, since that where the nominal arm has them is no declaration.
fn subsample(problem: &Problem, contacts: usize) -> Problem {
    let stride = problem.contacts.len().div_ceil(contacts).max(1);
    let contacts = problem.contacts.filtered(|i| i % stride == 0);
    // Not a clone: a log may have millions of contacts.
    let mut few = Problem {
        distances: problem.distances.clone(),
        noise: problem.noise,
        parameters: problem.parameters.clone(),
        joint_drift: problem.joint_drift,
        trend_variable: problem.trend_variable,
        wrench: problem.wrench,
        options: problem.options,
        other_arms: problem.other_arms.clone(),
        ..Problem::new(problem.robot.clone(), problem.tool.clone(), problem.fixtures.clone(), contacts)
    };
    few.distances.iter_mut().for_each(|distance| distance.sigma = distance.sigma.max(MIN_DISTANCE_SIGMA));
    let is_unknown = |fixture: &Fixture| fixture.base_from_fixture.is_none() && fixture.prior == PlacePrior::Flat;
    for fixture in few.fixtures.iter_mut().filter(|fixture| is_unknown(fixture)) {
        fixture.prior = UNKNOWN;
    }
    few
}

/// The problem with the fixtures where `search` has them nominally.
fn with_nominal_places(problem: &Problem, search: &SearchState<'_>) -> Problem {
    let mut placed = problem.clone();
    for (fixture, place) in placed.fixtures.iter_mut().zip(&search.model.base_from_fixture) {
        fixture.base_from_fixture = Some(*place);
    }
    placed
}
