//! Sums over contacts: normal equations of an objective at given parameters.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::declared_factors::{add_distances, add_priors};
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use super::residual_rows::residual_rows;
use crate::manifold::{ContactCache, Residual};
use crate::se3::Pose;
use crate::solver::{Loss, NormalEquations};

/// Contacts are summed in this many chunks, whatever the number of threads: the result does not
/// depend on it.
pub(super) const CHUNKS: usize = 64;
/// Smallest number of contacts in a chunk: a chunk then takes longer than its administration.
const MIN_CHUNK: usize = 64;
/// Largest number of contacts whose residuals are evaluated together: the batch of a network.
const BATCH: usize = 128;

/// The manifolds' caches of a run of contacts.
pub(crate) struct CacheSlice<'c> {
    first: usize,
    caches: &'c mut [ContactCache],
}

impl CacheSlice<'_> {
    /// The cache of contact `i`.
    pub fn of(&mut self, i: usize) -> &mut ContactCache {
        &mut self.caches[i - self.first]
    }
}

/// One empty cache for each contact.
pub(crate) fn contact_caches(model: &CalibrationModel<'_>) -> Vec<ContactCache> {
    vec![ContactCache::default(); model.problem.contacts.len()]
}

/// A number of contacts of one fixture that are evaluated together.
pub(crate) struct Batch<'b> {
    /// Number of its chunk, from 0.
    pub chunk: usize,
    /// Indices of the contacts.
    pub indices: &'b [usize],
}

/// Which contacts are summed, and in how many parts.
pub(crate) struct Selection<'s> {
    /// Difference of the indices of successive contacts.
    pub stride: usize,
    /// Indices of contacts that are left out, ascending.
    pub left_out: &'s [usize],
    /// Most runs of chunks that are summed in parallel.
    pub max_parts: usize,
}

/// Sums what `add(batch, caches, sum)` adds for the contacts `selected`, in chunks of contacts.
/// `caches` has one for each contact; runs of chunks are summed in parallel, each in what `empty()`
/// makes, and come back in the order of the contacts.
pub(crate) fn sum_contacts<S: Send>(
    model: &CalibrationModel<'_>,
    selected: Selection<'_>,
    mut caches: &mut [ContactCache],
    empty: impl Fn() -> S + Sync,
    add: impl Fn(&Batch<'_>, &mut CacheSlice<'_>, &mut S) + Sync,
) -> Vec<S> {
    let contacts = &model.problem.contacts;
    let Selection { stride, left_out, max_parts } = selected;
    let count = contacts.len().div_ceil(stride);
    let length = count.div_ceil(CHUNKS).max(MIN_CHUNK);
    let chunks = count.div_ceil(length);
    let parts = chunks.min(max_parts);
    let mut of_parts = Vec::with_capacity(parts);
    for part in 0..parts {
        let chunks = part * chunks / parts..(part + 1) * chunks / parts;
        let first = chunks.start * length * stride;
        let (own, others) = caches.split_at_mut((chunks.len() * length * stride).min(caches.len()));
        caches = others;
        of_parts.push((chunks, CacheSlice { first, caches: own }));
    }
    let sum = |(chunks, mut caches): (Range<usize>, CacheSlice<'_>)| {
        let mut sum = empty();
        for chunk in chunks {
            let indices = (chunk * length..((chunk + 1) * length).min(count)).map(|i| i * stride);
            let indices: Vec<usize> = indices.filter(|i| left_out.binary_search(i).is_err()).collect();
            let of_fixture = indices.chunk_by(|&a, &b| contacts.fixture(a) == contacts.fixture(b));
            let batches = of_fixture.flat_map(|indices| indices.chunks(BATCH));
            batches.for_each(|indices| add(&Batch { chunk, indices }, &mut caches, &mut sum));
        }
        sum
    };
    of_parts.into_par_iter().map(sum).collect()
}

/// Normal equations at `theta` of every `stride`-th contact (weighted to stand for all), known
/// distances and priors.
pub(crate) fn normal_equations(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    (objective, stride): (Objective, usize),
    caches: &mut [ContactCache],
) -> NormalEquations {
    let mut total = contact_equations(model, theta, (objective, stride), caches);
    match objective {
        Objective::Residual(_) | Objective::ContactModes => {
            add_distances(&LinearizationPoint::new(model, theta), &mut total);
        }
        Objective::Envelope => {
            let effective = model.problem.options.search.coarse_effective_contacts;
            total.scale(effective / model.problem.contacts.len().max(1) as f64);
        }
    }
    add_priors(model, theta, objective, &mut total);
    total.complete()
}

/// Normal equations of the contacts alone, upper triangle.
pub(crate) fn contact_equations(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    (objective, stride): (Objective, usize),
    caches: &mut [ContactCache],
) -> NormalEquations {
    let point = LinearizationPoint::new(model, theta);
    let empty = || (ContactFactor::new(&point, false), NormalEquations::new(model.layout.len()));
    let weight = stride as f64;
    let selected = Selection { stride, left_out: &model.gross_rows, max_parts: CHUNKS };
    let parts = sum_contacts(model, selected, caches, empty, |batch, caches, (factor, sum)| {
        if objective == Objective::ContactModes && model.is_one_sided(batch.indices[0]) {
            for &i in batch.indices {
                factor.evaluate_modes(&point, i, caches.of(i));
                add_factor(&point, (i, objective), weight, factor, sum);
            }
        } else {
            evaluate_batch(&point, batch, objective, factor, |i, factor| {
                add_factor(&point, (i, objective), weight, factor, sum);
            });
        }
    });
    total(model, parts.iter().map(|(_, sum)| sum))
}

/// The sum of the normal equations of all `parts`.
fn total<'s>(model: &CalibrationModel<'_>, parts: impl Iterator<Item = &'s NormalEquations>) -> NormalEquations {
    let mut total = NormalEquations::new(model.layout.len());
    parts.for_each(|part| total.add(part));
    total
}

/// `Σ JᵀJ` of the whitened residuals of all contacts at `theta`, and for each contact the squared
/// norm of its residual and its number of rows.
pub(crate) fn whitened_norms(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    caches: &mut [ContactCache],
) -> (DMatrix<f64>, Vec<f64>, Vec<u8>) {
    let point = LinearizationPoint::new(model, theta);
    let empty =
        || (ContactFactor::new(&point, false), NormalEquations::new(model.layout.len()), Vec::new(), Vec::new());
    let objective = Objective::Residual(Loss::Squared);
    let selected = Selection { stride: 1, left_out: &[], max_parts: CHUNKS };
    let parts = sum_contacts(model, selected, caches, empty, |batch, _, (factor, sum, norms, rows)| {
        evaluate_batch(&point, batch, objective, factor, |i, factor| {
            add_factor(&point, (i, objective), 1.0, factor, sum);
            norms.push(factor.squared_norm());
            rows.push(factor.residual().len() as u8);
        });
    });
    let information = total(model, parts.iter().map(|(_, sum, ..)| sum)).complete().information;
    let count = model.problem.contacts.len();
    let (mut all_norms, mut all_rows) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (_, _, norms, rows) in parts {
        all_norms.extend(norms);
        all_rows.extend(rows);
    }
    (information, all_norms, all_rows)
}

/// Evaluates the residuals of contacts with one fixture together, and calls `visit` for each.
fn evaluate_batch(
    point: &LinearizationPoint<'_>,
    Batch { indices, .. }: &Batch<'_>,
    objective: Objective,
    factor: &mut ContactFactor,
    mut visit: impl FnMut(usize, &ContactFactor),
) {
    let Some(&first) = indices.first() else { return };
    let poses: Vec<Pose> = indices.iter().map(|&i| point.pose(i, factor.joint_positions())).collect();
    let mut rows = vec![Residual::new(); indices.len()];
    residual_rows(point, point.model.problem.contacts.fixture(first), &poses, objective, &mut rows);
    for (&i, rows) in indices.iter().zip(rows) {
        factor.evaluate_rows(point, i, objective, rows);
        visit(i, factor);
    }
}

/// Adds the factor of contact `i`, evaluated for `objective`, `share` times.
fn add_factor(
    point: &LinearizationPoint<'_>,
    (i, objective): (usize, Objective),
    share: f64,
    factor: &ContactFactor,
    normal: &mut NormalEquations,
) {
    let problem = point.model.problem;
    let index = &point.model.layout.dependencies[problem.contacts.fixture(i)];
    let width = index.len();
    if let Some(likelihood) = factor.likelihood() {
        let (score, information) = (&likelihood.score, &likelihood.complete_information);
        normal.add_form(index, factor.jacobian(width), |r| share * score[r], |r, s| share * information[(r, s)]);
        for (&k, of_noise) in index.iter().zip(factor.load_noise_score(width)) {
            normal.gradient[k] -= share * of_noise;
        }
        normal.cost += 2.0 * share * (likelihood.nll - factor.load_noise_cost());
        normal.squares += share * likelihood.squared_distance;
        normal.rows += share * likelihood.active.sum();
        return;
    }
    let loss = match objective {
        Objective::Envelope => Loss::Squared,
        Objective::Residual(loss) => loss,
        Objective::ContactModes => problem.loss,
    };
    let squared = factor.squared_norm();
    let weight = share * loss.weight(squared);
    for (residual, row) in factor.residual().iter().zip(factor.jacobian(width).chunks_exact(width.max(1))) {
        normal.add_row(index, row, *residual, weight);
    }
    normal.cost += share * loss.cost(squared);
    normal.squares += weight * squared;
    normal.rows += weight * factor.residual().len() as f64;
}
