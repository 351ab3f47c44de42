//! Sums over contacts with latent modes: what expectation–maximisation and the covariance need.

use nalgebra::DVector;

use super::assembly::sum_contacts;
use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use super::stretches::{Stretch, stretches};
use crate::estimate::contact_mode::{ContactCounts, ContactModePrior, MarginalLikelihood};
use crate::manifold::{ContactCache, Residual};
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
    /// Sums of scores (inverse SI units) over blocks of contacts close in the log, one vector a
    /// block.
    pub block_scores: Vec<DVector<f64>>,
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
            stretches: Vec::new(),
            squared_distance: 0.0,
            sigma_sum: 0.0,
            indistinct: 0.0,
            counts: priors.iter().map(|regions| regions.iter().map(counts).collect()).collect(),
        }
    }

    /// Adds the sums over another block of contacts.
    pub fn add_block(&mut self, other: &ContactModeStatistics) {
        self.derivatives.add(&other.derivatives);
        self.score_outer_product.add(&other.score_outer_product);
        self.block_scores.push(other.score_outer_product.gradient.clone());
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
        let one_sided = (0..model.problem.contacts.len()).filter(|&i| model.is_one_sided(i)).count() as f64;
        let in_contact: f64 = self.counts.iter().flatten().map(|counts| counts.contacts().0).sum();
        let share = |of: f64| in_contact / of.max(1.0);
        InformativeShare { of_all: share(one_sided), of_distinct: share(one_sided - self.indistinct) }
    }

    /// Adds the likelihood of a one-sided contact with fixture `f`.
    fn add_likelihood(
        &mut self,
        model: &CalibrationModel<'_>,
        f: usize,
        factor: &ContactFactor,
        (likelihood, candidates): (&MarginalLikelihood, &Residual),
    ) {
        let index = &model.layout.dependencies[f];
        let jacobian = factor.jacobian(index.len());
        let information = match self.curvature {
            Curvature::Complete => &likelihood.complete_information,
            Curvature::Observed => &likelihood.observed_information,
        };
        self.derivatives.add_form(index, jacobian, |r| likelihood.score[r], |r, s| information[(r, s)]);
        self.derivatives.cost += 2.0 * likelihood.nll;
        let (region, surfaces) = model.region(f, candidates);
        if self.curvature == Curvature::Observed {
            self.add_odds(model, (f, region), factor, (likelihood, candidates));
        }
        let of_candidates = candidates.surfaces().iter().map(|surface| surface % surfaces);
        self.counts[f][region].add_contact(likelihood, of_candidates);
        self.squared_distance += likelihood.squared_distance;
        self.sigma_sum += likelihood.sigma_sum;
    }

    /// Adds the outer product of a contact's score, and the derivatives by the odds `ln κⱼ` of its
    /// region.
    fn add_odds(
        &mut self,
        model: &CalibrationModel<'_>,
        (f, region): (usize, usize),
        factor: &ContactFactor,
        (likelihood, candidates): (&MarginalLikelihood, &Residual),
    ) {
        let (index, prior) = (&model.layout.dependencies[f], &model.mode_priors[f][region]);
        let jacobian = factor.jacobian(index.len());
        let first = model.odds_column(f, region);
        let surface = |k: usize| candidates.surfaces()[k] % prior.odds.len();
        let entry = |row: usize, column: usize| jacobian[row * index.len() + column];
        let rows = candidates.len();
        let by_odds = (0..rows).map(|k| (first + surface(k), prior.active_share[surface(k)] - likelihood.active[k]));
        let by_parameters = index
            .iter()
            .enumerate()
            .map(|(column, &k)| (k, (0..rows).map(|row| likelihood.score[row] * entry(row, column)).sum()));
        let score: Vec<(usize, f64)> = by_parameters.chain(by_odds).collect();
        let squares = &mut self.score_outer_product;
        for &(b, right) in &score {
            squares.gradient[b] += right;
            score.iter().filter(|(a, _)| *a <= b).for_each(|&(a, left)| squares.information[(a, b)] += left * right);
        }
        let observed = &mut self.derivatives.information;
        for of in 0..rows {
            let b = first + surface(of);
            for (column, &k) in index.iter().enumerate() {
                let derivative = (0..rows).map(|row| likelihood.score_by_odds[(row, of)] * entry(row, column));
                observed[(k, b)] += derivative.sum::<f64>();
            }
            for other in (0..rows).filter(|&other| first + surface(other) <= b) {
                observed[(first + surface(other), b)] -= likelihood.active_covariance[(other, of)];
            }
        }
    }

    /// Adds the residual of a contact that is not one-sided, with the problem's loss.
    fn add_residual(&mut self, model: &CalibrationModel<'_>, f: usize, factor: &ContactFactor) {
        let (loss, squared) = (model.problem.loss, factor.squared_norm());
        let (weight, weight_slope) = (loss.weight(squared), loss.weight_slope(squared));
        let residual = factor.residual();
        let score = |r: usize| weight * residual[r];
        let complete = |r: usize, s: usize| if r == s { weight } else { 0.0 };
        let index = &model.layout.dependencies[f];
        let jacobian = factor.jacobian(index.len());
        self.derivatives.cost += loss.cost(squared);
        match self.curvature {
            Curvature::Complete => self.derivatives.add_form(index, jacobian, score, complete),
            Curvature::Observed => {
                let observed = |r, s| complete(r, s) + 2.0 * weight_slope * residual[r] * residual[s];
                self.derivatives.add_form(index, jacobian, score, observed);
                self.score_outer_product.add_form(index, jacobian, score, |r, s| score(r) * score(s));
            }
        }
    }
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
    let (_, scratches) = sum_contacts(model, stride, caches, scratch, |batch, caches, (factor, statistics), _| {
        for &i in batch {
            let f = model.problem.contacts.fixture(i);
            if model.is_one_sided(i) {
                factor.evaluate_modes(&point, i, caches.of(i));
                statistics.indistinct += f64::from(u8::from(!factor.is_distinct()));
            } else {
                factor.evaluate(&point, i, Objective::ContactModes);
            }
            match factor.likelihood() {
                Some(likelihood) => statistics.add_likelihood(model, f, factor, likelihood),
                None => statistics.add_residual(model, f, factor),
            }
        }
    });
    let mut total = empty();
    let blocks: Vec<&ContactModeStatistics> = scratches.iter().map(|(_, statistics)| statistics).collect();
    blocks.iter().for_each(|block| total.add_block(block));
    if curvature == Curvature::Observed {
        let sums: Vec<&NormalEquations> = blocks.iter().map(|block| &block.derivatives).collect();
        total.stretches = stretches(&sums, model.problem.contacts.len() / stride / CONTACTS_PER_STRETCH);
    }
    total.scale(stride as f64);
    ContactModeStatistics {
        derivatives: total.derivatives.complete(),
        score_outer_product: total.score_outer_product.complete(),
        ..total
    }
}
