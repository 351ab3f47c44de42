//! Score (Lagrange multiplier) tests of effects that the model leaves out.
//!
//! `g` and `H` are the gradient and the second derivative of the cost `−ln L + ½ priors` by
//! estimated parameters P and left-out ones S, at the minimum over P with S at zero. Then
//!
//! - `W = [−H_PP⁻¹ H_PS; 1]` is how the estimated parameters follow the left-out ones,
//! - `g_e = Wᵀ g` is the gradient by S with P following, `H_e = Wᵀ H_{·S}` its information,
//! - `V = D Wᵀ (B + Λ) W + Σ Wᵀ (H e) (H e)ᵀ W` is its covariance, with the outer product `B` of
//!   scores, the information `Λ` of priors, the design effect `D` of contacts whose errors are
//!   correlated, and errors `e` of one standard deviation of what is uncertain and not estimated:
//!   shapes, and what random walks have beyond the estimated cosines,
//! - `g_eᵀ V⁻¹ g_e` is chi-squared distributed if S is zero, and `−H_e⁻¹ g_e` estimates S.
//!
//! Directions of S that contacts do not see at a plausible size are left out.
//!
//! Source: Rao, *Large sample tests of statistical hypotheses concerning several parameters with
//! applications to problems of estimation* (1948); with this covariance White, *Maximum likelihood
//! estimation of misspecified models* (1982), theorem 3.5.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::design_effect::design_effect;
use crate::solver::FreeParameters;

/// Least information (1) on a direction at its plausible size from which it is tested: the effect
/// then stands out of the noise by one standard deviation.
const MIN_INFORMATION: f64 = 1.0;

/// Noncentrality (1) at the plausible size from which a test of one direction shows an effect with
/// a probability of 95 %: `(4.83 + 1.645)²`, for a corrected p-value below 1e-5 of seven tests.
/// Tests of several directions need more, up to about twice as much.
const SURE_NONCENTRALITY: f64 = 42.0;

/// Derivatives at the minimum, over parameters estimated and left out, and the odds of contact
/// modes.
pub(crate) struct Derivatives {
    /// Gradient `g`, with that of the priors of what is estimated (inverse SI units).
    pub gradient: DVector<f64>,
    /// `H + Λ` and `B + Λ`.
    pub curvature: DMatrix<f64>,
    pub squares: DMatrix<f64>,
    /// Scores summed over blocks of contacts close in the log.
    pub block_scores: Vec<DVector<f64>>,
    /// The change `H e` of the gradient by each error of what is uncertain and not estimated, such
    /// as shapes, of one standard deviation.
    pub error_scores: Vec<DVector<f64>>,
}

/// The outcome of a test.
pub(crate) struct ScoreTest {
    /// `g_eᵀ V⁻¹ g_e` (1), or as [`ScoreTest::allowing_for`] has it, and the number of directions
    /// tested.
    pub statistic: f64,
    pub degrees_of_freedom: usize,
    /// Probability of a statistic as large by chance.
    pub p_value: f64,
    /// Estimates of all parameters' changes (SI) if the effect is estimated: those of S, and of P
    /// with them.
    pub change: DVector<f64>,
    /// Standard deviation (SI) of each estimate of S, in their order.
    pub sigma: Vec<f64>,
}

impl ScoreTest {
    /// This test of one parameter, of index `k`, that may be off by the standard deviation `sigma`
    /// (SI) although the effect is zero.
    pub fn allowing_for(self, k: usize, sigma: f64) -> ScoreTest {
        let sigma = self.sigma[0].hypot(sigma).max(f64::MIN_POSITIVE);
        let statistic = (self.change[k] / sigma).powi(2);
        let p_value = ChiSquared::new(1.0).map_or(1.0, |distribution| distribution.sf(statistic));
        ScoreTest { statistic, p_value, sigma: vec![sigma], ..self }
    }
}

/// Tests the left-out parameters of indices `omitted` with plausible sizes `sizes` (SI), a number
/// each; `inverse` is that of the curvature of the estimated ones, zero elsewhere. `None` if there
/// are none, contacts see none of them at that size, or a number is not finite.
pub(crate) fn score_test(
    at: &Derivatives,
    inverse: &DMatrix<f64>,
    (omitted, sizes): (&[usize], &[f64]),
) -> Option<ScoreTest> {
    if omitted.is_empty() {
        return None;
    }
    let all = Directions::new(at, inverse, (omitted, sizes))?;
    let tested: Vec<usize> = (0..omitted.len()).filter(|&k| all.information[k] > MIN_INFORMATION).collect();
    let directions = all.of_sizes.select_columns(&tested);
    let eigenvalues = DVector::from_iterator(tested.len(), tested.iter().map(|&k| all.information[k]));
    let along = all.following.select_columns(&tested);
    let gradient = along.tr_mul(&at.gradient);
    let factor = Cholesky::new(at.gradient_covariance(&along)?)?;
    let statistic = gradient.dot(&factor.solve(&gradient));
    let p_value = ChiSquared::new(tested.len() as f64).map_or(1.0, |distribution| distribution.sf(statistic));
    let step = -gradient.component_div(&eigenvalues);
    let covariance = DMatrix::from_diagonal(&eigenvalues.map(f64::recip)) * factor.l();
    let of_sizes = &directions * covariance;
    let sigma: Vec<f64> = (0..omitted.len()).map(|k| sizes[k] * of_sizes.row(k).norm()).collect();
    let change = &along * step;
    let is_finite = change.iter().chain(&sigma).chain([&statistic]).all(|entry| entry.is_finite());
    let degrees_of_freedom = tested.len();
    is_finite.then_some(ScoreTest { statistic, degrees_of_freedom, p_value, change, sigma })
}

impl Derivatives {
    /// Covariance `V` of the gradient along directions, the columns of `along` (SI). `None` if
    /// there are none, or a number is not finite.
    fn gradient_covariance(&self, along: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let gradient = along.tr_mul(&self.gradient);
        let squares = along.tr_mul(&(&self.squares * along));
        let mean = &gradient / self.block_scores.len().max(1) as f64;
        let blocks: Vec<DVector<f64>> =
            self.block_scores.iter().map(|score| along.rows(0, score.len()).tr_mul(score) - &mean).collect();
        // Decompositions do not terminate on NaN.
        if along.is_empty() || !squares.iter().chain(blocks.iter().flatten()).all(|entry| entry.is_finite()) {
            return None;
        }
        let unit = FreeParameters::new(DVector::repeat(along.ncols(), 1.0));
        let effect = design_effect(&squares, &blocks, &unit);
        let of_errors = self.error_scores.iter().map(|score| along.tr_mul(score));
        Some(of_errors.fold(squares * effect, |sum, shift| sum + &shift * shift.transpose()))
    }
}

/// Changes of all parameters (SI) by what left-out ones may be in the directions that a test would
/// miss at the plausible sizes. The left-out parameters have a Gaussian prior of these sizes; the
/// sum of the changes' outer products is the second moment about zero, given the contacts, of what
/// they change. Arguments are those of [`score_test`]; none if a number is not finite.
///
/// With information `λ` on a direction and variance `V` of its gradient `g`, one standard deviation
/// of the prior has the noncentrality `λ²/V` in the test, and given the contacts the variance
/// `1/(1 + λ²/V)` and the mean `−(λ/V) g / (1 + λ²/V)`.
pub(crate) fn unseen_changes(
    at: &Derivatives,
    inverse: &DMatrix<f64>,
    omitted: (&[usize], &[f64]),
) -> Vec<DVector<f64>> {
    let Some(all) = Directions::new(at, inverse, omitted) else { return Vec::new() };
    let mut changes = Vec::new();
    let mut mean = DVector::zeros(at.gradient.len());
    for k in 0..all.information.len() {
        let along = all.following.column(k);
        let Some(variance) = at.gradient_covariance(&along.into_owned().reshape_generic(Dyn(along.len()), Dyn(1)))
        else {
            continue;
        };
        let information = all.information[k].max(0.0);
        // Errors of contacts are not smaller than their information says.
        let share = information / variance[(0, 0)].max(information).max(f64::MIN_POSITIVE);
        let noncentrality = share * information;
        if noncentrality < SURE_NONCENTRALITY {
            mean -= along * (share * along.dot(&at.gradient) / (1.0 + noncentrality));
            changes.push(along / (1.0 + noncentrality).sqrt());
        }
    }
    changes.push(mean);
    changes.retain(|change| change.iter().all(|entry| entry.is_finite()));
    changes
}

/// Directions of left-out parameters that are independent of each other by the contacts.
struct Directions {
    /// Each as a column: the left-out parameters in their plausible sizes (1).
    of_sizes: DMatrix<f64>,
    /// Information (1) on each.
    information: DVector<f64>,
    /// Change of all parameters (SI) along each: the estimated ones follow.
    following: DMatrix<f64>,
}

impl Directions {
    /// `None` if a number is not finite.
    fn new(at: &Derivatives, inverse: &DMatrix<f64>, (omitted, sizes): (&[usize], &[f64])) -> Option<Self> {
        let of_omitted = at.curvature.select_columns(omitted);
        let mut following = -(inverse * &of_omitted);
        for (column, &k) in omitted.iter().enumerate() {
            following[(k, column)] = 1.0;
        }
        let scale = |matrix: &mut DMatrix<f64>| {
            matrix.column_iter_mut().zip(sizes).for_each(|(mut entries, size)| entries *= *size);
        };
        scale(&mut following);
        let mut information = following.tr_mul(&of_omitted);
        scale(&mut information);
        if information.iter().any(|entry| !entry.is_finite()) {
            return None;
        }
        let eigen = ((&information + information.transpose()) * 0.5).symmetric_eigen();
        let following = following * &eigen.eigenvectors;
        Some(Directions { of_sizes: eigen.eigenvectors, information: eigen.eigenvalues, following })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of a regression with three parameters, and observations.
    fn regression() -> (DMatrix<f64>, DVector<f64>) {
        const ROWS: usize = 200;
        let at = |row: usize, column: usize| ((row * (3 + 2 * column)) as f64 * 0.37 + column as f64).sin();
        let columns = DMatrix::from_fn(ROWS, 3, at);
        let noise = DVector::from_fn(ROWS, |row, _| at(row, 7));
        let observed = &columns * DVector::from_vec(vec![1.0, -2.0, 0.3]) + noise;
        (columns, observed)
    }

    /// Of a linear regression: the statistic is the decrease of the squares by letting the third
    /// parameter in, and the step leads to the regression on all three.
    #[test]
    fn of_a_linear_regression_it_is_the_decrease_of_the_squares() {
        let (columns, observed) = regression();
        let squares = |used: usize| {
            let part = columns.columns(0, used).into_owned();
            let solution = part.clone().svd(true, true).solve(&observed, 1e-12).expect("full rank");
            ((&observed - &part * &solution).norm_squared(), solution)
        };
        let (before, restricted) = squares(2);
        let (after, full) = squares(3);
        let information = columns.tr_mul(&columns);
        let at = restricted.clone().resize_vertically(3, 0.0);
        let derivatives = Derivatives {
            gradient: columns.tr_mul(&(&columns * &at - &observed)),
            curvature: information.clone(),
            squares: information,
            block_scores: Vec::new(),
            error_scores: Vec::new(),
        };
        let free = FreeParameters::new(DVector::from_vec(vec![1.0, 1.0, 0.0]));
        let inverse = free.covariance(&derivatives.curvature);
        let test = score_test(&derivatives, &inverse, (&[2], &[1.0])).expect("a test");
        assert!((test.statistic - (before - after)).abs() < 1e-9 * test.statistic, "{}", test.statistic);
        assert_eq!(test.degrees_of_freedom, 1);
        assert!((at + test.change - full).amax() < 1e-12);
        let expected = 2.0 * (1.0 - 0.5 * libm::erfc(-test.statistic.sqrt() / 2f64.sqrt()));
        assert!((test.p_value - expected).abs() < 1e-9, "{} {expected}", test.p_value);
    }

    /// Of a direction with gradient 3 and information 4, and an error of the shapes that changes
    /// the gradient by 2: 9 over 4 + 4.
    #[test]
    fn errors_of_shapes_add_to_the_covariance_of_the_gradient() {
        let at = Derivatives {
            gradient: DVector::from_vec(vec![3.0]),
            curvature: DMatrix::from_element(1, 1, 4.0),
            squares: DMatrix::from_element(1, 1, 4.0),
            block_scores: Vec::new(),
            error_scores: vec![DVector::from_vec(vec![2.0])],
        };
        let test = score_test(&at, &DMatrix::zeros(1, 1), (&[0], &[1.0])).expect("a test");
        assert!((test.statistic - 9.0 / 8.0).abs() < 1e-12, "{}", test.statistic);
        assert!((test.change[0] + 0.75).abs() < 1e-12 && (test.sigma[0] - 8f64.sqrt() / 4.0).abs() < 1e-12);
    }

    /// One estimated parameter of information 5, one left out that changes it by −2/5, of
    /// information 4 − 4/5 and gradient 1.6: its second moment at size 1 is 1/4.2 + (1.6/4.2)².
    #[test]
    fn what_contacts_need_not_show_has_its_second_moment() {
        let at = Derivatives {
            gradient: DVector::from_vec(vec![0.0, 1.6]),
            curvature: DMatrix::from_row_slice(2, 2, &[5.0, 2.0, 2.0, 4.0]),
            squares: DMatrix::from_row_slice(2, 2, &[5.0, 2.0, 2.0, 4.0]),
            block_scores: Vec::new(),
            error_scores: Vec::new(),
        };
        let inverse = DMatrix::from_row_slice(2, 2, &[0.2, 0.0, 0.0, 0.0]);
        let moment = |at: &Derivatives, size: f64| -> DMatrix<f64> {
            unseen_changes(at, &inverse, (&[1], &[size])).iter().map(|change| change * change.transpose()).sum()
        };
        let expected = |variance: f64| {
            let change = DVector::from_vec(vec![-0.4, 1.0]);
            &change * change.transpose() * variance
        };
        let found = moment(&at, 1.0);
        assert!((&found - expected(1.0 / 4.2 + (1.6f64 / 4.2).powi(2))).amax() < 1e-12, "{found}");
        // An error of the shapes that doubles the variance of the gradient.
        let shapes = Derivatives { error_scores: vec![DVector::from_vec(vec![0.0, 3.2f64.sqrt()])], ..at };
        let found = moment(&shapes, 1.0);
        assert!((&found - expected(1.0 / 2.6 + (0.8f64 / 2.6).powi(2))).amax() < 1e-12, "{found}");
        // Contacts would show one ten times as large, where shapes are exact.
        let exact = Derivatives { error_scores: Vec::new(), ..shapes };
        assert!(moment(&exact, 10.0).amax() == 0.0);
    }

    #[test]
    fn what_is_not_seen_at_its_plausible_size_is_not_tested() {
        let (columns, _) = regression();
        let information = columns.tr_mul(&columns);
        let gradient = DVector::zeros(3);
        let at = Derivatives {
            gradient,
            curvature: information.clone(),
            squares: information,
            block_scores: Vec::new(),
            error_scores: Vec::new(),
        };
        let free = FreeParameters::new(DVector::from_vec(vec![1.0, 1.0, 0.0]));
        let inverse = free.covariance(&at.curvature);
        assert!(score_test(&at, &inverse, (&[], &[])).is_none());
        assert!(score_test(&at, &inverse, (&[2], &[1e-3])).is_none());
        assert!(score_test(&at, &inverse, (&[2], &[1.0])).is_some());
    }
}
