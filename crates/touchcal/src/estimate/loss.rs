//! Robust losses of a squared whitened residual `s = ‖r‖²`.
//!
//! | loss | ρ(s) | weight ρ′(s) |
//! |---|---|---|
//! | squared | s | 1 |
//! | Huber | s, or 2k√s − k² beyond k | 1, or k/√s |
//! | Cauchy | k² ln(1 + s/k²) | 1/(1 + s/k²) |
//! | Geman–McClure | k²s/(k² + s) | (k²/(k² + s))² |
//!
//! Source: Zhang, *Parameter estimation techniques* (1997), table 1, scaled so that ρ(s) ≈ s near zero. The last
//! one redescends: a contact far off the manifold ends up without any say.

/// A robust loss; `k` is in whitened units (standard deviations).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// Least squares.
    Squared,
    /// Huber (1964).
    Huber(f64),
    /// Cauchy.
    Cauchy(f64),
    /// Geman & McClure (1985).
    GemanMcClure(f64),
}

impl Loss {
    /// ρ(s).
    pub fn cost(self, s: f64) -> f64 {
        match self {
            Loss::Squared => s,
            Loss::Huber(k) if s <= k * k => s,
            Loss::Huber(k) => 2.0 * k * s.sqrt() - k * k,
            Loss::Cauchy(k) => k * k * (s / (k * k)).ln_1p(),
            Loss::GemanMcClure(k) => k * k * s / (k * k + s),
        }
    }

    /// ρ′(s), the weight of a contact in the normal equations.
    pub fn weight(self, s: f64) -> f64 {
        match self {
            Loss::Squared => 1.0,
            Loss::Huber(k) if s <= k * k => 1.0,
            Loss::Huber(k) => k / s.sqrt(),
            Loss::Cauchy(k) => 1.0 / (1.0 + s / (k * k)),
            Loss::GemanMcClure(k) => (k * k / (k * k + s)).powi(2),
        }
    }

    /// The same loss with its scale multiplied: a larger one is nearer to least squares.
    pub fn widened(self, factor: f64) -> Loss {
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
    fn all_losses_are_least_squares_near_zero_and_when_widened() {
        for loss in LOSSES {
            assert!((loss.cost(1e-6) / 1e-6 - 1.0).abs() < 1e-5);
            assert!((loss.widened(1e6).weight(100.0) - 1.0).abs() < 1e-9);
        }
    }
}
