//! The mean of the gaps that are nearly the least.

use super::scan::{Candidate, Scan, Sink};
use crate::se3::Twist;

/// Features farther than this many temperatures from the least gap have no part in a blend.
pub(super) const REACH: f64 = 4.0;
/// Features kept at a time. With more within reach the blend takes a second sweep.
const KEPT: usize = 160;

/// A distance and its gradient, as in [`Gap`](super::extrusion::Gap).
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub(super) value: f64,
    pub(super) gradient: Twist,
}

/// Keeps the distances that can be part of a blend.
pub(super) struct Nearest<'a> {
    scan: &'a Scan<'a>,
    margin: f64,
    reach: f64,
    pub(super) least: Row,
    kept: [Row; KEPT],
    count: usize,
    overflowed: bool,
}

impl<'a> Nearest<'a> {
    /// Those of a scan up to `margin` (m) above the least.
    pub(super) fn within(margin: f64, scan: &'a Scan<'a>) -> Self {
        let zero = Row { value: 0.0, gradient: Twist::zeros() };
        let least = Row { value: f64::INFINITY, ..zero };
        Nearest { scan, margin, reach: f64::INFINITY, least, kept: [zero; KEPT], count: 0, overflowed: false }
    }

    /// The distances found, among them all those within the margin, unless there were too many.
    pub(super) fn kept(&self) -> Option<&[Row]> {
        (!self.overflowed).then_some(&self.kept[..self.count])
    }

    /// Forgets what is no longer within reach.
    fn drop_stale(&mut self) {
        let mut count = 0;
        for k in 0..self.count {
            if self.kept[k].value < self.reach {
                self.kept[count] = self.kept[k];
                count += 1;
            }
        }
        self.count = count;
    }
}

impl Sink for Nearest<'_> {
    const ALL: bool = true;

    fn reach(&self) -> f64 {
        self.reach
    }

    #[inline(always)]
    fn take(&mut self, candidate: Candidate) {
        let row = Row { value: candidate.value, gradient: self.scan.gradient(&candidate) };
        if row.value < self.least.value {
            self.least = row;
            self.reach = (row.value + self.margin).next_up();
        }
        if self.count == KEPT {
            self.drop_stale();
        }
        if self.count == KEPT {
            self.overflowed = true;
        } else {
            self.kept[self.count] = row;
            self.count += 1;
        }
    }
}

/// Sums over the features of a blend, their distances `v` taken relative to the least.
pub(super) struct Blend {
    temperature: f64,
    least: Row,
    /// `Σ w`, `Σ w v`.
    weights: (f64, f64),
    /// `Σ w′`, `Σ w′ v`, with `w′ = ∂w/∂v`.
    slopes: (f64, f64),
    /// `Σ w′ ∂v`, `Σ (w + w′ v) ∂v`.
    gradients: (Twist, Twist),
}

impl Blend {
    /// Of nothing yet, around the least distance.
    pub(super) fn new(least: Row, temperature: f64) -> Self {
        Blend {
            temperature,
            least,
            weights: (0.0, 0.0),
            slopes: (0.0, 0.0),
            gradients: (Twist::zeros(), Twist::zeros()),
        }
    }

    /// Adds a feature.
    #[inline]
    pub(super) fn add(&mut self, row: &Row) {
        let v = row.value - self.least.value;
        let x = v / self.temperature;
        let taper = 1.0 - (x / REACH).powi(2);
        if taper <= 0.0 {
            return;
        }
        let decay = (-x).exp() * taper;
        let weight = decay * taper;
        let slope = -decay * (taper + 4.0 * x / REACH.powi(2)) / self.temperature;
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
