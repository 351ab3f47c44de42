//! The least of several noisy gaps.

use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::estimate::contact_mode::CandidateMatrix;

/// Standard deviation of a difference, over those of its terms, below which they are the same.
const SAME: f64 = 1e-6;

/// Mean and variance of the least of jointly Gaussian numbers of these means and this covariance:
/// exact for two, and as if the least of the first ones were Gaussian for more, which makes the
/// mean square up to 4 % too small. Zeros for none.
///
/// Source: Clark, *The greatest of a finite set of random variables* (1961), equations 2 to 6.
pub(super) fn least(means: &[f64], covariance: &CandidateMatrix) -> (f64, f64) {
    let normal = Normal::standard();
    let Some(&first) = means.first() else { return (0.0, 0.0) };
    let (mut mean, mut variance) = (first, covariance[(0, 0)]);
    // Covariances of the least of the first ones with each.
    let mut with = covariance.column(0).into_owned();
    for (j, &other) in means.iter().enumerate().skip(1) {
        let other_variance = covariance[(j, j)];
        let apart = (variance + other_variance - 2.0 * with[j]).max(0.0).sqrt();
        let sum = (variance + other_variance).sqrt();
        // The probability that the first ones have the least, and the density where both are equal.
        let (share, density) = match (other - mean) / apart {
            alpha if apart > SAME * sum => (normal.cdf(alpha), normal.pdf(alpha)),
            _ => (f64::from(u8::from(mean <= other)), 0.0),
        };
        let rest = 1.0 - share;
        let least = mean * share + other * rest - apart * density;
        let square = (mean * mean + variance) * share + (other * other + other_variance) * rest
            - (mean + other) * apart * density;
        with = with * share + covariance.column(j) * rest;
        (mean, variance) = (least, (square - least * least).max(0.0));
    }
    (mean, variance)
}

#[cfg(test)]
mod tests {
    use nalgebra::Cholesky;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::estimate::contact_mode::CandidateVector;

    /// Against the least of numbers drawn from the same distribution.
    #[test]
    fn the_least_of_correlated_gaps_is_that_of_drawn_ones() {
        const DRAWS: usize = 200_000;
        let mut chance = Pcg64::seed_from_u64(1);
        for (count, correlation) in [(1, 0.0), (2, 0.0), (2, 0.9), (3, 0.3), (5, 0.0), (5, 0.7)] {
            let means: Vec<f64> = (0..count).map(|k| 0.4 * k as f64).collect();
            let mut covariance = CandidateMatrix::identity();
            for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))).filter(|(i, j)| i != j) {
                covariance[(i, j)] = correlation;
            }
            covariance[(0, 0)] = 1.5;
            let factor = Cholesky::new(covariance).expect("a covariance").l();
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..DRAWS {
                let normal = CandidateVector::from_fn(|_, _| StandardNormal.sample(&mut chance));
                let noise: CandidateVector = factor * normal;
                let drawn = (0..count).map(|k| means[k] + noise[k]).fold(f64::INFINITY, f64::min);
                sum += drawn;
                squares += drawn * drawn;
            }
            let (mean, square) = (sum / DRAWS as f64, squares / DRAWS as f64);
            let (found, variance) = least(&means, &covariance);
            // Means of so many draws are off by some thousandths; of more than two numbers the
            // least is not Gaussian, which Clark's moments take it for.
            let [of_mean, of_square] = if count > 2 { [0.02, 0.04] } else { [0.01, 0.01] };
            assert!((found - mean).abs() < of_mean, "{count}, {correlation}: {found} {mean}");
            let expected = found * found + variance;
            assert!((expected / square - 1.0).abs() < of_square, "{count}, {correlation}: {expected} {square}");
        }
    }

    #[test]
    fn the_same_gap_twice_is_one() {
        let covariance = CandidateMatrix::repeat(2.0);
        assert_eq!(least(&[1.0, 3.0], &covariance), (1.0, 2.0));
        assert_eq!(least(&[], &covariance), (0.0, 0.0));
    }
}
