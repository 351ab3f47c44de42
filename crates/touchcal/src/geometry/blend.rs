//! The mean of the gaps that are nearly the least.

use super::scan::{Candidate, Sink};
use crate::se3::Twist;

/// Features farther than this many temperatures from the least gap have no part in a blend.
pub(super) const REACH: f64 = 6.0;
/// Features kept at a time. With more within reach the blend takes a second sweep.
const KEPT: usize = 32;

/// Keeps the distances that can be part of a blend.
pub(super) struct Nearest {
    margin: f64,
    reach: f64,
    least: Candidate,
    kept: [Candidate; KEPT],
    count: usize,
    overflowed: bool,
}

impl Nearest {
    /// Those up to `margin` (m) above the least.
    pub(super) fn within(margin: f64) -> Self {
        Nearest {
            margin,
            reach: f64::INFINITY,
            least: Candidate::none(),
            kept: [const { Candidate::none() }; KEPT],
            count: 0,
            overflowed: false,
        }
    }

    /// The least distance.
    pub(super) fn least(&self) -> &Candidate {
        &self.least
    }

    /// The distances within the margin, unless there were too many.
    pub(super) fn kept(&self) -> Option<impl Iterator<Item = &Candidate>> {
        (!self.overflowed).then(|| self.kept[..self.count].iter().filter(|c| c.value < self.reach))
    }

    /// Forgets what is no longer within reach.
    fn drop_stale(&mut self) {
        let mut count = 0;
        for k in 0..self.count {
            if self.kept[k].value < self.reach {
                self.kept.swap(count, k);
                count += 1;
            }
        }
        self.count = count;
    }
}

impl Sink for Nearest {
    const ALL: bool = true;

    fn reach(&self) -> f64 {
        self.reach
    }

    fn take(&mut self, candidate: Candidate) {
        if candidate.value < self.least.value {
            self.least = candidate.clone();
            self.reach = (candidate.value + self.margin).next_up();
        }
        if self.count == KEPT {
            self.drop_stale();
        }
        if self.count == KEPT {
            self.overflowed = true;
        } else {
            self.kept[self.count] = candidate;
            self.count += 1;
        }
    }
}

/// Sums over the features of a blend, their distances `v` taken relative to the least.
pub(super) struct Blend {
    temperature: f64,
    least: f64,
    /// `Σ w`, `Σ w v`.
    weights: (f64, f64),
    /// `Σ w′`, `Σ w′ v`, with `w′ = ∂w/∂v`.
    slopes: (f64, f64),
    /// `Σ w′ ∂v`, `Σ (w + w′ v) ∂v`.
    gradients: (Twist, Twist),
}

impl Blend {
    /// Of nothing yet, around the least distance.
    pub(super) fn new(least: f64, temperature: f64) -> Self {
        Blend {
            temperature,
            least,
            weights: (0.0, 0.0),
            slopes: (0.0, 0.0),
            gradients: (Twist::zeros(), Twist::zeros()),
        }
    }

    /// Adds a feature.
    pub(super) fn add(&mut self, value: f64, gradient: &Twist) {
        let v = value - self.least;
        let x = v / self.temperature;
        let taper = (1.0 - (x / REACH).powi(2)).max(0.0);
        let decay = (-x).exp() * taper;
        let weight = decay * taper;
        let slope = -decay * (taper + 4.0 * x / REACH.powi(2)) / self.temperature;
        self.weights.0 += weight;
        self.weights.1 += weight * v;
        self.slopes.0 += slope;
        self.slopes.1 += slope * v;
        self.gradients.0 += gradient * slope;
        self.gradients.1 += gradient * (weight + slope * v);
    }

    /// The mean and its gradient, given that of the least distance, which moves all weights.
    pub(super) fn mean(&self, least_gradient: &Twist) -> (f64, Twist) {
        let mean = self.weights.1 / self.weights.0;
        let gradient =
            self.gradients.1 - self.gradients.0 * mean - least_gradient * (self.slopes.1 - self.slopes.0 * mean);
        (self.least + mean, gradient / self.weights.0)
    }
}
