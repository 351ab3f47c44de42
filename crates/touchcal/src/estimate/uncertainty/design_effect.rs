//! Correlation of contact errors, from scores of blocks of contacts.

use nalgebra::{DMatrix, DVector};

use crate::solver::FreeParameters;

/// Directions with less than this share of the largest information are rounding.
const ROUNDING: f64 = 1e-10;

/// Design effect: number of contacts that carry the information of an independent one. It is the
/// variance of scores summed over blocks of contacts close in the log, over what it would be if
/// errors were independent; the mean over all directions, less what may be chance by the blocks'
/// scatter, and at least 1. Deflected parts, or parts that are not of their shape, cause the same
/// errors in many contacts.
///
/// Source: Kish, *Survey sampling* (1965), section 5.4; for estimates Liang & Zeger, *Longitudinal
/// data analysis using generalized linear models* (1986).
pub(crate) fn design_effect(
    score_outer_product: &DMatrix<f64>,
    block_scores: &[DVector<f64>],
    free: &FreeParameters,
) -> f64 {
    let scaled = free.scaled(score_outer_product).symmetric_eigen();
    let weakest = ROUNDING * scaled.eigenvalues.max();
    let pairs = scaled.eigenvalues.iter().zip(scaled.eigenvectors.column_iter());
    let directions: Vec<_> = pairs.filter(|(value, _)| **value > weakest).collect();
    let of_block = |score: &DVector<f64>| {
        let scaled = score.rows(0, free.len()).component_mul(free.scale());
        let squares: f64 = directions.iter().map(|(value, direction)| direction.dot(&scaled).powi(2) / *value).sum();
        squares / directions.len().max(1) as f64
    };
    let blocks: Vec<f64> = block_scores.iter().map(of_block).collect();
    let (count, effect) = (blocks.len() as f64, blocks.iter().sum::<f64>());
    let scatter: f64 = blocks.iter().map(|block| (block - effect / count).powi(2)).sum();
    // Independent normal scores would scatter at least so much.
    let least = 2.0 / (count * directions.len() as f64).max(1.0);
    let chance = (scatter * count / f64::max(count - 1.0, 1.0)).max(least);
    shrunk_variance_factor(effect, chance)
}

/// A factor (≥ 1) of variances that was found to be `found`, where one of 1 would scatter with
/// variance `chance`: an excess over 1 that is small beside its scatter hardly counts, a large one
/// counts whole.
pub(crate) fn shrunk_variance_factor(found: f64, chance: f64) -> f64 {
    let excess = (found - 1.0).max(0.0);
    1.0 + excess.powi(3) / (excess.powi(2) + chance).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;

    /// Of 4096 contacts in blocks of 64, with runs of `run` contacts of the same score.
    fn of_runs(run: usize, seed: u64) -> f64 {
        const PARAMETERS: usize = 6;
        let mut random = Pcg64::seed_from_u64(seed);
        let mut total = DMatrix::zeros(PARAMETERS, PARAMETERS);
        let mut blocks = Vec::new();
        for _ in 0..64 {
            let mut block = DVector::zeros(PARAMETERS);
            for _ in 0..64 / run {
                let score = DVector::from_fn(PARAMETERS, |_, _| StandardNormal.sample(&mut random));
                total += &score * score.transpose() * run as f64;
                block += score * run as f64;
            }
            blocks.push(block);
        }
        design_effect(&total, &blocks, &FreeParameters::new(DVector::repeat(PARAMETERS, 0.1)))
    }

    #[test]
    fn runs_of_equal_scores_count_once() {
        for run in [1, 2, 4, 8] {
            let mean = (0..20).map(|seed| of_runs(run, seed)).sum::<f64>() / 20.0;
            println!("runs of {run}: {mean:.3}");
            assert!((mean / run as f64 - 1.0).abs() < 0.1, "runs of {run}: {mean}");
        }
    }
}
