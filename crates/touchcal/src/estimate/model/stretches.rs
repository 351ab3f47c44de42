//! Sums over successive stretches of the log, for the predictive check.

use nalgebra::{DMatrix, DVector};

use super::assembly::{CHUNKS, Selection, sum_contacts};
use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use crate::manifold::ContactCache;
use crate::solver::NormalEquations;

/// Largest number of stretches that a log is divided into.
pub(super) const MAX_STRETCHES: usize = 10;
/// Least number of contacts in a stretch of residuals.
const RESIDUALS_PER_STRETCH: usize = 32;

/// Sums over a stretch of the log (inverse SI units), over the parameters first.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// Sum of the contacts' scores.
    pub score: DVector<f64>,
    /// Derivative of that sum by the parameters.
    pub information: DMatrix<f64>,
}

/// Groups the sums over `blocks` of contacts, in their order, into `count` stretches, at most ten
/// and at most as many as blocks; none if that is less than two.
pub(super) fn stretches(blocks: &[&NormalEquations], count: usize) -> Vec<Stretch> {
    let count = count.min(MAX_STRETCHES).min(blocks.len());
    if count < 2 {
        return Vec::new();
    }
    let each = (0..count).map(|k| {
        let mut sum = NormalEquations::new(blocks[0].gradient.len());
        blocks[k * blocks.len() / count..(k + 1) * blocks.len() / count].iter().for_each(|block| sum.add(block));
        let sum = sum.complete();
        Stretch { score: sum.gradient, information: sum.information }
    });
    each.collect()
}

/// The stretches of a log by the residuals at `theta`, of one-sided contacts their least gaps, with
/// the mean of `ψ′` times `Σ JᵀJ` as information; and the covariance of all scores, `Σ JᵀJ` times
/// the mean of `ψ²`, at least that of the declared noise.
pub(crate) fn residual_stretches(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    caches: &mut [ContactCache],
) -> (Vec<Stretch>, DMatrix<f64>) {
    let point = LinearizationPoint::new(model, theta);
    let loss = model.problem.loss;
    let empty = || (ContactFactor::new(&point, false), NormalEquations::new(model.layout.len()), 0.0);
    let selected = Selection { stride: 1, left_out: &model.gross_rows, max_parts: CHUNKS };
    let parts = sum_contacts(model, selected, caches, empty, |batch, _, (factor, sum, slope)| {
        for &i in batch.indices {
            factor.evaluate(&point, i, Objective::Residual(loss));
            let index = &model.layout.dependencies[model.problem.contacts.fixture(i)];
            let (residual, squared) = (factor.residual(), factor.squared_norm());
            let weight = loss.weight(squared);
            let unit = |r: usize, s: usize| f64::from(u8::from(r == s));
            sum.add_form(index, factor.jacobian(index.len()), |r| weight * residual[r], unit);
            sum.squares += weight * weight * squared;
            sum.rows += residual.len() as f64;
            *slope += residual.len() as f64 * weight + 2.0 * squared * loss.weight_slope(squared);
        }
    });
    let blocks: Vec<&NormalEquations> = parts.iter().map(|(_, sum, _)| sum).collect();
    let rows = blocks.iter().map(|block| block.rows).sum::<f64>().max(1.0);
    let slope = parts.iter().map(|(_, _, slope)| slope).sum::<f64>() / rows;
    let contacts = model.problem.contacts.len();
    let of_declared = loss.gaussian_variance((rows / contacts.max(1) as f64).round() as usize) * slope * slope;
    let variance = (blocks.iter().map(|block| block.squares).sum::<f64>() / rows).max(of_declared);
    let mut stretches = stretches(&blocks, contacts / RESIDUALS_PER_STRETCH);
    let size = model.layout.len();
    let sum = stretches.iter().fold(DMatrix::zeros(size, size), |sum, stretch| sum + &stretch.information);
    stretches.iter_mut().for_each(|stretch| stretch.information *= slope);
    (stretches, sum * variance)
}
