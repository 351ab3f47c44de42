//! Predictive check of stretches of the log, each from all the others.
//!
//! With a stretch's gradient `g` and the covariance `B` of that by its own contacts, the estimates
//! without the stretch are `(S − B)⁻¹ g` away, where `S = ΣB + Λ` with the information `Λ` of what
//! is known besides. The gradient of the stretch there is `S (S − B)⁻¹ g`, with covariance
//! `B (S − B)⁻¹ S`: that of its own contacts, and that of the estimates from the others. Its
//! squared Mahalanobis norm is `gᵀ (B⁻¹ + (S − B)⁻¹) g = Σ (vₖᵀg)² / (λₖ (1 − λₖ))` with the
//! solutions of `B vₖ = λₖ S vₖ`, `vₖᵀ S vₖ = 1`: chi-squared distributed with a degree of freedom
//! for each direction that both the stretch and the others determine. The gradients of all `n`
//! stretches add up to zero: the sum of their norms scatters as `n − 1` of them do.
//!
//! What is not estimated, but may be off by `z` standard deviations, adds `F z` to the gradient of
//! the stretch and `ΣF z` to that of all: `|(F − λₖ ΣF)ᵀ vₖ|²` is added to `λₖ (1 − λₖ)`.
//!
//! Source: cross-validation of linearized estimates as in Cook & Weisberg, *Residuals and influence
//! in regression* (1982), section 2.2, with stretches in place of single rows.

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::design_effect::shrunk_variance_factor;
use crate::estimate::model::Stretch;
use crate::estimate::result::PredictiveCheck;
use crate::solver::FreeParameters;

/// Least share `λ` (1) of the information on a direction that the stretch must have, and that the
/// others must have: a third of the mean share of one of ten stretches. With a smaller share the
/// few informative contacts of the stretch give too small a covariance `B`.
const MIN_SHARE: f64 = 0.03;

/// Standard deviations of a squared ratio above 1 of which half widens the covariance: without
/// anything missing the mean widening is then about one percent.
const HALF_COUNTED: f64 = 2.0;

/// How far the `stretches` of a log are from what the others predict; `known` is the information
/// (inverse SI units) of priors and distances, and the covariances of all scores are multiplied by
/// the factor `inflation` (1). Stretches have further parameters behind those that are estimated;
/// `errors` are indices and standard deviations (SI) of those that are off. `None` with less than
/// two stretches, or if a number is not finite.
pub(crate) fn predictive_check(
    stretches: &[Stretch],
    known: &DMatrix<f64>,
    free: &FreeParameters,
    inflation: f64,
    errors: &[(usize, f64)],
) -> Option<PredictiveCheck> {
    if stretches.len() < 2 {
        return None;
    }
    let size = free.len();
    let own = |stretch: &Stretch| free.scaled(&stretch.covariance.view((0, 0), (size, size)).into_owned()) * inflation;
    let covariances: Vec<DMatrix<f64>> = stretches.iter().map(own).collect();
    let total = covariances.iter().sum::<DMatrix<f64>>() + free.scaled(known);
    // Decompositions do not terminate on NaN.
    if total.iter().any(|entry| !entry.is_finite()) {
        return None;
    }
    let factor = Cholesky::new(regular(total, free))?.unpack();
    let by_errors = |stretch: &Stretch| {
        let column = |&(k, sigma): &(usize, f64)| stretch.covariance.view((0, k), (size, 1)).column(0) * sigma;
        let columns: Vec<DVector<f64>> = errors.iter().map(|error| column(error).component_mul(free.scale())).collect();
        if columns.is_empty() { DMatrix::zeros(size, 0) } else { DMatrix::from_columns(&columns) }
    };
    let changes: Vec<DMatrix<f64>> =
        stretches.iter().map(|stretch| factor.solve_lower_triangular(&by_errors(stretch))).collect::<Option<_>>()?;
    let all_changes = changes.iter().sum::<DMatrix<f64>>();
    let mut ratios = Vec::with_capacity(stretches.len());
    let (mut statistic, mut degrees_of_freedom) = (0.0, 0);
    for ((stretch, covariance), change) in stretches.iter().zip(&covariances).zip(&changes) {
        let gradient = stretch.score.rows(0, size).component_mul(free.scale());
        let (squared, rank) = squared_norm((covariance, &gradient), &factor, (change, &all_changes))?;
        ratios.push((squared / rank.max(1) as f64).sqrt());
        statistic += squared;
        degrees_of_freedom += rank;
    }
    let share = 1.0 - 1.0 / stretches.len() as f64;
    let independent = share * degrees_of_freedom as f64;
    let distribution = ChiSquared::new(independent).ok()?;
    let (square, p_value) = (statistic / degrees_of_freedom as f64, distribution.sf(share * statistic));
    let widening = shrunk_variance_factor(square, HALF_COUNTED.powi(2) * 2.0 / independent).sqrt();
    let check = PredictiveCheck { ratio: square.sqrt(), p_value, widening, stretches: ratios };
    square.is_finite().then_some(check)
}

/// `matrix` with ones on the diagonal for fixed parameters, so that it can be factored.
fn regular(mut matrix: DMatrix<f64>, free: &FreeParameters) -> DMatrix<f64> {
    (0..free.len()).filter(|&k| !free.is_free(k)).for_each(|k| matrix[(k, k)] = 1.0);
    matrix
}

/// `Σ (vᵀg)² / (λ (1 − λ) + |(F − λ ΣF)ᵀ v|²)` over the directions that both a stretch of covariance
/// `B` and gradient `g` and the others determine, and their number; `factor` is the Cholesky factor
/// `L` of `S`, and `changes` are `L⁻¹F` and `L⁻¹ΣF`.
fn squared_norm(
    (covariance, gradient): (&DMatrix<f64>, &DVector<f64>),
    factor: &DMatrix<f64>,
    (own, all): (&DMatrix<f64>, &DMatrix<f64>),
) -> Option<(f64, usize)> {
    let half = factor.solve_lower_triangular(covariance)?;
    let eigen = factor.solve_lower_triangular(&half.transpose())?.symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(&factor.solve_lower_triangular(gradient)?);
    let (mut sum, mut rank) = (0.0, 0);
    for (k, &share) in eigen.eigenvalues.iter().enumerate() {
        if share > MIN_SHARE && share < 1.0 - MIN_SHARE {
            let direction = eigen.eigenvectors.column(k);
            let by_errors = (own.tr_mul(&direction) - all.tr_mul(&direction) * share).norm_squared();
            sum += along[k] * along[k] / (share * (1.0 - share) + by_errors);
            rank += 1;
        }
    }
    Some((sum, rank))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;

    const PARAMETERS: usize = 4;
    const ROWS: usize = 60;

    /// Regressions with `(columns, observations)` for each stretch, whose parameters are those of
    /// the others but for a change of the first one by `shift` from stretch to stretch.
    fn regression(stretches: usize, shift: f64, seed: u64) -> Vec<(DMatrix<f64>, DVector<f64>)> {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let each = (0..stretches).map(|stretch| {
            let columns = DMatrix::from_fn(ROWS, PARAMETERS, |_, _| normal());
            let noise = DVector::from_fn(ROWS, |_, _| normal());
            let observed = columns.column(0) * (shift * stretch as f64) + noise;
            (columns, observed)
        });
        each.collect()
    }

    fn solve(parts: &[&(DMatrix<f64>, DVector<f64>)]) -> (DVector<f64>, DMatrix<f64>) {
        let information: DMatrix<f64> = parts.iter().map(|(columns, _)| columns.tr_mul(columns)).sum();
        let right: DVector<f64> = parts.iter().map(|(columns, observed)| columns.tr_mul(observed)).sum();
        let inverse = information.try_inverse().expect("full rank");
        (&inverse * right, inverse)
    }

    fn predicted(parts: &[(DMatrix<f64>, DVector<f64>)]) -> PredictiveCheck {
        let (solution, _) = solve(&parts.iter().collect::<Vec<_>>());
        let stretches = parts.iter().map(|(columns, observed)| Stretch {
            score: columns.tr_mul(&(columns * &solution - observed)),
            covariance: columns.tr_mul(columns),
        });
        let free = FreeParameters::new(DVector::repeat(PARAMETERS, 2.0));
        let stretches: Vec<Stretch> = stretches.collect();
        predictive_check(&stretches, &DMatrix::zeros(PARAMETERS, PARAMETERS), &free, 1.0, &[]).expect("a prediction")
    }

    /// Of a linear regression each ratio is that of estimates with and without the stretch: the
    /// estimates from the stretch alone less those from the others, over their covariance.
    #[test]
    fn of_a_linear_regression_it_is_the_distance_of_separate_estimates() {
        let parts = regression(5, 0.2, 7);
        let found = predicted(&parts);
        for (k, ratio) in found.stretches.iter().enumerate() {
            let others: Vec<_> =
                parts.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, part)| part).collect();
            let ((own, own_covariance), (rest, rest_covariance)) = (solve(&[&parts[k]]), solve(&others));
            let apart = own - rest;
            let inverse = (own_covariance + rest_covariance).try_inverse().expect("full rank");
            let expected = (apart.dot(&(inverse * &apart)) / PARAMETERS as f64).sqrt();
            assert!((ratio - expected).abs() < 1e-9 * expected, "{k}: {ratio} {expected}");
        }
    }

    /// Shares of 2 % and of 50 %: only the second counts, 1 over 0.5 (1 − 0.5).
    #[test]
    fn directions_with_little_information_do_not_count() {
        let covariance = DMatrix::from_diagonal(&DVector::from_vec(vec![0.02, 0.5]));
        let found = squared_norm(
            (&covariance, &DVector::from_vec(vec![9.0, 1.0])),
            &DMatrix::identity(2, 2),
            (&DMatrix::zeros(2, 0), &DMatrix::zeros(2, 0)),
        );
        let (sum, directions) = found.expect("finite");
        assert!(directions == 1 && (sum - 4.0).abs() < 1e-12, "{sum} of {directions}");
    }

    /// The share of small p-values is that of chance where stretches agree, and all are small where
    /// they do not.
    #[test]
    fn p_values_are_those_of_chance() {
        let (mut small, mut squares) = (0, 0.0);
        for seed in 0..400 {
            let found = predicted(&regression(5, 0.0, seed));
            small += usize::from(found.p_value < 0.1);
            squares += found.ratio.powi(2) / 400.0;
        }
        // Within four standard deviations: 16 of the 20 numbers of a trial are independent, and 40
        // of 400 p-values are expected.
        assert!((squares - 1.0).abs() < 4.0 * (2.0 / (400.0 * 16.0_f64)).sqrt(), "{squares}");
        assert!((16..=64).contains(&small), "{small}");
        assert!((0..20).all(|seed| predicted(&regression(5, 0.5, seed)).p_value < 1e-9));
    }

    /// Regressions with one more column than is estimated, whose coefficient is drawn once for all
    /// stretches: with its standard deviation stretches agree, without it they do not.
    #[test]
    fn what_is_off_and_not_estimated_counts() {
        const SIGMA: f64 = 1.0;
        const TRIALS: u64 = 400;
        let (mut counted, mut ignored) = (0.0, 0.0);
        for seed in 0..TRIALS {
            let mut random = Pcg64::seed_from_u64(seed);
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let off = SIGMA * normal();
            let parts: Vec<(DMatrix<f64>, DVector<f64>)> = (0..5)
                .map(|_| {
                    let columns = DMatrix::from_fn(ROWS, PARAMETERS + 1, |_, _| normal());
                    let observed = columns.column(PARAMETERS) * off + DVector::from_fn(ROWS, |_, _| normal());
                    (columns, observed)
                })
                .collect();
            let estimated = |columns: &DMatrix<f64>| columns.columns(0, PARAMETERS).into_owned();
            let own: Vec<_> = parts.iter().map(|(columns, observed)| (estimated(columns), observed.clone())).collect();
            let (solution, _) = solve(&own.iter().collect::<Vec<_>>());
            let stretches = parts.iter().map(|(columns, observed)| Stretch {
                score: columns.tr_mul(&(estimated(columns) * &solution - observed)),
                covariance: columns.tr_mul(columns),
            });
            let stretches: Vec<Stretch> = stretches.collect();
            let free = FreeParameters::new(DVector::repeat(PARAMETERS, 2.0));
            let ratio = |errors: &[(usize, f64)]| {
                let known = DMatrix::zeros(PARAMETERS, PARAMETERS);
                predictive_check(&stretches, &known, &free, 1.0, errors).expect("a prediction").ratio
            };
            counted += ratio(&[(PARAMETERS, SIGMA)]).powi(2) / TRIALS as f64;
            ignored += ratio(&[]).powi(2) / TRIALS as f64;
        }
        // Within four standard deviations, the drawn coefficient's included.
        assert!((counted - 1.0).abs() < 4.0 * (4.0 / (TRIALS as f64 * 16.0)).sqrt(), "{counted}");
        assert!(ignored > 1.7, "{ignored}");
    }
}
