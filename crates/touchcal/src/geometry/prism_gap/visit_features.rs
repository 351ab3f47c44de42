//! One sweep over the features of a peg and a hole at a pose.

use super::feature::Sink;
use super::feature_sweep::FeatureSweep;
use super::{corner_features, edge_features};

/// Cosine of the tilt beyond which a peg edge can run right through a wall unseen by the nearer
/// tests.
const LEANING: f64 = 0.99;

/// Reports the features to `sink`. Families that a peg above the top face cannot have are left
/// out: the peg may be far away, where no bound excludes these families.
pub(super) fn visit_features<S: Sink>(sweep: &FeatureSweep<'_>, sink: &mut S) {
    let mut is_above = true;
    for end in [0.0, sweep.pair.eroded_length] {
        let limit = sink.reach().max(0.0);
        let (middle, spread) =
            (sweep.translation.z + sweep.rotation[(2, 2)] * end, sweep.tilt() * sweep.pair.peg_radius);
        is_above &= middle - spread > 0.0;
        if middle - spread >= limit {
            continue;
        }
        let (lowest, highest) =
            if middle + spread < 0.0 { (middle - spread, middle + spread) } else { sweep.heights(end) };
        if lowest >= limit {
            continue;
        }
        let ring = sweep.ring(end);
        corner_features::corners(sweep, &ring, end, sink);
        if lowest <= 0.0 {
            corner_features::wall_corners(sweep, &ring, end, sink);
        }
        if highest > -sink.reach().max(edge_features::RIM_DEPTH) {
            edge_features::end_edges(sweep, &ring, end, sink);
        }
        if lowest < 0.0 && highest > 0.0 {
            edge_features::pierced_end(sweep, end, sink);
        }
    }
    let rim = sweep.rim();
    corner_features::rim_corners(sweep, &rim, sink);
    let spread = rim.slope.norm() * sweep.pair.hole_radius;
    let is_beside_rim = rim.height + spread >= 0.0 && rim.height - spread <= sweep.pair.eroded_length;
    if !is_above || is_beside_rim {
        corner_features::side_edges(sweep, &rim, sink);
    }
    edge_features::crossing_corners(sweep, sink);
    if sweep.rotation[(2, 2)] < LEANING {
        edge_features::pierced_walls(sweep, sink);
    }
}
