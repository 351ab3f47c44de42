//! What changed between two calibrations of one arm.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::result::ParameterPosterior;

/// Directions whose change is known at least this much better than the two estimates, in standard
/// deviations, are left out of the test: both estimates are the prior's there.
const LEAST_SHARE: f64 = 1e-2;

/// A parameter in two calibrations.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterChange {
    /// Name, such as `joint_offset.joint_a1`.
    pub name: String,
    /// Estimates (SI) of the first and the second calibration.
    pub values: [f64; 2],
    /// Standard deviation (SI) of the difference of both estimates if the parameter is the same; 0
    /// where both are fixed or the prior's.
    pub sigma: f64,
}

impl ParameterChange {
    /// The difference over its standard deviation; `None` where that is 0.
    pub fn deviations(&self) -> Option<f64> {
        (self.sigma > 0.0).then(|| (self.values[1] - self.values[0]) / self.sigma)
    }
}

/// What changed between two calibrations.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The parameters that both have, in the order of the first.
    pub parameters: Vec<ParameterChange>,
    /// Squared length of the differences in units of their covariance.
    pub statistic: f64,
    /// Number of directions in which contacts of either calibration determine the differences.
    pub degrees_of_freedom: usize,
    /// Probability that the statistic is at least this large if nothing changed; `None` without
    /// such a direction.
    pub p_value: Option<f64>,
}

/// Compares those parameters of two calibrations for which `is_compared` holds (by name), and tests
/// whether they are the same ones.
///
/// The contacts of both are taken for independent, and what is not compared (fixtures, as a rule)
/// for another in each: where it is the same one, differences are smaller than their covariance
/// says. The errors of both estimates are correlated
/// nevertheless, because both are drawn to the same prior: with posterior covariances `C` and prior
/// information `Λ` the covariance of the difference is `Cₐ + C_b − CₐΛC_b − C_bΛCₐ`. Where the two
/// priors differ, as variance components do, `Λ` is their geometric mean.
pub fn compare(
    first: &ParameterPosterior,
    second: &ParameterPosterior,
    is_compared: impl Fn(&str) -> bool,
) -> Comparison {
    let named = first.entries.iter().enumerate().filter(|(_, entry)| is_compared(&entry.name));
    let common: Vec<[usize; 2]> = named.filter_map(|(i, entry)| Some([i, second.index(&entry.name)?])).collect();
    let sides = [first, second];
    let covariance = |side: usize| {
        let of = |i: usize| common[i][side];
        DMatrix::from_fn(common.len(), common.len(), |i, k| sides[side].covariance[(of(i), of(k))])
    };
    let information = DVector::from_iterator(
        common.len(),
        common.iter().map(|&[i, k]| match [first.entries[i].prior_sigma, second.entries[k].prior_sigma] {
            [Some(a), Some(b)] if a > 0.0 && b > 0.0 => 1.0 / (a * b),
            _ => 0.0,
        }),
    );
    let [a, b] = [covariance(0), covariance(1)];
    let shared = &a * DMatrix::from_diagonal(&information) * &b;
    let of_difference = &a + &b - &shared - shared.transpose();
    let scale: Vec<f64> = (a.diagonal() + b.diagonal()).iter().map(|variance| variance.sqrt()).collect();
    let values = |&[i, k]: &[usize; 2]| [first.entries[i].value, second.entries[k].value];
    let differences = DVector::from_iterator(common.len(), common.iter().map(values).map(|[a, b]| b - a));
    let (statistic, degrees_of_freedom) = squared_length(&differences, &of_difference, &scale);
    let change = |(row, indices): (usize, &[usize; 2])| {
        let sigma = of_difference[(row, row)].max(0.0).sqrt();
        let is_known = sigma > LEAST_SHARE * scale[row];
        let name = first.entries[indices[0]].name.clone();
        ParameterChange { name, values: values(indices), sigma: if is_known { sigma } else { 0.0 } }
    };
    Comparison {
        parameters: common.iter().enumerate().map(change).collect(),
        statistic,
        degrees_of_freedom,
        p_value: ChiSquared::new(degrees_of_freedom as f64).ok().map(|chance| chance.sf(statistic)),
    }
}

/// `dᵀ C⁺ d` over the directions in which `covariance` is not negligible in units of `scale`, and
/// the number of these directions.
fn squared_length(differences: &DVector<f64>, covariance: &DMatrix<f64>, scale: &[f64]) -> (f64, usize) {
    let determined: Vec<usize> = (0..scale.len()).filter(|&i| scale[i] > 0.0).collect();
    let scaled = DMatrix::from_fn(determined.len(), determined.len(), |i, k| {
        let (i, k) = (determined[i], determined[k]);
        covariance[(i, k)] / (scale[i] * scale[k])
    });
    let lengths = DVector::from_iterator(determined.len(), determined.iter().map(|&i| differences[i] / scale[i]));
    if lengths.is_empty() || scaled.iter().chain(&lengths).any(|entry| !entry.is_finite()) {
        return (0.0, 0);
    }
    let eigen = scaled.symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(&lengths);
    let parts = along.iter().zip(&eigen.eigenvalues).filter(|(_, variance)| **variance > LEAST_SHARE.powi(2));
    parts.fold((0.0, 0), |(sum, count), (length, variance)| (sum + length * length / variance, count + 1))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::estimate::PosteriorEntry;

    /// Estimates of `truth` from linear measurements with unit noise and a prior of standard
    /// deviation 1 about 0.
    fn estimate(truth: &DVector<f64>, jacobian: &DMatrix<f64>, rng: &mut Pcg64) -> ParameterPosterior {
        let noise = DVector::from_iterator(jacobian.nrows(), (0..jacobian.nrows()).map(|_| StandardNormal.sample(rng)));
        let identity = DMatrix::identity(truth.len(), truth.len());
        let covariance = (jacobian.tr_mul(jacobian) + identity).try_inverse().unwrap();
        let values = &covariance * jacobian.tr_mul(&(jacobian * truth + noise));
        let entry = |(i, value): (usize, &f64)| PosteriorEntry {
            name: format!("strain.{i}"),
            value: *value,
            prior_sigma: Some(1.0),
        };
        ParameterPosterior { entries: values.iter().enumerate().map(entry).collect(), covariance, noise: None }
    }

    fn normal(rows: usize, columns: usize, rng: &mut Pcg64) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| StandardNormal.sample(rng))
    }

    /// Over 4000 pairs of estimates of one truth, drawn from the prior, the statistic has the mean
    /// of its chi-squared distribution within five standard errors, and 1 % of the p-values are
    /// below 0.01; six parameters, of which four measurements of either determine some directions
    /// well, some barely, and some not at all.
    #[test]
    fn estimates_of_one_arm_differ_as_their_covariance_says() {
        let mut rng = Pcg64::seed_from_u64(1);
        let (mut sum, mut rare, mut deviations, trials) = (0.0, 0, 0.0, 4000);
        for _ in 0..trials {
            let truth = normal(6, 1, &mut rng).column(0).into_owned();
            let [first, second] = [0.3, 2.0].map(|size| {
                let jacobian = size * normal(4, 6, &mut rng);
                estimate(&truth, &jacobian, &mut rng)
            });
            let found = compare(&first, &second, |_| true);
            assert_eq!(found.degrees_of_freedom, 6);
            sum += found.statistic / 6.0;
            rare += usize::from(found.p_value.unwrap() < 0.01);
            deviations += found.parameters[0].deviations().unwrap().powi(2);
        }
        let count = f64::from(trials);
        let error = (2.0 / 6.0 / count).sqrt();
        assert!((sum / count - 1.0).abs() < 5.0 * error, "{}", sum / count);
        assert!((deviations / count - 1.0).abs() < 5.0 * (2.0 / count).sqrt(), "{}", deviations / count);
        let rare = rare as f64 / count;
        assert!((rare - 0.01).abs() < 5.0 * (0.01 / count).sqrt(), "{rare}");
    }

    /// A direction that neither determines does not count, and a change of three deviations is
    /// found.
    #[test]
    fn what_neither_determines_is_left_out() {
        let mut rng = Pcg64::seed_from_u64(2);
        let jacobian = DMatrix::from_fn(200, 3, |row, column| if column == row % 2 { 1.0 } else { 0.0 });
        let truth = DVector::from_vec(vec![0.2, -0.1, 0.5]);
        let mut moved = truth.clone();
        moved[1] += 1.0;
        let [first, second] = [&truth, &moved].map(|truth| estimate(truth, &jacobian, &mut rng));
        let found = compare(&first, &second, |_| true);
        assert_eq!(found.degrees_of_freedom, 2);
        assert_eq!(found.parameters[2].deviations(), None);
        // A hundred measurements of each: the difference of two estimates is known to 0.14.
        assert!((found.parameters[1].sigma - 0.02f64.sqrt()).abs() < 0.01, "{found:?}");
        assert!(found.p_value.unwrap() < 1e-6, "{found:?}");
        assert_eq!(compare(&first, &second, |name| name == "strain.0").parameters.len(), 1);
        assert_eq!(compare(&first, &second, |_| false).p_value, None);
    }
}
