//! Robust losses of a squared whitened residual `s = ‖r‖²`.
//!
//! | loss | ρ(s) | weight ρ′(s) |
//! |---|---|---|
//! | squared | s | 1 |
//! | Huber | s, or 2k√s − k² beyond k | 1, or k/√s |
//! | Cauchy | k² ln(1 + s/k²) | 1/(1 + s/k²) |
//! | Geman–McClure | k²s/(k² + s) | (k²/(k² + s))² |
//!
//! Source: Zhang, *Parameter estimation techniques* (1997), table 1, scaled so that ρ(s) ≈ s near
//! zero. The last one redescends: the weight of a contact far off the manifold vanishes.

use serde::{Deserialize, Serialize};

/// A robust loss ρ(s) of a squared whitened residual norm `s = ‖r‖²` (1), as in Zhang, *Parameter
/// estimation techniques* (1997), table 1, with ρ(s) ≈ s near zero. Its scale `k` > 0 is in
/// whitened units: standard deviations of the residual.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Loss {
    /// Least squares, ρ = s: no contact is down-weighted.
    Squared,
    /// Huber (1964) with scale `k`, ρ = s up to k² and 2k√s − k² beyond: quadratic in ‖r‖ up to
    /// `k`, linear beyond.
    Huber(f64),
    /// Cauchy or Lorentzian with scale `k`, ρ = k² ln(1 + s/k²): grows logarithmically.
    Cauchy(f64),
    /// Geman & McClure (1985) with scale `k`, ρ = k²s/(k² + s): bounded by k².
    GemanMcClure(f64),
}

impl Loss {
    /// Cost ρ(s) (1) of a squared whitened residual norm `s` (1, ≥ 0): s near zero.
    pub fn cost(self, s: f64) -> f64 {
        match self {
            Loss::Squared => s,
            Loss::Huber(k) if s <= k * k => s,
            Loss::Huber(k) => 2.0 * k * s.sqrt() - k * k,
            Loss::Cauchy(k) => k * k * (s / (k * k)).ln_1p(),
            Loss::GemanMcClure(k) => k * k * s / (k * k + s),
        }
    }

    /// Weight ρ′(s) of a contact in the normal equations, 0 to 1, for a squared whitened residual
    /// norm `s` (1, ≥ 0): 1 near zero.
    pub fn weight(self, s: f64) -> f64 {
        match self {
            Loss::Squared => 1.0,
            Loss::Huber(k) if s <= k * k => 1.0,
            Loss::Huber(k) => k / s.sqrt(),
            Loss::Cauchy(k) => 1.0 / (1.0 + s / (k * k)),
            Loss::GemanMcClure(k) => (k * k / (k * k + s)).powi(2),
        }
    }

    /// Derivative ρ″(s) ≤ 0 (1) of [`Loss::weight`] by the squared whitened residual norm `s` (1,
    /// ≥ 0). That of [`Loss::Huber`] jumps at k².
    pub fn weight_slope(self, s: f64) -> f64 {
        match self {
            Loss::Squared => 0.0,
            Loss::Huber(k) if s <= k * k => 0.0,
            Loss::Huber(k) => -0.5 * k * s.powf(-1.5),
            Loss::Cauchy(k) => -1.0 / (k * k * (1.0 + s / (k * k)).powi(2)),
            Loss::GemanMcClure(k) => -2.0 * k.powi(4) / (k * k + s).powi(3),
        }
    }

    /// Variance of an estimate with this loss over that of least squares where there are no
    /// outliers: `E[ψ²]/E[ψ′]²` of `dimension` standard normal residual rows that share one weight,
    /// with `ψ(r) = ρ′(‖r‖²) r` (Huber 1981, section 4.4), by integration over ‖r‖ up to 12. It is
    /// 1 for [`Loss::Squared`] and larger for the others; a `dimension` of 0 counts as 1, one above
    /// 50 is not meant.
    pub fn gaussian_variance(self, dimension: usize) -> f64 {
        const STEP: f64 = 0.001;
        let d = dimension.max(1) as f64;
        let (mut total, mut slope, mut square) = (0.0, 0.0, 0.0);
        for k in 0..12_000 {
            let r = (k as f64 + 0.5) * STEP;
            let s = r * r;
            let density = r.powf(d - 1.0) * (-0.5 * s).exp();
            let weight = self.weight(s);
            total += density;
            slope += density * (weight + 2.0 * s * self.weight_slope(s) / d);
            square += density * weight * weight * s / d;
        }
        square * total / (slope * slope)
    }

    /// The same loss with its scale `k` multiplied by `factor` > 0: a larger one is nearer to least
    /// squares. [`Loss::Squared`] has no scale and stays as it is.
    pub fn scaled(self, factor: f64) -> Loss {
        match self {
            Loss::Squared => Loss::Squared,
            Loss::Huber(k) => Loss::Huber(k * factor),
            Loss::Cauchy(k) => Loss::Cauchy(k * factor),
            Loss::GemanMcClure(k) => Loss::GemanMcClure(k * factor),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOSSES: [Loss; 4] = [Loss::Squared, Loss::Huber(1.5), Loss::Cauchy(2.0), Loss::GemanMcClure(3.0)];

    #[test]
    fn weight_is_the_derivative_of_the_cost() {
        for loss in LOSSES {
            for s in [1e-3, 0.5, 2.0, 2.5, 9.0, 400.0] {
                let h = 1e-5 * s;
                let slope = (loss.cost(s + h) - loss.cost(s - h)) / (2.0 * h);
                assert!((slope - loss.weight(s)).abs() < 1e-8, "{loss:?} at {s}: {slope}");
            }
        }
    }

    #[test]
    fn gaussian_variance_matches_known_efficiencies() {
        // Huber at 1.345 and Cauchy at 2.385 are 95 % efficient in one dimension (Zhang 1997).
        assert!((Loss::Squared.gaussian_variance(1) - 1.0).abs() < 1e-6);
        assert!((Loss::Squared.gaussian_variance(3) - 1.0).abs() < 1e-6);
        assert!((1.0 / Loss::Huber(1.345).gaussian_variance(1) - 0.95).abs() < 1e-3);
        assert!((1.0 / Loss::Cauchy(2.3849).gaussian_variance(1) - 0.95).abs() < 1e-3);
    }

    #[test]
    fn all_losses_are_least_squares_near_zero_and_of_large_scale() {
        for loss in LOSSES {
            assert!((loss.cost(1e-6) / 1e-6 - 1.0).abs() < 1e-5);
            assert!((loss.scaled(1e6).weight(100.0) - 1.0).abs() < 1e-9);
        }
    }
}
