//! The distances that have a part in a soft minimum.

use super::feature::{FeatureDistance, Sink};
use super::feature_sweep::FeatureSweep;
use crate::geometry::softmin::Term;
use crate::se3::Twist;

/// Features kept at a time. With more within the margin the soft minimum takes a second sweep.
const KEPT: usize = 160;

/// Keeps the distances that can be part of a blend.
pub(super) struct NearLeast<'a> {
    sweep: &'a FeatureSweep<'a>,
    margin: f64,
    reach: f64,
    pub(super) least: Term,
    kept: [Term; KEPT],
    count: usize,
    overflowed: bool,
}

impl<'a> NearLeast<'a> {
    /// Those of a sweep up to `margin` (m) above the least.
    pub(super) fn within(margin: f64, sweep: &'a FeatureSweep<'a>) -> Self {
        let zero = Term { value: 0.0, gradient: Twist::zeros() };
        let least = Term { value: f64::INFINITY, ..zero };
        NearLeast { sweep, margin, reach: f64::INFINITY, least, kept: [zero; KEPT], count: 0, overflowed: false }
    }

    /// The distances found, among them all those within the margin, unless there were too many.
    pub(super) fn kept(&self) -> Option<&[Term]> {
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

impl Sink for NearLeast<'_> {
    const ALL: bool = true;

    fn reach(&self) -> f64 {
        self.reach
    }

    #[inline(always)]
    fn take(&mut self, distance: FeatureDistance) {
        let row = Term { value: distance.value, gradient: self.sweep.gradient(&distance) };
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
