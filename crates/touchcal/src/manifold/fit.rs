//! Whether a peg goes into a hole as they lie in their frames.

use nalgebra::Point3;

use super::{ContactManifold, Rows};
use crate::geometry::solids::Solids;
use crate::se3::Pose;

/// Most that a peg may overlap the hole's walls (m): tighter fits are pressed in.
const MOST_OVERLAP: f64 = 0.2e-3;
/// Points of the peg's axis that are looked at.
const AXIS_POINTS: usize = 100;

/// How peg and hole must lie in their frames.
pub const FITTING: &str = "a hole that the peg fits into: rim at z = 0 and bottom below, the peg's tip at z = 0 and the rest above, axes and corners in line";

/// A peg that is another one than that of the hole, or lies otherwise in its frame; what is wrong
/// with it at half of the hole's depth, frames together.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Misfit {
    /// It overlaps the hole's walls by so much (m).
    #[error("an overlap of {:.1} mm at half of the hole's depth", 1e3 * .0)]
    Overlap(f64),
    /// Its axis is inside of the hole's body.
    #[error("a solid where the peg's axis lies")]
    Blocked,
}

/// Checks a peg and a hole of `depth` (m) by their gap, the one row of the manifold's residual;
/// manifolds with more rows pass.
pub fn check(manifold: &dyn ContactManifold, depth: f64) -> Result<(), Misfit> {
    let mut rows = Rows::new();
    manifold.residual(&Pose::translation(0.0, 0.0, -0.5 * depth), 0.0, &mut rows);
    match rows.values() {
        [gap] if *gap < -MOST_OVERLAP => Err(Misfit::Overlap(-gap)),
        _ => Ok(()),
    }
}

/// Checks that nowhere the axis of a peg (the tool) is inside both of it and of the body around a
/// hole of `depth` (m): walls may be far from there.
pub(super) fn check_axis(parts: &Solids, depth: f64) -> Result<(), Misfit> {
    let (peg, hole) = (parts.tool(), parts.fixture());
    let heights = || peg.vertices().map(|vertex| vertex.z);
    let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    let mut along = (0..AXIS_POINTS).map(|k| low + (high - low) * (k as f64 + 0.5) / AXIS_POINTS as f64);
    let blocked = along.any(|z| {
        let (of_peg, of_hole) = (Point3::new(0.0, 0.0, z), Point3::new(0.0, 0.0, z - 0.5 * depth));
        peg.signed_distance(&of_peg).0 < 0.0 && hole.signed_distance(&of_hole).0 < -MOST_OVERLAP
    });
    if blocked { Err(Misfit::Blocked) } else { Ok(()) }
}
