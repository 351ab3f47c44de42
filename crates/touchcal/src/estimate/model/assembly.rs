//! Sums over contacts: normal equations of an objective at given parameters.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::calibration_model::CalibrationModel;
use super::contact_factor::{ContactFactor, residual_rows};
use super::declared_factors::{add_distances, add_priors};
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use crate::manifold::{ContactCache, Residual};
use crate::se3::Pose;
use crate::solver::{Loss, NormalEquations};

/// Contacts are summed in this many chunks, whatever the number of threads: the result does not
/// depend on it.
const CHUNKS: usize = 64;
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

/// Sums what `add(batch, caches, scratch, sum)` adds for every `stride`-th contact, in parallel
/// chunks of contacts; a batch is of one fixture. `caches` has one for each contact; `scratch()`
/// makes what a chunk works in. The scratches come back in the order of the contacts.
pub(crate) fn sum_contacts<S: Send>(
    model: &CalibrationModel<'_>,
    stride: usize,
    caches: &mut [ContactCache],
    scratch: impl Fn() -> S + Sync,
    add: impl Fn(&[usize], &mut CacheSlice<'_>, &mut S, &mut NormalEquations) + Sync,
) -> (NormalEquations, Vec<S>) {
    let contacts = &model.problem.contacts;
    let count = contacts.len().div_ceil(stride);
    let chunk = count.div_ceil(CHUNKS).max(MIN_CHUNK);
    let chunks = caches.par_chunks_mut(chunk * stride).enumerate().map(|(part, caches)| {
        let mut caches = CacheSlice { first: part * chunk * stride, caches };
        let mut normal = NormalEquations::new(model.layout.len());
        let mut scratch = scratch();
        let indices: Vec<usize> = (part * chunk..((part + 1) * chunk).min(count)).map(|i| i * stride).collect();
        let of_fixture = indices.chunk_by(|&a, &b| contacts.fixture(a) == contacts.fixture(b));
        let batches = of_fixture.flat_map(|indices| indices.chunks(BATCH));
        batches.for_each(|batch| add(batch, &mut caches, &mut scratch, &mut normal));
        (normal, scratch)
    });
    let parts: Vec<(NormalEquations, S)> = chunks.collect();
    let mut total = NormalEquations::new(model.layout.len());
    let mut scratches = Vec::with_capacity(parts.len());
    for (part, scratch) in parts {
        total.add(&part);
        scratches.push(scratch);
    }
    (total, scratches)
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
    let scratch = || ContactFactor::new(&point, false);
    let weight = stride as f64;
    let add = |batch: &[usize], caches: &mut CacheSlice<'_>, factor: &mut ContactFactor, sum: &mut NormalEquations| {
        if objective == Objective::ContactModes && model.is_one_sided(batch[0]) {
            for &i in batch {
                factor.evaluate_modes(&point, i, caches.of(i));
                add_factor(&point, (i, objective), weight, factor, sum);
            }
        } else {
            evaluate_batch(&point, batch, objective, factor, |i, factor| {
                add_factor(&point, (i, objective), weight, factor, sum);
            });
        }
    };
    sum_contacts(model, stride, caches, scratch, add).0
}

/// `Σ JᵀJ` of the whitened residuals of all contacts at `theta`, and each one's squared norm with
/// its number of rows.
pub(crate) fn whitened_norms(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    caches: &mut [ContactCache],
) -> (DMatrix<f64>, Vec<(f64, usize)>) {
    let point = LinearizationPoint::new(model, theta);
    let scratch = || (ContactFactor::new(&point, false), Vec::new());
    let objective = Objective::Residual(Loss::Squared);
    let (normal, scratches) = sum_contacts(model, 1, caches, scratch, |batch, _, (factor, norms), sum| {
        evaluate_batch(&point, batch, objective, factor, |i, factor| {
            add_factor(&point, (i, objective), 1.0, factor, sum);
            norms.push((factor.squared_norm(), factor.residual().len()));
        });
    });
    (normal.complete().information, scratches.into_iter().flat_map(|(_, norms)| norms).collect())
}

/// Evaluates the residuals of contacts with one fixture together, and calls `visit` for each.
fn evaluate_batch(
    point: &LinearizationPoint<'_>,
    batch: &[usize],
    objective: Objective,
    factor: &mut ContactFactor,
    mut visit: impl FnMut(usize, &ContactFactor),
) {
    let Some(&first) = batch.first() else { return };
    let poses: Vec<Pose> = batch.iter().map(|&i| point.pose(i, factor.joint_positions())).collect();
    let mut rows = vec![Residual::new(); batch.len()];
    residual_rows(point, point.model.problem.contacts.fixture(first), &poses, objective, &mut rows);
    for (&i, rows) in batch.iter().zip(rows) {
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
    if let Some((likelihood, _)) = factor.likelihood() {
        let (score, information) = (&likelihood.score, &likelihood.complete_information);
        normal.add_form(index, factor.jacobian(width), |r| share * score[r], |r, s| share * information[(r, s)]);
        normal.cost += 2.0 * share * likelihood.nll;
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
