//! Gaps of a straight peg and hole, from one sweep over their features.

use super::blend_sink::NearLeast;
use super::feature::{Feature, FeatureDistance, Sink};
use super::feature_sweep::FeatureSweep;
use super::prism_pair::PrismPair;
use super::visit_features::visit_features;
use crate::geometry::gap::{GapQuery, SignedGap};
use crate::geometry::mesh_gap::NeighborList;
use crate::geometry::softmin::{self, SoftMin, Term};
use crate::se3::{Pose, Twist};

impl GapQuery for PrismPair {
    fn gap(&self, hole_from_peg: &Pose) -> SignedGap {
        nearest_feature(self, hole_from_peg).0
    }

    fn blended_gap(&self, hole_from_peg: &Pose, temperature: f64) -> (f64, Twist) {
        let sweep = FeatureSweep::new(self, hole_from_peg);
        if temperature <= 0.0 {
            let least = smallest(&sweep);
            return (least.value - sweep.sum_of_radii(), sweep.gradient(&least));
        }
        let mut nearest = NearLeast::within(softmin::CUTOFF * temperature, &sweep);
        visit_features(&sweep, &mut nearest);
        let mut blend = SoftMin::new(nearest.least, temperature);
        match nearest.kept() {
            Some(kept) => kept.iter().for_each(|term| blend.add(term)),
            None => visit_features(
                &sweep,
                &mut Below {
                    cutoff: nearest.reach(),
                    visit: |d: &FeatureDistance| blend.add(&Term { value: d.value, gradient: sweep.gradient(d) }),
                },
            ),
        }
        let (mean, gradient) = blend.mean();
        (mean - sweep.sum_of_radii(), gradient)
    }

    /// Searches are short: nothing is kept.
    fn visit_below(
        &self,
        hole_from_peg: &Pose,
        cutoff: f64,
        _neighbors: &mut Option<Box<NeighborList>>,
        visit: &mut dyn FnMut(&SignedGap),
    ) {
        visit_features_below(self, hole_from_peg, cutoff, |gap, _| visit(gap));
    }
}

/// The signed gap (m) of a peg and a hole at the pose `hole_from_peg` (m, of finite numbers), and
/// the pair of features between which it is attained; of equally near pairs any. The fixture frame
/// of [`SignedGap`] is that of the hole. Allocates nothing.
pub fn nearest_feature(pair: &PrismPair, hole_from_peg: &Pose) -> (SignedGap, Feature) {
    let sweep = FeatureSweep::new(pair, hole_from_peg);
    let least = smallest(&sweep);
    (sweep.signed_gap(&least), least.feature)
}

/// Calls `visit(gap, feature)` for the pairs of features whose signed distance exceeds the gap by
/// at most `margin` (m; none if negative) at the pose `hole_from_peg` (m), in no particular order,
/// and returns the gap, as [`nearest_feature`]. Allocates nothing.
///
/// A corner or edge that penetrates is reported against the nearest face or edge and that one's
/// neighbours in a corner of the hole.
pub fn visit_features_within(
    pair: &PrismPair,
    hole_from_peg: &Pose,
    margin: f64,
    visit: impl FnMut(&SignedGap, Feature),
) -> SignedGap {
    let sweep = FeatureSweep::new(pair, hole_from_peg);
    let least = smallest(&sweep);
    visit_below(&sweep, (least.value + margin).next_up(), visit);
    sweep.signed_gap(&least)
}

/// Calls `visit(gap, feature)` for the pairs of features whose signed distance is below `cutoff`
/// (m, of either sign) at the pose `hole_from_peg` (m), in one sweep and in no particular order;
/// never if there are none. Penetrating features are reported as in [`visit_features_within`].
pub fn visit_features_below(
    pair: &PrismPair,
    hole_from_peg: &Pose,
    cutoff: f64,
    visit: impl FnMut(&SignedGap, Feature),
) {
    let sweep = FeatureSweep::new(pair, hole_from_peg);
    visit_below(&sweep, cutoff + sweep.sum_of_radii(), visit);
}

/// Visits the pairs of features whose distance in the eroded bodies is below `cutoff` (m).
fn visit_below(sweep: &FeatureSweep<'_>, cutoff: f64, mut visit: impl FnMut(&SignedGap, Feature)) {
    let visit = |distance: &FeatureDistance| visit(&sweep.signed_gap(distance), distance.feature);
    visit_features(sweep, &mut Below { cutoff, visit });
}

/// The least of all distances.
fn smallest(sweep: &FeatureSweep<'_>) -> FeatureDistance {
    let mut nearest = Smallest { best: FeatureDistance::none() };
    visit_features(sweep, &mut nearest);
    nearest.best
}

/// Keeps the smallest distance.
struct Smallest {
    best: FeatureDistance,
}

impl Sink for Smallest {
    const ALL: bool = false;

    fn reach(&self) -> f64 {
        self.best.value
    }

    #[inline]
    fn take(&mut self, distance: FeatureDistance) {
        self.best = distance;
    }
}

/// Passes every distance of eroded bodies below a cutoff on.
struct Below<F> {
    cutoff: f64,
    visit: F,
}

impl<F: FnMut(&FeatureDistance)> Sink for Below<F> {
    const ALL: bool = true;

    fn reach(&self) -> f64 {
        self.cutoff
    }

    fn take(&mut self, distance: FeatureDistance) {
        (self.visit)(&distance);
    }
}
