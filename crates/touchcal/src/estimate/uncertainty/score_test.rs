//! Score (Lagrange multiplier) tests of effects that the model leaves out.
//!
//! `g` and `H` are the gradient and the second derivative of the cost `−ln L + ½ priors` by
//! estimated parameters P and left-out ones S, at the minimum over P with S at zero. Then
//!
//! - `W = [−H_PP⁻¹ H_PS; 1]` is how the estimated parameters follow the left-out ones,
//! - `g_e = Wᵀ g` is the gradient by S with P following, `H_e = Wᵀ H_{·S}` its information,
//! - `V = D Wᵀ (B + Λ) W + Σ Wᵀ (H e) (H e)ᵀ W` is its covariance, with the outer product `B` of
//!   scores, the information `Λ` of priors, the design effect `D` of contacts whose errors are
//!   correlated, and errors `e` of one standard deviation of the shapes,
//! - `g_eᵀ V⁻¹ g_e` is chi-squared distributed if S is zero, and `−H_e⁻¹ g_e` estimates S.
//!
//! Directions of S that contacts do not see at a plausible size are left out.
//!
//! Source: Rao, *Large sample tests of statistical hypotheses concerning several parameters with
//! applications to problems of estimation* (1948); with this covariance White, *Maximum likelihood
//! estimation of misspecified models* (1982), theorem 3.5.

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::design_effect::design_effect;
use crate::solver::FreeParameters;

/// Least information (1) on a direction at its plausible size from which it is tested: the effect
/// then stands out of the noise by one standard deviation.
const MIN_INFORMATION: f64 = 1.0;

/// Information (1) on a direction at its plausible size from which a test shows an effect of that
/// size with a probability of 95 %: `(4.83 + 1.645)²`, for a corrected p-value below 1e-5 of seven
/// tests with one degree of freedom.
const SURE_INFORMATION: f64 = 42.0;

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
    /// The change `H e` of the gradient by each error of the shapes, of one standard deviation.
    pub shape_scores: Vec<DVector<f64>>,
}

/// The outcome of a test.
pub(crate) struct ScoreTest {
    /// `g_eᵀ V⁻¹ g_e` (1), and the number of directions tested.
    pub statistic: f64,
    pub degrees_of_freedom: usize,
    /// Probability of a statistic as large by chance.
    pub p_value: f64,
    /// Estimates of all parameters' changes (SI) if the effect is let in: those of S, and of P with
    /// them.
    pub change: DVector<f64>,
    /// Standard deviation (SI) of each estimate of S, in their order.
    pub sigma: Vec<f64>,
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
    let seen: Vec<usize> = (0..omitted.len()).filter(|&k| all.information[k] > MIN_INFORMATION).collect();
    let directions = all.of_sizes.select_columns(&seen);
    let eigenvalues = DVector::from_iterator(seen.len(), seen.iter().map(|&k| all.information[k]));
    let along = all.following.select_columns(&seen);
    let gradient = along.tr_mul(&at.gradient);
    let squares = along.tr_mul(&(&at.squares * &along));
    let mean = &gradient / at.block_scores.len().max(1) as f64;
    let blocks: Vec<DVector<f64>> =
        at.block_scores.iter().map(|score| along.rows(0, score.len()).tr_mul(score) - &mean).collect();
    // Decompositions do not terminate on NaN.
    if seen.is_empty() || !squares.iter().chain(blocks.iter().flatten()).all(|entry| entry.is_finite()) {
        return None;
    }
    let unit = FreeParameters::new(DVector::repeat(seen.len(), 1.0));
    let effect = design_effect(&squares, &blocks, &unit);
    let of_shapes = at.shape_scores.iter().map(|score| along.tr_mul(score));
    let of_shapes =
        of_shapes.fold(DMatrix::zeros(seen.len(), seen.len()), |sum, shift| sum + &shift * shift.transpose());
    let factor = Cholesky::new(squares * effect + of_shapes)?;
    let statistic = gradient.dot(&factor.solve(&gradient));
    let p_value = ChiSquared::new(seen.len() as f64).map_or(1.0, |distribution| distribution.sf(statistic));
    let step = -gradient.component_div(&eigenvalues);
    let covariance = DMatrix::from_diagonal(&eigenvalues.map(f64::recip)) * factor.l();
    let of_sizes = &directions * covariance;
    let sigma: Vec<f64> = (0..omitted.len()).map(|k| sizes[k] * of_sizes.row(k).norm()).collect();
    let change = &along * step;
    let is_finite = change.iter().chain(&sigma).chain([&statistic]).all(|entry| entry.is_finite());
    let degrees_of_freedom = seen.len();
    is_finite.then_some(ScoreTest { statistic, degrees_of_freedom, p_value, change, sigma })
}

/// Changes of all parameters (SI) by one standard deviation of left-out ones, in the directions
/// that contacts need not show at the plausible sizes, independent of each other: with a Gaussian
/// prior of these sizes, and what contacts say of the direction. Arguments are those of
/// [`score_test`]; none if a number is not finite.
pub(crate) fn unseen_changes(
    at: &Derivatives,
    inverse: &DMatrix<f64>,
    omitted: (&[usize], &[f64]),
) -> Vec<DVector<f64>> {
    let Some(all) = Directions::new(at, inverse, omitted) else { return Vec::new() };
    let unseen = (0..all.information.len()).filter(|&k| all.information[k] < SURE_INFORMATION);
    let changes = unseen.map(|k| {
        let change = all.following.column(k);
        let information = 1.0 + all.information[k].max(0.0);
        let mean = change.dot(&at.gradient) / information;
        change * (information.recip() + mean * mean).sqrt()
    });
    changes.filter(|change| change.iter().all(|entry| entry.is_finite())).collect()
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
            shape_scores: Vec::new(),
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
            shape_scores: vec![DVector::from_vec(vec![2.0])],
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
            shape_scores: Vec::new(),
        };
        let inverse = DMatrix::from_row_slice(2, 2, &[0.2, 0.0, 0.0, 0.0]);
        let changes = unseen_changes(&at, &inverse, (&[1], &[1.0]));
        let sigma = (1.0 / 4.2 + (1.6f64 / 4.2).powi(2)).sqrt();
        let [change] = changes.as_slice() else { panic!("{changes:?}") };
        assert!((change.abs() - DVector::from_vec(vec![0.4 * sigma, sigma])).amax() < 1e-12, "{change}");
        // Contacts would show one ten times as large.
        assert!(unseen_changes(&at, &inverse, (&[1], &[10.0])).is_empty());
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
            shape_scores: Vec::new(),
        };
        let free = FreeParameters::new(DVector::from_vec(vec![1.0, 1.0, 0.0]));
        let inverse = free.covariance(&at.curvature);
        assert!(score_test(&at, &inverse, (&[], &[])).is_none());
        assert!(score_test(&at, &inverse, (&[2], &[1e-3])).is_none());
        assert!(score_test(&at, &inverse, (&[2], &[1.0])).is_some());
    }
}
