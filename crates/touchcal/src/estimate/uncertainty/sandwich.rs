//! Covariance of parameters estimated by a marginal likelihood.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::design_effect::design_effect;
use crate::estimate::contact_mode::ContactModePrior;
use crate::estimate::model::ContactModeStatistics;
use crate::solver::FreeParameters;

/// What the scores of contacts say of the uncertainty.
pub(crate) struct Sandwich {
    /// Covariance of the parameters (SI); rows and columns of fixed parameters are zero. `None`
    /// unless the cost is convex in all directions, as it is at a minimum that enough contacts
    /// determine.
    pub covariance: Option<DMatrix<f64>>,
    /// Design effect: number of contacts that carry the information of an independent one (1).
    pub design_effect: f64,
    /// Inverse `(H + Λ)⁻¹` over the parameters and the odds of contact modes, where the cost is
    /// convex.
    bread: Option<DMatrix<f64>>,
}

impl Sandwich {
    /// The covariance with errors of what is uncertain and not estimated, such as shapes: the
    /// motion `−(H + Λ)⁻¹ H e` of the estimates for each error `e` of one standard deviation, over
    /// the parameters (SI).
    ///
    /// Source: the consider covariance of Schmidt, *Application of state-space methods to
    /// navigation problems* (1966).
    pub fn with_errors(mut self, statistics: &ContactModeStatistics, errors: &[DVector<f64>]) -> Self {
        let (Some(bread), Some(covariance)) = (&self.bread, &mut self.covariance) else { return self };
        let (size, parameters) = (bread.nrows(), covariance.nrows());
        for error in errors {
            let error = error.clone().resize_vertically(size, 0.0);
            let motion = bread * (&statistics.derivatives.information * error);
            let motion = motion.rows(0, parameters);
            *covariance += motion * motion.transpose();
        }
        self
    }
}

/// `D (H + Λ)⁻¹ (B + Λ) (H + Λ)⁻¹`, with `H` the observed information, `B` the sum of the outer
/// products of scores, `Λ` the information of what is known besides (`known`), and `D` the [design
/// effect](design_effect()). The odds of contact modes were estimated from the same contacts and
/// count as parameters.
///
/// Source: Huber, *The behavior of maximum likelihood estimates under nonstandard conditions*
/// (1967), theorem 3.
pub(crate) fn sandwich_covariance(
    statistics: &ContactModeStatistics,
    known: &DMatrix<f64>,
    free: &FreeParameters,
    priors: &[Vec<ContactModePrior>],
) -> Sandwich {
    let (parameters, size) = (free.len(), statistics.derivatives.information.nrows());
    let all = free.extended(size);
    let (hessian, squares) = curvature_and_squares(statistics, known, priors, &all);
    let bread = Cholesky::new(all.scaled_regular(&hessian)).map(|_| all.covariance(&hessian));
    let design_effect = design_effect(&statistics.score_outer_product.information, &statistics.block_scores, free);
    let covariance = bread.as_ref().map(|bread| bread * squares * bread * design_effect);
    let covariance = covariance.map(|all| all.view((0, 0), (parameters, parameters)).into_owned());
    Sandwich { covariance, design_effect, bread }
}

/// `H + Λ` and `B + Λ` over the parameters and, behind them, the odds of contact modes; `known` is
/// `Λ` of the parameters, and `free` says which of all are estimated.
pub(crate) fn curvature_and_squares(
    statistics: &ContactModeStatistics,
    known: &DMatrix<f64>,
    priors: &[Vec<ContactModePrior>],
    free: &FreeParameters,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let (parameters, size) = (known.nrows(), statistics.derivatives.information.nrows());
    let odds = size - parameters;
    let mut hessian = statistics.derivatives.information.clone();
    let mut squares = statistics.score_outer_product.information.clone();
    let counts = statistics.counts.iter().flatten().zip(priors.iter().flatten());
    let (of_contacts, before): (Vec<f64>, Vec<f64>) =
        counts.flat_map(|(counts, prior)| counts.complete_information(prior)).unzip();
    let (of_contacts, before) = (DVector::from_vec(of_contacts), DVector::from_vec(before));
    for sum in [&mut hessian, &mut squares] {
        let mut of_parameters = sum.view_mut((0, 0), (parameters, parameters));
        of_parameters += known;
        let mut of_odds = sum.view_mut((parameters, parameters), (odds, odds));
        of_odds += DMatrix::from_diagonal(&before);
    }
    let estimated = FreeParameters::new(free.scale().rows(0, parameters).into_owned());
    let covariance = estimated.covariance(&hessian.view((0, 0), (parameters, parameters)).into_owned());
    let cross = hessian.view((0, parameters), (parameters, odds)).into_owned();
    let of_following = cross.tr_mul(&(covariance * &cross));
    let mut of_odds = hessian.view_mut((parameters, parameters), (odds, odds));
    of_odds += DMatrix::from_diagonal(&of_contacts);
    let profile = bounded_below(&(&of_odds - &of_following), &before);
    of_odds.copy_from(&(profile + of_following));
    (hessian, squares)
}

/// The `information` on the odds of contact modes once the parameters are optimized, with at least
/// what was known `before` in every direction. Contacts that are not informative about which of
/// several surfaces they touch may have a cost that is concave in the odds of these surfaces, but
/// carry no negative information. The scores by these odds stay in the outer products.
fn bounded_below(information: &DMatrix<f64>, before: &DVector<f64>) -> DMatrix<f64> {
    // The decomposition does not terminate on NaN.
    if before.is_empty() || information.iter().any(|entry| !entry.is_finite()) {
        return information.clone();
    }
    let units = before.map(|known| known.sqrt().recip());
    let mut eigen = FreeParameters::new(units.clone()).scaled(information).symmetric_eigen();
    eigen.eigenvalues.apply(|value| *value = value.max(1.0));
    FreeParameters::new(units.map(f64::recip)).scaled(&eigen.recompose())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn information_is_bounded_below_by_what_was_known() {
        let scaled = |matrix: &[f64], units: &DVector<f64>| {
            FreeParameters::new(units.clone()).scaled(&DMatrix::from_row_slice(2, 2, matrix))
        };
        // Eigenvectors (1, 1) and (1, −1) in units of what was known before: contacts add 3 to the
        // one, and take 3 from the other.
        let before = DVector::from_vec(vec![4.0, 25.0]);
        let units = before.map(f64::sqrt);
        let bounded = bounded_below(&scaled(&[1.0, 3.0, 3.0, 1.0], &units), &before);
        let expected = scaled(&[2.5, 1.5, 1.5, 2.5], &units);
        assert!((&bounded - &expected).amax() < 1e-12, "{bounded}");
        assert!((bounded_below(&expected, &before) - expected).amax() < 1e-12);
    }
}
