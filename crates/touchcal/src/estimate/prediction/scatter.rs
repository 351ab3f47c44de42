//! The scatter of contacts predicted from noise and from uncertain parameters.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::least_gap::least;
use super::prediction_model::PredictionModel;
use crate::estimate::contact_mode::CandidateMatrix;
use crate::estimate::model::{ContactFactor, LinearizationPoint};
use crate::estimate::result::{Scatter, Spread};
use crate::manifold::{ContactCache, ResidualKind};
use crate::solver::NormalEquations;

/// Rows of a residual that make a contact's distance.
const DISTANCE_ROWS: usize = 3;
/// Contacts of a fixture are summed in this many chunks at most, whatever the number of threads,
/// and in chunks of this many at least.
const CHUNKS: usize = 32;
const MIN_CHUNK: usize = 64;
/// Relative error of the expected square of the least of several gaps, common to all contacts: in
/// simulated logs of pegs its root was up to 2.5 % off.
const LEAST_GAP_ERROR: f64 = 0.05;
/// A surface within this many standard deviations of contact counts as touched.
const TOUCHED: f64 = 2.0;
/// Share of what chance makes that is beyond either end of [`Scatter::by_chance`] of any test.
pub(super) const TAIL: f64 = 0.5e-3;

/// Sums over contacts that determine the distribution of their squared distances, see the module's
/// description.
pub(super) struct SquaredDistances {
    contacts: f64,
    rows: f64,
    /// Expectation (m²) and variance (m⁴) of the sum by noise alone.
    noise: [f64; 2],
    /// `M` (m² per squared unit of a parameter), and as its gradient `Σ Jᵀ m` with the mean
    /// residuals `m`.
    sensitivity: NormalEquations,
}

impl SquaredDistances {
    pub fn new(parameters: usize) -> Self {
        SquaredDistances { contacts: 0.0, rows: 0.0, noise: [0.0; 2], sensitivity: NormalEquations::new(parameters) }
    }

    pub fn add(&mut self, other: &SquaredDistances) {
        self.contacts += other.contacts;
        self.rows += other.rows;
        (0..2).for_each(|k| self.noise[k] += other.noise[k]);
        self.sensitivity.add(&other.sensitivity);
    }

    /// The scatter found in `spread`, beside that of parameters with this covariance (SI); chance
    /// is one of `tests`. `None` without contacts.
    pub fn scatter(self, spread: &Spread, covariance: &DMatrix<f64>, tests: usize) -> Option<Scatter> {
        let NormalEquations { information, gradient, .. } = self.sensitivity.complete();
        let product = covariance * information;
        let by_parameters = product.trace();
        let mean = self.noise[0] + by_parameters;
        let of_row = self.noise[0] / self.rows.max(1.0);
        let variance = self.noise[1]
            + 4.0 * of_row * by_parameters
            + 2.0 * product.component_mul(&product.transpose()).sum()
            + 4.0 * gradient.dot(&(covariance * &gradient));
        let degrees_of_freedom = 2.0 * mean * mean / variance;
        let chance = ChiSquared::new(degrees_of_freedom).ok()?;
        let bound = |quantile: f64| (chance.inverse_cdf(quantile) / degrees_of_freedom).sqrt();
        let tail = TAIL / tests.max(1) as f64;
        (self.contacts > 0.0).then(|| Scatter {
            found: spread.rms,
            predicted: (mean / self.contacts).sqrt(),
            by_chance: [bound(tail), bound(1.0 - tail)],
        })
    }
}

/// Sums over all contacts with fixture `f`; `None` if their distances cannot be predicted.
pub(super) fn squared_distances(prediction: &PredictionModel<'_>, f: usize) -> Option<SquaredDistances> {
    let (model, contacts) = (&prediction.model, &prediction.model.problem.contacts);
    let kind = model.problem.fixtures[f].manifold.residual_kind();
    if matches!(kind, ResidualKind::ProjectionError | ResidualKind::Unmodeled) || !prediction.is_bounded[f] {
        return None;
    }
    let point = LinearizationPoint::new(model, &prediction.theta);
    let of_fixture: Vec<usize> = (0..contacts.len()).filter(|&i| contacts.fixture(i) == f).collect();
    let chunk = of_fixture.len().div_ceil(CHUNKS).max(MIN_CHUNK);
    let parts: Vec<FixtureSums> = of_fixture
        .par_chunks(chunk)
        .map(|chunk| {
            let mut sums = FixtureSums::new(&point, f);
            let mut factor = ContactFactor::new(&point, false);
            chunk.iter().for_each(|&i| sums.add_contact(&point, i, &mut factor));
            sums
        })
        .collect();
    let mut total = FixtureSums::new(&point, f);
    parts.iter().for_each(|part| total.add(part));
    Some(match kind {
        ResidualKind::PointOffset => total.about_mean(),
        ResidualKind::LeastGap => total.of_least_gaps(),
        _ => total.sums,
    })
}

/// Sums over contacts with one fixture.
struct FixtureSums {
    sums: SquaredDistances,
    /// Parameters that the contacts depend on.
    dependencies: Vec<usize>,
    /// Sums of the derivatives of each row by them.
    row_sums: [DVector<f64>; DISTANCE_ROWS],
    is_one_sided: bool,
}

impl FixtureSums {
    fn new(point: &LinearizationPoint<'_>, f: usize) -> Self {
        let dependencies = point.model.layout.dependencies[f].clone();
        FixtureSums {
            sums: SquaredDistances::new(point.model.layout.len()),
            row_sums: std::array::from_fn(|_| DVector::zeros(dependencies.len())),
            dependencies,
            is_one_sided: point.model.problem.fixtures[f].manifold.residual_kind() == ResidualKind::LeastGap,
        }
    }

    fn add(&mut self, other: &FixtureSums) {
        self.sums.add(&other.sums);
        self.row_sums.iter_mut().zip(&other.row_sums).for_each(|(sum, more)| *sum += more);
    }

    fn add_contact(&mut self, point: &LinearizationPoint<'_>, i: usize, factor: &mut ContactFactor) {
        let least_gap = self.is_one_sided.then(|| least_gap(point, i, factor)).flatten();
        let noise = factor.evaluate_with_noise(point, i);
        let width = self.dependencies.len();
        let rows = factor.residual().len().min(DISTANCE_ROWS);
        // By noise alone two-sided residuals are zero on average, the gap that was measured is the
        // gap bias, and the least of several gaps is less.
        let bias = factor.gaps().first().zip(factor.residual().first()).map_or(0.0, |(gap, distance)| gap - distance);
        let (mean, noise) = match least_gap {
            Some((mean, variance)) => (mean, CandidateMatrix::from_diagonal_element(variance)),
            None => (if self.is_one_sided { bias } else { 0.0 }, noise),
        };
        self.sums.contacts += 1.0;
        self.sums.rows += rows as f64;
        self.sums.noise[0] += mean * mean;
        self.sums.noise[1] += 4.0 * mean * mean * noise[(0, 0)];
        for (r, row) in factor.jacobian(width).chunks_exact(width.max(1)).take(rows).enumerate() {
            self.sums.noise[0] += noise[(r, r)];
            self.sums.noise[1] += 2.0 * (0..rows).map(|s| noise[(r, s)].powi(2)).sum::<f64>();
            self.sums.sensitivity.add_row(&self.dependencies, row, mean, 1.0);
            self.row_sums[r].iter_mut().zip(row).for_each(|(sum, entry)| *sum += entry);
        }
    }

    /// The sums of residuals less their mean.
    fn about_mean(mut self) -> SquaredDistances {
        let share = 1.0 / self.sums.contacts.max(1.0);
        for row in &self.row_sums {
            self.sums.sensitivity.add_row(&self.dependencies, row.as_slice(), 0.0, -share);
        }
        self.sums.noise = self.sums.noise.map(|sum| (1.0 - share) * sum);
        self.sums
    }

    /// The sums of least gaps, with what their prediction is off by.
    fn of_least_gaps(mut self) -> SquaredDistances {
        self.sums.noise[1] += (LEAST_GAP_ERROR * self.sums.noise[0]).powi(2);
        self.sums
    }
}

/// Mean and variance, by noise alone, of the gap that was least in contact `i`: gaps of surfaces
/// that are touched, as the nearest is, are their gap biases. `None` without candidates.
fn least_gap(point: &LinearizationPoint<'_>, i: usize, factor: &mut ContactFactor) -> Option<(f64, f64)> {
    let candidates = factor.evaluate_candidates(point, i, &mut ContactCache::default());
    let distances = factor.residual();
    let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
    let means = factor.gaps().iter().zip(distances).enumerate().map(|(r, (gap, &distance))| {
        let is_near = distance < TOUCHED * candidates.covariance[(r, r)].sqrt();
        if is_near || distance == nearest { gap - distance } else { *gap }
    });
    let means: Vec<f64> = means.collect();
    (!means.is_empty()).then(|| least(&means, &candidates.covariance))
}
