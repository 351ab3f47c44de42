//! Sums over contacts with latent modes: what expectation–maximisation and the covariance need.

use std::array::from_fn;

use nalgebra::DVector;

use super::assembly::{Batch, CHUNKS, CacheSlice, Selection, sum_contacts};
use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::declared_factors::{add_distances, add_priors};
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use super::stretches::{MAX_STRETCHES, Stretch, stretches};
use crate::estimate::contact_mode::{ContactCounts, ContactModePrior, MarginalLikelihood};
use crate::manifold::{ContactCache, MAX_ROWS};
use crate::solver::NormalEquations;

/// Which second derivatives are summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Curvature {
    /// Those of the complete data (active sets known), as a search needs them: positive
    /// semi-definite.
    Complete,
    /// The observed information, with the outer products of scores, and the `ln κⱼ` of all surfaces
    /// as parameters behind the others: as the covariance needs them.
    Observed,
}

/// Share (0 to 1) of the one-sided contacts that are informative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InformativeShare {
    /// Of all.
    pub of_all: f64,
    /// Of those whose surfaces can be distinguished.
    pub of_distinct: f64,
}

/// Largest number of parts of the log that are summed by themselves, each in matrices over all
/// parameters and odds: a multiple of the number of stretches.
const MAX_PARTS: usize = 2 * MAX_STRETCHES;
/// Least number of contacts in a stretch, whose information is that of a sample.
const CONTACTS_PER_STRETCH: usize = 250;

/// Sums over the contacts at one value of the parameters.
#[derive(Clone, Debug)]
pub(crate) struct ContactModeStatistics {
    curvature: Curvature,
    /// Derivatives of `−ln L`. The first one is that of the parameters only.
    pub derivatives: NormalEquations,
    /// `Σ s sᵀ` of each contact's score `s`: the covariance of their sum. Empty for complete data.
    pub score_outer_product: NormalEquations,
    /// Sums of scores (inverse SI units) over chunks of contacts close in the log, one vector a
    /// chunk.
    pub block_scores: Vec<DVector<f64>>,
    /// Number of the chunk of the last of these.
    last_chunk: usize,
    /// Successive stretches of the log; none for complete data, or where contacts are too few for
    /// two.
    pub stretches: Vec<Stretch>,
    /// Sum of the expected squared Mahalanobis distances (1) of active candidates.
    pub squared_distance: f64,
    /// Sum of the standard deviations (m) of all candidates.
    pub sigma_sum: f64,
    /// Number of one-sided contacts whose surfaces cannot be distinguished.
    pub indistinct: f64,
    /// Expected counts of contacts, for each fixture and each region of its manifold.
    pub counts: Vec<Vec<ContactCounts>>,
}

impl ContactModeStatistics {
    /// Zero sums for so many `parameters` and the surfaces of `priors`.
    pub fn new(parameters: usize, priors: &[Vec<ContactModePrior>], curvature: Curvature) -> Self {
        let surfaces = || priors.iter().flatten().map(|prior| prior.odds.len()).sum::<usize>();
        let (size, score_size) = match curvature {
            Curvature::Complete => (parameters, 0),
            Curvature::Observed => (parameters + surfaces(), parameters + surfaces()),
        };
        let counts = |prior: &ContactModePrior| ContactCounts::new(prior.odds.len());
        ContactModeStatistics {
            curvature,
            derivatives: NormalEquations::new(size),
            score_outer_product: NormalEquations::new(score_size),
            block_scores: Vec::new(),
            last_chunk: 0,
            stretches: Vec::new(),
            squared_distance: 0.0,
            sigma_sum: 0.0,
            indistinct: 0.0,
            counts: priors.iter().map(|regions| regions.iter().map(counts).collect()).collect(),
        }
    }

    /// Adds the sums over another part of the log.
    fn add_part(&mut self, other: &ContactModeStatistics) {
        self.derivatives.add(&other.derivatives);
        self.score_outer_product.add(&other.score_outer_product);
        self.block_scores.extend_from_slice(&other.block_scores);
        self.squared_distance += other.squared_distance;
        self.sigma_sum += other.sigma_sum;
        self.indistinct += other.indistinct;
        for (counts, more) in self.counts.iter_mut().flatten().zip(other.counts.iter().flatten()) {
            counts.add(more);
        }
    }

    /// Multiplies all sums over contacts by `factor`.
    pub fn scale(&mut self, factor: f64) {
        self.derivatives.scale(factor);
        self.score_outer_product.scale(factor);
        self.block_scores.iter_mut().for_each(|score| *score *= factor.sqrt());
        for stretch in &mut self.stretches {
            stretch.score *= factor.sqrt();
            stretch.information *= factor;
        }
        self.squared_distance *= factor;
        self.sigma_sum *= factor;
        self.indistinct *= factor;
        self.counts.iter_mut().flatten().for_each(|counts| counts.scale(factor));
    }

    /// How many one-sided contacts are informative: the expected number of those in contact.
    pub fn informative_share(&self, model: &CalibrationModel<'_>) -> InformativeShare {
        let one_sided = model.one_sided_contacts() as f64;
        let in_contact: f64 = self.counts.iter().flatten().map(|counts| counts.contacts().0).sum();
        let share = |of: f64| in_contact / of.max(1.0);
        InformativeShare { of_all: share(one_sided), of_distinct: share(one_sided - self.indistinct) }
    }

    /// Expected number of active candidates.
    pub fn active(&self) -> f64 {
        self.counts.iter().flatten().flat_map(ContactCounts::active).sum()
    }

    /// Adds contacts of one fixture, evaluated with `factor`.
    fn add_batch(
        &mut self,
        point: &LinearizationPoint<'_>,
        batch: &Batch<'_>,
        caches: &mut CacheSlice<'_>,
        factor: &mut ContactFactor,
    ) {
        let (model, f) = (point.model, point.model.problem.contacts.fixture(batch.indices[0]));
        let index = &model.layout.dependencies[f];
        let mut rows = BatchRows::new(f, index.len());
        if self.curvature == Curvature::Observed && (self.block_scores.is_empty() || self.last_chunk != batch.chunk) {
            self.block_scores.push(DVector::zeros(self.score_outer_product.gradient.len()));
            self.last_chunk = batch.chunk;
        }
        for &i in batch.indices {
            if model.is_one_sided(i) {
                factor.evaluate_modes(point, i, caches.of(i));
                self.indistinct += f64::from(u8::from(!factor.is_distinct()));
            } else {
                factor.evaluate(point, i, Objective::ContactModes);
            }
            match factor.likelihood() {
                Some(likelihood) => {
                    self.add_likelihood(model, factor, likelihood, &mut rows);
                    if self.curvature == Curvature::Observed {
                        let information = &mut self.derivatives.information;
                        factor.visit_load_noise_information(point, i, |entry, product| information[entry] -= product);
                    }
                }
                None => self.add_residual(model, factor, &mut rows),
            }
        }
        if self.curvature == Curvature::Observed {
            self.add_rows(index, &rows);
        }
    }

    /// Adds the derivatives of contacts by the parameters of `index`.
    fn add_rows(&mut self, index: &[usize], rows: &BatchRows) {
        self.derivatives.add_outer_products(index, &rows.jacobian, &rows.weighted);
        self.score_outer_product.add_outer_products(index, &rows.scores, &rows.scores);
        for score in rows.scores() {
            for (&k, score) in index.iter().zip(score) {
                self.derivatives.gradient[k] += score;
                self.add_score(k, *score);
            }
        }
    }

    /// Adds to entry `k` of the sum of all scores, and of that over the present chunk.
    fn add_score(&mut self, k: usize, score: f64) {
        self.score_outer_product.gradient[k] += score;
        if let Some(block) = self.block_scores.last_mut() {
            block[k] += score;
        }
    }

    /// Adds the likelihood of a one-sided contact. Its derivatives by the parameters go to the sums
    /// with complete data, where parameters are few, and to `rows` otherwise.
    fn add_likelihood(
        &mut self,
        model: &CalibrationModel<'_>,
        factor: &ContactFactor,
        likelihood: &MarginalLikelihood,
        rows: &mut BatchRows,
    ) {
        let f = rows.fixture;
        let (score, jacobian) = (|r: usize| likelihood.score[r], factor.jacobian(rows.width));
        match self.curvature {
            Curvature::Complete => {
                let (index, information) = (&model.layout.dependencies[f], &likelihood.complete_information);
                self.derivatives.add_form(index, jacobian, score, |r, s| information[(r, s)]);
                for (&k, of_noise) in index.iter().zip(factor.load_noise_score(rows.width)) {
                    self.derivatives.gradient[k] -= of_noise;
                }
            }
            Curvature::Observed => {
                rows.push(jacobian, score, |r, s| likelihood.observed_information[(r, s)]);
                let of_noise = factor.load_noise_score(rows.width);
                add_scaled(rows.last_score_mut(), of_noise, -1.0);
            }
        }
        self.derivatives.cost += 2.0 * (likelihood.nll - factor.load_noise_cost());
        self.derivatives.rows += likelihood.active.sum();
        let region = factor.region();
        if self.curvature == Curvature::Observed {
            self.add_odds(model, (f, region), (factor, rows), likelihood);
        }
        self.counts[f][region].add_contact(likelihood, factor.odds_indices());
        self.squared_distance += likelihood.squared_distance;
        self.sigma_sum += likelihood.sigma_sum;
    }

    /// Adds the derivatives of a contact, the last of `contacts`, by the odds `ln κⱼ` of its
    /// region, and their products with all of its score.
    fn add_odds(
        &mut self,
        model: &CalibrationModel<'_>,
        (f, region): (usize, usize),
        (factor, contacts): (&ContactFactor, &BatchRows),
        likelihood: &MarginalLikelihood,
    ) {
        let (index, prior) = (&model.layout.dependencies[f], &model.mode_priors[f][region]);
        let jacobian = factor.jacobian(index.len());
        let first = model.odds_column(f, region);
        let odds = factor.odds_indices();
        let entry = |row: usize, column: usize| jacobian[row * index.len() + column];
        let rows = odds.len();
        let by_odds: [f64; MAX_ROWS] =
            from_fn(|k| if k < rows { prior.active_share[odds[k]] - likelihood.active[k] } else { 0.0 });
        for of in 0..rows {
            let (b, right) = (first + odds[of], by_odds[of]);
            self.add_score(b, right);
            let squares = &mut self.score_outer_product.information;
            for (&k, left) in index.iter().zip(contacts.last_score()) {
                squares[(k, b)] += left * right;
            }
            for other in (0..rows).filter(|&other| first + odds[other] <= b) {
                squares[(first + odds[other], b)] += by_odds[other] * right;
            }
        }
        let observed = &mut self.derivatives.information;
        for of in 0..rows {
            let b = first + odds[of];
            for (column, &k) in index.iter().enumerate() {
                let derivative = (0..rows).map(|row| likelihood.score_by_odds[(row, of)] * entry(row, column));
                observed[(k, b)] += derivative.sum::<f64>();
            }
            for other in (0..rows).filter(|&other| first + odds[other] <= b) {
                observed[(first + odds[other], b)] -= likelihood.active_covariance[(other, of)];
            }
        }
    }

    /// Adds the residual of a contact that is not one-sided, with the problem's loss, as
    /// [`add_likelihood`](Self::add_likelihood) does a likelihood.
    fn add_residual(&mut self, model: &CalibrationModel<'_>, factor: &ContactFactor, rows: &mut BatchRows) {
        let (loss, squared) = (model.problem.loss, factor.squared_norm());
        let (weight, weight_slope) = (loss.weight(squared), loss.weight_slope(squared));
        let residual = factor.residual();
        let score = |r: usize| weight * residual[r];
        let complete = |r: usize, s: usize| if r == s { weight } else { 0.0 };
        let jacobian = factor.jacobian(rows.width);
        self.derivatives.cost += loss.cost(squared);
        self.derivatives.rows += weight * residual.len() as f64;
        match self.curvature {
            Curvature::Complete => {
                let index = &model.layout.dependencies[rows.fixture];
                self.derivatives.add_form(index, jacobian, score, complete);
            }
            Curvature::Observed => {
                let observed = |r, s| complete(r, s) + 2.0 * weight_slope * residual[r] * residual[s];
                rows.push(jacobian, score, observed);
            }
        }
    }
}

/// Rows of contacts with one fixture over the parameters that they depend on, row by row: with
/// many parameters products of whole matrices are faster than sums over contacts.
struct BatchRows {
    fixture: usize,
    width: usize,
    /// Derivatives `J` of the rows of all contacts, and `K J` with the curvature `K` of each
    /// contact.
    jacobian: Vec<f64>,
    weighted: Vec<f64>,
    /// Score of each contact.
    scores: Vec<f64>,
}

impl BatchRows {
    fn new(fixture: usize, width: usize) -> Self {
        BatchRows { fixture, width, jacobian: Vec::new(), weighted: Vec::new(), scores: Vec::new() }
    }

    /// Appends a contact with derivatives `jacobian`, row by row; `score(r)` is the derivative of
    /// half its cost by row `r`, `curvature(r, s)` the second one by rows `r` and `s`.
    fn push(&mut self, jacobian: &[f64], score: impl Fn(usize) -> f64, curvature: impl Fn(usize, usize) -> f64) {
        let rows = || jacobian.chunks_exact(self.width.max(1)).enumerate();
        self.jacobian.extend_from_slice(jacobian);
        let (of_score, of_curvature) = (self.scores.len(), self.weighted.len());
        self.scores.resize(of_score + self.width, 0.0);
        self.weighted.resize(of_curvature + jacobian.len(), 0.0);
        for (s, row) in rows() {
            add_scaled(&mut self.scores[of_score..], row, score(s));
            for (r, weighted) in self.weighted[of_curvature..].chunks_exact_mut(self.width.max(1)).enumerate() {
                add_scaled(weighted, row, curvature(r, s));
            }
        }
    }

    /// The score of each contact.
    fn scores(&self) -> impl Iterator<Item = &[f64]> {
        self.scores.chunks_exact(self.width.max(1))
    }

    /// The score of the contact that was appended last.
    fn last_score(&self) -> &[f64] {
        &self.scores[self.scores.len().saturating_sub(self.width)..]
    }

    fn last_score_mut(&mut self) -> &mut [f64] {
        let first = self.scores.len().saturating_sub(self.width);
        &mut self.scores[first..]
    }
}

/// Adds `factor` times `row` to `sum`.
fn add_scaled(sum: &mut [f64], row: &[f64], factor: f64) {
    sum.iter_mut().zip(row).for_each(|(sum, entry)| *sum += factor * entry);
}

/// The sums over every `stride`-th contact at `theta`, weighted to stand for all.
pub(crate) fn contact_mode_statistics(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    (stride, curvature): (usize, Curvature),
    caches: &mut [ContactCache],
) -> ContactModeStatistics {
    let point = LinearizationPoint::new(model, theta);
    let empty = || ContactModeStatistics::new(model.layout.len(), &model.mode_priors, curvature);
    let scratch = || (ContactFactor::new(&point, curvature == Curvature::Observed), empty());
    let max_parts = if curvature == Curvature::Observed { MAX_PARTS } else { CHUNKS };
    let selected = Selection { stride, left_out: &model.gross_rows, max_parts };
    let parts = sum_contacts(model, selected, caches, scratch, |batch, caches, (factor, statistics)| {
        statistics.add_batch(&point, batch, caches, factor);
    });
    let mut total = empty();
    parts.iter().for_each(|(_, part)| total.add_part(part));
    if curvature == Curvature::Observed {
        let sums: Vec<&NormalEquations> = parts.iter().map(|(_, part)| &part.derivatives).collect();
        total.stretches = stretches(&sums, model.problem.contacts.len() / stride / CONTACTS_PER_STRETCH);
    }
    total.scale(stride as f64);
    ContactModeStatistics {
        derivatives: total.derivatives.complete(),
        score_outer_product: total.score_outer_product.complete(),
        ..total
    }
}

/// Normal equations at `theta` of contacts with these `statistics`, known distances and priors,
/// with the observed information of the marginal likelihood by the distances in place of that of
/// complete data. `statistics` may be those of an extended model. Its parameters that follow the
/// model's own, and the odds of contact modes, are held fixed; `squares` is zero.
pub(crate) fn observed_equations(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    statistics: &ContactModeStatistics,
) -> NormalEquations {
    let mut normal = statistics.derivatives.of_first(theta.len());
    add_distances(&LinearizationPoint::new(model, theta), &mut normal);
    add_priors(model, theta, Objective::ContactModes, &mut normal);
    normal.complete()
}
