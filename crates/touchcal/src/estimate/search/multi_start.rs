//! Whether the minimum is the right one, and the only one.
//!
//! Gaps have many minima. From contacts that cover the hole well, every search ends in the same
//! one; from few contacts, or little motion, searches end in different ones, each with small
//! standard deviations. Where contacts scatter more than at a right minimum, or few are
//! informative, the search is repeated from other starts, drawn from the posterior of the coarse
//! stage, and continued from the end with the least cost. Annealing the noise of the likelihood
//! finds the right minimum among rows that are no contacts; annealing the loss of least gaps finds
//! that of pegs at the rim. Both are tried. While contacts scatter too much at the best minimum and
//! only one search ended there, there are more searches, unless the searches took long, or a
//! declaration is most likely grossly wrong. Where the coarse stage contradicts one there are none.
//!
//! If contacts still scatter too much there and another minimum was found, or another one fits
//! about as well, the result is ambiguous.

use nalgebra::{Cholesky, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::annealing::{anneal_loss, anneal_noise};
use super::contact_modes::{fit_contact_modes, uses_contact_modes};
use super::state::{OtherMinimum, SearchState};
use crate::estimate::model::{Objective, contact_equations};
use crate::estimate::result::Observer;
use crate::solver::Termination;

/// Cost of the least gaps at annealed parameters over that of the minimum nearby, above which a
/// search continues from that minimum. With the right minimum the ratio is about 1.2.
const MAX_ANNEALED_COST: f64 = 2.0;

/// Where a search ended.
struct End {
    /// Parameters (SI) from which the search continues: annealed, or those of `minimum` where the
    /// least gaps cost much less.
    theta: DVector<f64>,
    termination: Termination,
    /// Minimum of the least gaps nearby, by which ends are compared. Likelihoods do not compare:
    /// that of a contact at the rim, where no surface is known, is as low as that of no contact.
    minimum: DVector<f64>,
    /// Cost (1) of that minimum: least gaps of the subsample with the problem's loss, and priors.
    cost: f64,
    /// Root mean square of the whitened least gaps (1) there, weighted by the loss.
    scatter: f64,
}

/// Fits the contact modes of a subsample: if the minimum may not be the right one, from the end
/// with the least cost of searches from other starts, unless the problem `has_mistake`: a
/// declaration of the wrong kind. Leaves in `search` the other minima, and whether contacts scatter
/// more than they would at the right parameters.
pub(crate) fn fit_from_starts(
    search: &mut SearchState<'_>,
    after_coarse: &DVector<f64>,
    has_mistake: impl FnOnce(&SearchState<'_>) -> bool,
    observe: Observer<'_>,
) {
    let options = search.model.problem.options.multi_start;
    if !search.model.has_one_sided_contacts() || search.model.problem.noise.is_estimated {
        return fit_contact_modes(search, observe);
    }
    let first = end(search, observe);
    search.has_excess_scatter = scatter(search, &first.theta) >= options.min_scatter;
    let annealed = search.clone();
    if first.scatter < options.min_scatter {
        fit_contact_modes(search, observe);
        if uses_contact_modes(search) || search.is_interrupted() {
            return;
        }
    }
    let iterations = search.termination.iterations;
    *search = annealed;
    search.termination.iterations = iterations;
    if !has_mistake(search) {
        search_from_other_starts(search, first, after_coarse, observe);
    }
    search.has_excess_scatter = scatter(search, &search.theta.clone()) >= options.min_scatter;
    fit_contact_modes(search, observe);
}

/// Searches from other starts, and continues from the end with the least cost, which may be the
/// `first` one.
fn search_from_other_starts(
    search: &mut SearchState<'_>,
    first: End,
    after_coarse: &DVector<f64>,
    observe: Observer<'_>,
) {
    let options = search.model.problem.options.multi_start;
    let [fewer_beyond, none_beyond] = options.max_deviations;
    if first.scatter >= options.min_scatter {
        search.contradiction = contradiction(search, after_coarse, none_beyond);
        if search.contradiction.is_some() {
            return;
        }
    }
    let deviation = after_coarse.component_div(&search.model.layout.scale()).amax();
    let most = options.starts[usize::from(deviation <= fewer_beyond)];
    let Some(starts) = starts(search, after_coarse, most) else { return };
    let mut ends = vec![first];
    let resolution = search.model.noise.resolution;
    let methods = [anneal_loss, anneal_noise];
    let of_both = |start: DVector<f64>| methods.map(|anneal| (start.clone(), anneal));
    let others = std::iter::once((after_coarse.clone(), methods[0])).chain(starts.into_iter().flat_map(of_both));
    let least = 1 + methods.len() * options.starts[0] as usize;
    for (start, anneal) in others {
        let is_long = search.termination.iterations > options.max_iterations_of_more;
        if ends.len() > least && (is_long || is_found(search, &ends)) {
            break;
        }
        search.theta = start;
        anneal(search, observe);
        search.model.noise.resolution = resolution;
        if search.is_interrupted() {
            break;
        }
        ends.push(end(search, observe));
    }
    let best = best(&ends);
    let iterations = search.termination.iterations;
    search.theta = ends[best].theta.clone();
    if !search.is_interrupted() {
        search.termination = Termination { iterations, ..ends[best].termination };
    }
    search.is_from_other_start = best != 0;
    search.other_minima = other_minima(search, &mut ends, best);
}

/// The parameter that deviates most from zero, of those with a prior or of the arm, with its
/// deviation over its scale (1), if that is more than `most`.
fn contradiction(search: &SearchState<'_>, theta: &DVector<f64>, most: f64) -> Option<(usize, f64)> {
    let parameters = &search.model.layout.parameters;
    let is_bounded = |k: usize| parameters[k].prior_sigma().is_some() || !parameters[k].id.block().is_nuisance();
    let deviations = theta.component_div(&search.model.layout.scale()).abs();
    let each = deviations.iter().copied().enumerate().filter(|&(k, _)| is_bounded(k));
    each.filter(|(_, deviation)| *deviation > most).max_by(|(_, one), (_, other)| one.total_cmp(other))
}

/// Index of the end with the least cost.
fn best(ends: &[End]) -> usize {
    (0..ends.len()).fold(0, |best, k| if ends[k].cost < ends[best].cost { k } else { best })
}

/// Whether more searches would hardly find a better minimum: contacts scatter no more at the best
/// one than at the right one, or two searches ended there.
fn is_found(search: &mut SearchState<'_>, ends: &[End]) -> bool {
    let best = best(ends);
    let is_plausible = ends[best].scatter < search.model.problem.options.multi_start.min_scatter;
    let is_apart = apart(search, &ends[best].minimum);
    let others = ends.iter().enumerate().filter(|(k, _)| *k != best);
    is_plausible || others.map(|(_, end)| &end.minimum).any(|minimum| !is_apart(minimum, &ends[best].minimum))
}

/// Whether two minima differ, by the information of least gaps at `theta`.
fn apart(search: &mut SearchState<'_>, theta: &DVector<f64>) -> impl Fn(&DVector<f64>, &DVector<f64>) -> bool + use<> {
    let (objective, stride) = (Objective::Residual(search.model.problem.loss), search.stride());
    let information = search.normal_equations(theta, objective, stride).information / stride as f64;
    let threshold = search.model.problem.options.multi_start.min_squared_distance;
    move |a, b| (a - b).dot(&(&information * (a - b))) > threshold
}

/// The minima of all `ends` that are not the best one's, each once.
fn other_minima(search: &mut SearchState<'_>, ends: &mut [End], best: usize) -> Vec<OtherMinimum> {
    let options = search.model.problem.options.multi_start;
    let (here, cost) = (ends[best].minimum.clone(), ends[best].cost);
    let is_apart = apart(search, &here);
    let is_implausible = ends[best].scatter >= options.min_scatter;
    ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut others: Vec<OtherMinimum> = Vec::new();
    for end in ends {
        let mut known = std::iter::once(&here).chain(others.iter().map(|other| &other.theta));
        if known.all(|minimum| is_apart(&end.minimum, minimum)) {
            let cost_ratio = (end.cost / cost).min(f64::MAX);
            let is_likely = is_implausible || cost_ratio < options.max_cost_ratio;
            others.push(OtherMinimum { theta: end.minimum.clone(), cost_ratio, is_likely });
        }
    }
    others
}

/// The end of a search whose present parameters are annealed. Contacts at the rim have no
/// likelihood: annealing may leave the peg far off the rim there, for instance where the peg sticks
/// above the floor and seems to touch the floor. The search then continues from the minimum of the
/// least gaps nearby, which `search` has afterwards.
fn end(search: &mut SearchState<'_>, observe: Observer<'_>) -> End {
    let (annealed, termination) = (search.theta.clone(), search.termination);
    let (objective, stride) = (Objective::Residual(search.model.problem.loss), search.stride());
    let cost_at = |search: &mut SearchState<'_>, theta: &DVector<f64>| {
        search.normal_equations(theta, objective, stride).cost / stride as f64
    };
    let annealed_cost = cost_at(search, &annealed);
    search.minimize(objective, stride, search.options().anneal, observe);
    let minimum = search.theta.clone();
    let cost = cost_at(search, &minimum);
    let scatter = scatter(search, &minimum);
    let theta = if annealed_cost > MAX_ANNEALED_COST * cost { minimum.clone() } else { annealed };
    search.theta.copy_from(&theta);
    if !search.is_interrupted() {
        search.termination = Termination { iterations: search.termination.iterations, ..termination };
    }
    End { theta, termination, minimum, cost, scatter }
}

/// Root mean square of the whitened least gaps (1) of the subsample at `theta`, weighted by the
/// loss.
fn scatter(search: &mut SearchState<'_>, theta: &DVector<f64>) -> f64 {
    let (objective, stride) = (Objective::Residual(search.model.problem.loss), search.stride());
    let contacts = contact_equations(&search.model, theta, (objective, stride), &mut search.caches);
    (contacts.squares / contacts.rows.max(f64::MIN_POSITIVE)).sqrt()
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
