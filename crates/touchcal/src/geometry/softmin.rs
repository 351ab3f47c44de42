//! The soft minimum: a mean of the gaps that are nearly the least.

use crate::se3::Twist;

/// Features farther than this many temperatures from the least gap have no weight.
pub(super) const CUTOFF: f64 = 4.0;
/// A distance and its gradient, as in [`SignedGap`](super::gap::SignedGap).
#[derive(Clone, Copy)]
pub(super) struct Term {
    pub(super) value: f64,
    pub(super) gradient: Twist,
}

/// The sums of a soft minimum over features, their distances `v` taken relative to the least.
pub(super) struct SoftMin {
    temperature: f64,
    least: Term,
    /// `Σ w`, `Σ w v`.
    weights: (f64, f64),
    /// `Σ w′`, `Σ w′ v`, with `w′ = ∂w/∂v`.
    slopes: (f64, f64),
    /// `Σ w′ ∂v`, `Σ (w + w′ v) ∂v`.
    gradients: (Twist, Twist),
}

impl SoftMin {
    /// Of nothing yet, around the least distance.
    pub(super) fn new(least: Term, temperature: f64) -> Self {
        SoftMin {
            temperature,
            least,
            weights: (0.0, 0.0),
            slopes: (0.0, 0.0),
            gradients: (Twist::zeros(), Twist::zeros()),
        }
    }

    /// Adds a feature.
    #[inline]
    pub(super) fn add(&mut self, row: &Term) {
        let v = row.value - self.least.value;
        let x = v / self.temperature;
        let taper = 1.0 - (x / CUTOFF).powi(2);
        if taper <= 0.0 {
            return;
        }
        let decay = (-x).exp() * taper;
        let weight = decay * taper;
        let slope = -decay * (taper + 4.0 * x / CUTOFF.powi(2)) / self.temperature;
        self.weights.0 += weight;
        self.weights.1 += weight * v;
        self.slopes.0 += slope;
        self.slopes.1 += slope * v;
        self.gradients.0 += row.gradient * slope;
        self.gradients.1 += row.gradient * (weight + slope * v);
    }

    /// The mean and its gradient.
    pub(super) fn mean(&self) -> (f64, Twist) {
        let mean = self.weights.1 / self.weights.0;
        // The least distance takes part in every weight.
        let shared = self.least.gradient * (self.slopes.1 - self.slopes.0 * mean);
        let gradient = self.gradients.1 - self.gradients.0 * mean - shared;
        (self.least.value + mean, gradient / self.weights.0)
    }
}
