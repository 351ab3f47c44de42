//! Whether the minimum is the right one, and the only one.
//!
//! Gaps have many minima. From contacts that cover the hole well, every search ends in the same
//! one; from few contacts, or little motion, searches end in different ones, each with small
//! standard deviations. Where contacts scatter more than at a right minimum, the search is repeated
//! from other starts, drawn from the posterior of the coarse stage, and continued from the most
//! likely minimum. If contacts still scatter too much there, and another minimum was found, or
//! another minimum is about as likely, the result is ambiguous.

use nalgebra::{Cholesky, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::annealing::anneal;
use super::state::SearchState;
use crate::estimate::model::{Objective, contact_equations};
use crate::estimate::result::Observer;
use crate::solver::Termination;

/// Where a search ended.
struct End {
    theta: DVector<f64>,
    /// `−2 ln L` and priors (1) of the subsample, by the initial odds of contact modes.
    cost: f64,
    termination: Termination,
}

/// Searches from other starts if the minimum may not be the right one, and goes to the most likely
/// end; says in `search` whether another end competes with it, and whether contacts still scatter
/// more than at a right minimum.
pub(crate) fn find_competing_minimum(search: &mut SearchState<'_>, after_coarse: &DVector<f64>, observe: Observer<'_>) {
    let options = search.model.problem.options.multi_start;
    let is_applicable = search.model.has_one_sided_contacts() && !search.model.problem.noise.is_estimated;
    if !is_applicable || scatter(search) < options.min_scatter {
        return;
    }
    let Some(starts) = starts(search, after_coarse, options.starts) else { return };
    let resolution = search.model.noise.resolution;
    let mut ends = vec![end(search)];
    for start in starts {
        search.theta = start;
        anneal(search, observe);
        search.model.noise.resolution = resolution;
        if search.is_interrupted() {
            break;
        }
        ends.push(end(search));
    }
    let best = (0..ends.len()).fold(0, |best, k| if ends[k].cost < ends[best].cost { k } else { best });
    let iterations = search.termination.iterations;
    search.theta = ends[best].theta.clone();
    if !search.is_interrupted() {
        search.termination = Termination { iterations, ..ends[best].termination };
    }
    let (stride, contacts) = (search.stride(), search.model.problem.contacts.len());
    let margin = options.max_cost_difference * contacts.div_ceil(stride) as f64;
    let has_excess_scatter = scatter(search) >= options.min_scatter;
    let information =
        search.normal_equations(&ends[best].theta, Objective::Residual(search.model.problem.loss), stride);
    let competes = |other: &End| {
        let step = &other.theta - &ends[best].theta;
        let squared_distance = step.dot(&(&information.information * &step)) / stride as f64;
        let is_likely = has_excess_scatter || other.cost < ends[best].cost + margin;
        squared_distance > options.min_squared_distance && is_likely
    };
    search.has_competing_minimum = ends.iter().any(competes);
    search.has_excess_scatter = has_excess_scatter;
}

/// Root mean square of the whitened least gaps (1), weighted by the loss.
fn scatter(search: &mut SearchState<'_>) -> f64 {
    let (objective, stride) = (Objective::Residual(search.model.problem.loss), search.stride());
    let contacts = contact_equations(&search.model, &search.theta, (objective, stride), &mut search.caches);
    (contacts.squares / contacts.rows.max(f64::MIN_POSITIVE)).sqrt()
}

/// The present parameters as the end of a search.
fn end(search: &mut SearchState<'_>) -> End {
    let (theta, stride) = (search.theta.clone(), search.stride());
    let cost = search.normal_equations(&theta, Objective::ContactModes, stride).cost / stride as f64;
    End { theta, cost, termination: search.termination }
}

/// Starts drawn from the posterior of the coarse stage.
fn starts(search: &mut SearchState<'_>, after_coarse: &DVector<f64>, count: u64) -> Option<Vec<DVector<f64>>> {
    let stride = search.stride();
    let normal = search.normal_equations(after_coarse, Objective::Envelope, stride);
    let factor = Cholesky::new(search.free.scaled_regular(&normal.information))?.l();
    let scale = search.free.scale();
    let start = |seed| {
        let mut random = Pcg64::seed_from_u64(seed);
        let each = (0..scale.len()).map(|_| StandardNormal.sample(&mut random));
        let draw = DVector::from_iterator(scale.len(), each);
        Some(after_coarse + factor.tr_solve_lower_triangular(&draw)?.component_mul(scale))
    };
    (0..count).map(start).collect()
}
