//! What changed between two calibrations of one arm.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::result::ParameterPosterior;

/// A direction counts if contacts determine at least this share of its variance; in the others both
/// estimates are mostly those of the prior.
const LEAST_SHARE: f64 = 0.5;
/// Variances below this share of the largest are rounding.
const ROUNDING: f64 = 1e-12;

/// A parameter in two calibrations.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterChange {
    /// Name, such as `joint_offset.joint_a1`.
    pub name: String,
    /// Estimates (SI) of the first and the second calibration.
    pub values: [f64; 2],
    /// Standard deviation (SI) of the difference of both estimates if the parameter is the same; 0
    /// where both are fixed, or mostly the prior's.
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
    /// The parameters that both estimate, in the order of the first.
    pub parameters: Vec<ParameterChange>,
    /// Names of the compared parameters that only one estimates.
    pub only_in_one: Vec<String>,
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
/// With independent contacts, posterior covariances `C` and prior information `Λ` the covariance of
/// the difference is `Cₐ + C_b − CₐΛC_b − C_bΛCₐ`, because both estimates are drawn to the same
/// prior. The posterior covariances of [`Estimate`](super::Estimate) are wider than that by what
/// the model leaves out, so the differences are tested against `Cₐ + C_b`, in those directions
/// alone of which the last two terms take less than half. So the test errs towards no change: also
/// because errors that both have in common (of a tool that stayed mounted, of a fixture that stayed
/// in place) count as independent. Where the two priors differ, as variance components do, `Λ` is
/// their geometric mean.
pub fn compare(
    first: &ParameterPosterior,
    second: &ParameterPosterior,
    is_compared: impl Fn(&str) -> bool,
) -> Comparison {
    let (common, only_in_one) = common(first, second, is_compared);
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
    let (sum, shared) = (&a + &b, &shared + shared.transpose());
    let values = |&[i, k]: &[usize; 2]| [first.entries[i].value, second.entries[k].value];
    let differences = DVector::from_iterator(common.len(), common.iter().map(values).map(|[a, b]| b - a));
    let (statistic, degrees_of_freedom) = squared_length(&differences, &sum, &shared);
    let change = |(row, indices): (usize, &[usize; 2])| {
        let is_known = shared[(row, row)] < (1.0 - LEAST_SHARE) * sum[(row, row)];
        let sigma = if is_known { sum[(row, row)].sqrt() } else { 0.0 };
        ParameterChange { name: first.entries[indices[0]].name.clone(), values: values(indices), sigma }
    };
    Comparison {
        parameters: common.iter().enumerate().map(change).collect(),
        only_in_one,
        statistic,
        degrees_of_freedom,
        p_value: ChiSquared::new(degrees_of_freedom as f64).ok().map(|chance| chance.sf(statistic)),
    }
}

/// Indices of the compared parameters that both estimate or both fix, and names of the others.
fn common(
    first: &ParameterPosterior,
    second: &ParameterPosterior,
    is_compared: impl Fn(&str) -> bool,
) -> (Vec<[usize; 2]>, Vec<String>) {
    let is_free = |posterior: &ParameterPosterior, i: usize| posterior.covariance[(i, i)] > 0.0;
    let (mut common, mut only_in_one) = (Vec::new(), Vec::new());
    for (i, entry) in first.entries.iter().enumerate().filter(|(_, entry)| is_compared(&entry.name)) {
        match second.index(&entry.name).filter(|&k| is_free(first, i) == is_free(second, k)) {
            Some(k) => common.push([i, k]),
            None => only_in_one.push(entry.name.clone()),
        }
    }
    let only_second =
        second.entries.iter().filter(|entry| is_compared(&entry.name) && first.index(&entry.name).is_none());
    only_in_one.extend(only_second.map(|entry| entry.name.clone()));
    (common, only_in_one)
}

/// Squared length of `differences` in units of their covariance `sum`, over the directions of which
/// `shared` takes less than half, and the number of these directions.
fn squared_length(differences: &DVector<f64>, sum: &DMatrix<f64>, shared: &DMatrix<f64>) -> (f64, usize) {
    let free: Vec<usize> = (0..differences.len()).filter(|&i| sum[(i, i)] > 0.0).collect();
    let scale = |i: usize| sum[(i, i)].sqrt();
    let scaled = |matrix: &DMatrix<f64>| {
        DMatrix::from_fn(free.len(), free.len(), |i, k| matrix[(free[i], free[k])] / (scale(free[i]) * scale(free[k])))
    };
    let [sum_scaled, shared_scaled] = [sum, shared].map(scaled);
    let lengths = DVector::from_iterator(free.len(), free.iter().map(|&i| differences[i] / scale(i)));
    let numbers = sum_scaled.iter().chain(&shared_scaled).chain(&lengths);
    if free.is_empty() || numbers.copied().any(|number| !number.is_finite()) {
        return (0.0, 0);
    }
    // Coordinates in which `sum` is the identity.
    let eigen = sum_scaled.symmetric_eigen();
    let least = ROUNDING * eigen.eigenvalues.max();
    let kept: Vec<usize> = (0..free.len()).filter(|&k| eigen.eigenvalues[k] > least).collect();
    let whitening = DMatrix::from_fn(kept.len(), free.len(), |row, i| {
        eigen.eigenvectors[(i, kept[row])] / eigen.eigenvalues[kept[row]].sqrt()
    });
    let share = (&whitening * shared_scaled * whitening.transpose()).symmetric_eigen();
    let along = share.eigenvectors.tr_mul(&(whitening * lengths));
    let determined = along.iter().zip(&share.eigenvalues).filter(|(_, share)| **share < 1.0 - LEAST_SHARE);
    determined.fold((0.0, 0), |(sum, count), (length, _)| (sum + length * length, count + 1))
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

    /// Over 4000 pairs of estimates of one truth, drawn from the prior: where contacts determine
    /// all directions well, the statistic has the mean of its chi-squared distribution within five
    /// standard errors and 1 % of the p-values are below 0.01; where they determine some barely
    /// and some not at all, both are smaller, and so they are with covariances that are wider than
    /// the errors.
    #[test]
    fn estimates_of_one_arm_differ_as_their_covariance_says() {
        let mut rng = Pcg64::seed_from_u64(1);
        for (rows, size, wider) in [(40, 20.0, 1.0), (4, 1.0, 1.0), (4, 1.0, 1.5)] {
            let (mut sum, mut all, mut rare, trials) = (0.0, 0, 0, 4000);
            for _ in 0..trials {
                let truth = normal(6, 1, &mut rng).column(0).into_owned();
                let [first, second] = [0.3 * size, size].map(|size| {
                    let jacobian = size * normal(rows, 6, &mut rng);
                    let mut found = estimate(&truth, &jacobian, &mut rng);
                    found.covariance *= wider * wider;
                    found
                });
                let found = compare(&first, &second, |_| true);
                sum += found.statistic;
                all += found.degrees_of_freedom;
                rare += usize::from(found.p_value.is_some_and(|p| p < 0.01));
            }
            let (mean, count) = (sum / all as f64, f64::from(trials));
            let rare = rare as f64 / count;
            let [error_of_mean, error_of_rare] = [(2.0 / all as f64).sqrt(), (0.01 / count).sqrt()];
            assert!(mean < 1.0 + 5.0 * error_of_mean && rare < 0.01 + 5.0 * error_of_rare, "{mean} {rare}");
            if rows == 40 {
                assert_eq!(all, 6 * 4000);
                assert!(mean > 1.0 - 5.0 * error_of_mean && rare > 0.01 - 5.0 * error_of_rare, "{mean} {rare}");
            }
        }
    }

    /// A sum that is known a thousand times better than its parts is one direction, in which a
    /// change of ten standard deviations is found.
    #[test]
    fn a_combination_that_is_known_well_is_compared() {
        let mut rng = Pcg64::seed_from_u64(3);
        let jacobian = DMatrix::from_element(1, 2, 1e3);
        let truth = DVector::from_vec(vec![0.5, -0.5]);
        let mut moved = truth.clone();
        moved[0] += 0.014;
        let [first, same, other] = [&truth, &truth, &moved].map(|truth| estimate(truth, &jacobian, &mut rng));
        let found = compare(&first, &same, |_| true);
        assert_eq!(found.degrees_of_freedom, 1);
        assert!(found.p_value.unwrap() > 0.001, "{found:?}");
        assert!(compare(&first, &other, |_| true).p_value.unwrap() < 1e-9);
    }

    /// A parameter that only one estimates, or only one fixes, is not compared.
    #[test]
    fn what_only_one_estimates_is_named() {
        let mut rng = Pcg64::seed_from_u64(4);
        let truth = DVector::from_vec(vec![0.5, -0.5, 0.1]);
        let [first, mut second] = [3, 3].map(|rows| estimate(&truth, &normal(rows, 3, &mut rng), &mut rng));
        second.entries[0].name = "joint_offset.0".to_owned();
        second.covariance.row_mut(1).fill(0.0);
        second.covariance.column_mut(1).fill(0.0);
        let found = compare(&first, &second, |_| true);
        assert_eq!(found.only_in_one, ["strain.0", "strain.1", "joint_offset.0"]);
        assert_eq!(found.parameters.len(), 1);
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
