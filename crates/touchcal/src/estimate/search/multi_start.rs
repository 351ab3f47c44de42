//! Whether the minimum is the only one.
//!
//! Gaps have many minima. From contacts that cover the hole well, every search ends in the same
//! one; from few contacts, or little motion, searches end in different ones, each with small
//! standard deviations. Where contacts scatter more than at a right minimum, the search is repeated
//! from other starts, drawn from the posterior of the coarse stage; if one ends elsewhere and fits
//! about as well, the result is ambiguous.

use nalgebra::{Cholesky, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::gnc::anneal;
use super::state::SearchState;
use crate::estimate::model::{Objective, contact_equations};
use crate::estimate::result::Observer;

/// Whether other starts lead to another minimum that fits about as well; leaves the search as it
/// was.
pub(crate) fn find_competing_minimum(
    search: &mut SearchState<'_>,
    after_coarse: &DVector<f64>,
    observe: Observer<'_>,
) -> bool {
    let options = search.model.problem.options.multi_start;
    let objective = Objective::Residual(search.model.problem.loss);
    let stride = search.stride();
    let contacts = contact_equations(&search.model, &search.theta, (objective, stride), &mut search.caches);
    let scatter = (contacts.squares / contacts.rows.max(f64::MIN_POSITIVE)).sqrt();
    let is_applicable = search.model.has_one_sided_contacts() && !search.model.problem.noise.is_estimated;
    if !is_applicable || scatter < options.min_scatter {
        return false;
    }
    let Some(starts) = starts(search, after_coarse, options.starts) else { return false };
    let found = search.theta.clone();
    let here = search.normal_equations(&found, objective, stride);
    let (termination, resolution) = (search.termination, search.model.noise.resolution);
    let mut competes = false;
    for start in starts {
        search.theta = start;
        anneal(search, observe);
        search.model.noise.resolution = resolution;
        let end = search.theta.clone();
        let cost = search.normal_equations(&end, objective, stride).cost;
        let step = &end - &found;
        let squared_distance = step.dot(&(&here.information * &step)) / stride as f64;
        competes |= squared_distance > options.min_squared_distance && cost < options.max_cost_ratio * here.cost;
        if competes || search.is_interrupted() {
            break;
        }
    }
    if !search.is_interrupted() {
        search.termination = termination;
    }
    search.model.noise.resolution = resolution;
    search.theta = found;
    competes
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
