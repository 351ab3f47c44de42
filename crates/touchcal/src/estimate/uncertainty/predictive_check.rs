//! Predictive check of stretches of the log, each from all the others.
//!
//! With the scores `εₖ` of the stretches at the true parameters, that of what is known besides,
//! the information `Hₖ` of each stretch and `Λ` of what is known, and `S = ΣH + Λ`, a stretch has
//! at the minimum the gradient `gₖ = εₖ − Hₖ S⁻¹ (Σε + ε₀)`: its own score, and the motion of the
//! estimates by all scores. Along a solution `v` of `Hₖ v = λ S v`, `vᵀ S v = 1`, with `ℓ = vᵀΛv`
//! and the factor `f = vᵀBv / (1 − ℓ)` of the covariance `B` of all stretches' scores over their
//! information, `gₖ` has the variance
//!
//! `f λ (1 − λ − λ ℓ) + λ² ℓ`,
//!
//! which is `λ (1 − λ)` where the covariance is the information. The sum of the squares over these
//! variances is chi-squared distributed with a degree of freedom for each direction that both the
//! stretch and the others determine. The gradients of all `n` stretches add up to zero: the sum of
//! their norms scatters as `n − 1` of them do.
//!
//! What is not estimated, but may be off by `z` standard deviations, adds `F z` to the gradient of
//! the stretch and `ΣF z` to that of all: `|(F − λ ΣF)ᵀ v|²` is added to the variance.
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
/// others must have: a third of the mean share of one of ten stretches. A smaller share comes from
/// few contacts, and is itself uncertain.
const MIN_SHARE: f64 = 0.03;

/// Standard deviations of a squared ratio above 1 of which half counts.
const HALF_COUNTED: f64 = 1.5;

/// Probability (0 to 1) of the variance found, if errors are independent, at which half of what
/// counts widens the covariance.
const SIGNIFICANT: f64 = 1e-3;

/// How far the `stretches` of a log are from what the others predict. `covariance` is that of the
/// sum of all scores if errors are independent, and `design_effect` by how much it is larger;
/// `known` is the information of priors and distances (inverse SI units). Stretches and
/// `covariance` have further parameters behind those that are estimated; `errors` are indices and
/// standard deviations (SI) of those that are off. `None` with less than two stretches, or if a
/// number is not finite.
///
/// An excess widens the covariance as far as it is not chance. Where blocks of contacts already
/// show that errors are correlated, it is not, however small.
pub(crate) fn predictive_check(
    stretches: &[Stretch],
    (covariance, design_effect): (&DMatrix<f64>, f64),
    known: &DMatrix<f64>,
    free: &FreeParameters,
    errors: &[(usize, f64)],
) -> Option<PredictiveCheck> {
    if stretches.len() < 2 {
        return None;
    }
    let scaled: Vec<ScaledStretch> =
        stretches.iter().map(|stretch| ScaledStretch::new(stretch, free, errors)).collect();
    let all = Total {
        information: scaled.iter().map(|stretch| &stretch.information).sum::<DMatrix<f64>>() + free.scaled(known),
        covariance: own(covariance, free) * design_effect,
        known: free.scaled(known),
        changes: scaled.iter().map(|stretch| &stretch.changes).sum(),
    };
    // Decompositions do not terminate on NaN.
    if all.information.iter().any(|entry| !entry.is_finite()) {
        return None;
    }
    let factor = Cholesky::new(regular(all.information.clone(), free))?.unpack();
    let mut ratios = Vec::with_capacity(stretches.len());
    let (mut statistic, mut degrees_of_freedom) = (0.0, 0);
    for stretch in &scaled {
        let (squared, rank) = squared_norm(stretch, &all, &factor)?;
        ratios.push((squared / rank.max(1) as f64).sqrt());
        statistic += squared;
        degrees_of_freedom += rank;
    }
    let share = 1.0 - 1.0 / stretches.len() as f64;
    let independent = share * degrees_of_freedom as f64;
    let distribution = ChiSquared::new(independent).ok()?;
    let (square, p_value) = (statistic / degrees_of_freedom as f64, distribution.sf(share * statistic));
    let excess = shrunk_variance_factor(square, HALF_COUNTED.powi(2) * 2.0 / independent) - 1.0;
    let of_independent = distribution.sf(share * statistic * design_effect);
    let widening = (1.0 + excess * SIGNIFICANT / (SIGNIFICANT + of_independent)).sqrt();
    let check = PredictiveCheck { ratio: square.sqrt(), p_value, widening, stretches: ratios };
    square.is_finite().then_some(check)
}

/// Sums over a stretch, over the estimated parameters in units of their scales.
struct ScaledStretch {
    gradient: DVector<f64>,
    information: DMatrix<f64>,
    /// Change `F` of the gradient by each error of one standard deviation, a column each.
    changes: DMatrix<f64>,
}

impl ScaledStretch {
    fn new(stretch: &Stretch, free: &FreeParameters, errors: &[(usize, f64)]) -> Self {
        let size = free.len();
        let mut changes = DMatrix::zeros(size, errors.len());
        for (mut column, &(k, sigma)) in changes.column_iter_mut().zip(errors) {
            let by_error = stretch.information.view((0, k), (size, 1)) * sigma;
            column.copy_from(&by_error.component_mul(free.scale()));
        }
        let gradient = stretch.score.rows(0, size).component_mul(free.scale());
        ScaledStretch { gradient, information: own(&stretch.information, free), changes }
    }
}

/// Sums over all stretches, and what is known besides, in the same units.
struct Total {
    /// `S`, with `known`.
    information: DMatrix<f64>,
    covariance: DMatrix<f64>,
    known: DMatrix<f64>,
    changes: DMatrix<f64>,
}

/// The part of `matrix` over the estimated parameters, in units of their scales.
fn own(matrix: &DMatrix<f64>, free: &FreeParameters) -> DMatrix<f64> {
    free.scaled(&matrix.view((0, 0), (free.len(), free.len())).into_owned())
}

/// `matrix` with ones on the diagonal for fixed parameters, so that it can be factored.
fn regular(mut matrix: DMatrix<f64>, free: &FreeParameters) -> DMatrix<f64> {
    (0..free.len()).filter(|&k| !free.is_free(k)).for_each(|k| matrix[(k, k)] = 1.0);
    matrix
}

/// Sum of the squares of a stretch's gradient over their expected values, along the directions that
/// both the stretch and the others determine, and the number of these; `factor` is the Cholesky
/// factor `L` of `S`.
fn squared_norm(stretch: &ScaledStretch, all: &Total, factor: &DMatrix<f64>) -> Option<(f64, usize)> {
    let half = factor.solve_lower_triangular(&stretch.information)?;
    let eigen = factor.solve_lower_triangular(&half.transpose())?.symmetric_eigen();
    let directions = factor.tr_solve_lower_triangular(&eigen.eigenvectors)?;
    let (mut sum, mut rank) = (0.0, 0);
    for (direction, &share) in directions.column_iter().zip(&eigen.eigenvalues) {
        let known = direction.dot(&(&all.known * direction));
        let seen = 1.0 - known;
        if share > MIN_SHARE && share < seen - MIN_SHARE {
            let scatter = direction.dot(&(&all.covariance * direction)) / seen;
            let by_errors =
                (stretch.changes.tr_mul(&direction) - all.changes.tr_mul(&direction) * share).norm_squared();
            let variance = scatter * share * (1.0 - share - share * known) + share * share * known + by_errors;
            sum += stretch.gradient.dot(&direction).powi(2) / variance;
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

    fn checked(stretches: &[Stretch], covariance: DMatrix<f64>, errors: &[(usize, f64)]) -> PredictiveCheck {
        let free = FreeParameters::new(DVector::repeat(PARAMETERS, 2.0));
        let known = DMatrix::zeros(PARAMETERS, PARAMETERS);
        predictive_check(stretches, (&covariance, 1.0), &known, &free, errors).expect("a prediction")
    }

    fn predicted(parts: &[(DMatrix<f64>, DVector<f64>)]) -> PredictiveCheck {
        let (solution, _) = solve(&parts.iter().collect::<Vec<_>>());
        let stretches = parts.iter().map(|(columns, observed)| Stretch {
            score: columns.tr_mul(&(columns * &solution - observed)),
            information: columns.tr_mul(columns),
        });
        checked(&stretches.collect::<Vec<_>>(), parts.iter().map(|(columns, _)| columns.tr_mul(columns)).sum(), &[])
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
        let stretch = ScaledStretch {
            gradient: DVector::from_vec(vec![9.0, 1.0]),
            information: DMatrix::from_diagonal(&DVector::from_vec(vec![0.02, 0.5])),
            changes: DMatrix::zeros(2, 0),
        };
        let identity = DMatrix::identity(2, 2);
        let all = Total {
            information: identity.clone(),
            covariance: identity.clone(),
            known: DMatrix::zeros(2, 2),
            changes: DMatrix::zeros(2, 0),
        };
        let (sum, directions) = squared_norm(&stretch, &all, &identity).expect("finite");
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

    /// An excess that chance makes widens by less than a percent; the same ratios count where the
    /// covariance has a design effect already.
    #[test]
    fn chance_does_not_widen() {
        let free = FreeParameters::new(DVector::repeat(PARAMETERS, 2.0));
        let known = DMatrix::zeros(PARAMETERS, PARAMETERS);
        let (mut of_independent, mut of_correlated) = (0.0, 0.0);
        for seed in 0..400 {
            let parts = regression(5, 0.0, seed);
            let (solution, _) = solve(&parts.iter().collect::<Vec<_>>());
            let stretches = parts.iter().map(|(columns, observed)| Stretch {
                score: columns.tr_mul(&(columns * &solution - observed)),
                information: columns.tr_mul(columns),
            });
            let stretches: Vec<Stretch> = stretches.collect();
            let covariance: DMatrix<f64> = parts.iter().map(|(columns, _)| columns.tr_mul(columns)).sum();
            let widening = |design_effect: f64| {
                let covariance = &covariance / design_effect;
                let found = predictive_check(&stretches, (&covariance, design_effect), &known, &free, &[]);
                found.expect("a prediction").widening.powi(2) / 400.0
            };
            of_independent += widening(1.0);
            of_correlated += widening(10.0);
        }
        assert!(of_independent < 1.02 && of_correlated > 1.05, "{of_independent} {of_correlated}");
    }

    /// Regressions by least squares with weights that have nothing to do with the noise, and a
    /// prior from which the parameters are drawn: the covariance of the scores is not their
    /// information.
    #[test]
    fn information_need_not_be_the_covariance() {
        const TRIALS: u64 = 400;
        const PRIOR: f64 = 100.0;
        let weights = DVector::from_fn(ROWS, |row, _| if row % 3 == 0 { 4.0 } else { 0.5 });
        let weighted = |columns: &DMatrix<f64>, of: &DVector<f64>| columns.tr_mul(&DMatrix::from_diagonal(of));
        let (mut squares, mut small) = (0.0, 0);
        for seed in 0..TRIALS {
            let mut random = Pcg64::seed_from_u64(TRIALS + seed);
            let truth = DVector::from_fn(PARAMETERS, |_, _| {
                let drawn: f64 = StandardNormal.sample(&mut random);
                drawn / PRIOR.sqrt()
            });
            let parts = regression(5, 0.0, seed);
            let parts: Vec<_> =
                parts.into_iter().map(|(columns, noise)| (columns.clone(), columns * &truth + noise)).collect();
            let known = DMatrix::identity(PARAMETERS, PARAMETERS) * PRIOR;
            let sum = |of: &dyn Fn(&DMatrix<f64>) -> DMatrix<f64>| -> DMatrix<f64> {
                parts.iter().map(|(columns, _)| of(columns)).sum()
            };
            let information = |columns: &DMatrix<f64>| weighted(columns, &weights) * columns;
            let covariance = sum(&|columns| weighted(columns, &weights.component_mul(&weights)) * columns);
            let right: DVector<f64> =
                parts.iter().map(|(columns, observed)| weighted(columns, &weights) * observed).sum();
            let solution = (sum(&information) + &known).try_inverse().expect("full rank") * right;
            let stretches = parts.iter().map(|(columns, observed)| Stretch {
                score: weighted(columns, &weights) * (columns * &solution - observed),
                information: information(columns),
            });
            let free = FreeParameters::new(DVector::repeat(PARAMETERS, 2.0));
            let stretches: Vec<Stretch> = stretches.collect();
            let found = predictive_check(&stretches, (&covariance, 1.0), &known, &free, &[]).expect("a prediction");
            squares += found.ratio.powi(2) / TRIALS as f64;
            small += usize::from(found.p_value < 0.1);
        }
        // Within four standard deviations, as above.
        assert!((squares - 1.0).abs() < 4.0 * (2.0 / (TRIALS as f64 * 16.0)).sqrt(), "{squares}");
        assert!((16..=64).contains(&small), "{small}");
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
                information: columns.tr_mul(columns),
            });
            let stretches: Vec<Stretch> = stretches.collect();
            let covariance: DMatrix<f64> = parts.iter().map(|(columns, _)| columns.tr_mul(columns)).sum();
            let ratio = |errors: &[(usize, f64)]| checked(&stretches, covariance.clone(), errors).ratio;
            counted += ratio(&[(PARAMETERS, SIGMA)]).powi(2) / TRIALS as f64;
            ignored += ratio(&[]).powi(2) / TRIALS as f64;
        }
        // Within four standard deviations, the drawn coefficient's included.
        assert!((counted - 1.0).abs() < 4.0 * (4.0 / (TRIALS as f64 * 16.0)).sqrt(), "{counted}");
        assert!(ignored > 1.7, "{ignored}");
    }
}
