//! The exact contact manifold of parts of known shape.

use nalgebra::Point3;

use super::ball_in_socket::BallInSocket;
use super::contact_manifold::ContactManifold;
use super::peg_in_hole::PegInHole;
use super::plane::Plane;
use super::residual::Residual;
use super::sketch::Shape;
use crate::geometry::{MeshPair, Parts, prisms_of};
use crate::se3::Pose;

/// Most that a peg may overlap the hole's walls (m): tighter fits are pressed in.
const MOST_OVERLAP: f64 = 0.2e-3;
/// Most that a peg's length may be over its hole's depth or its own width, or that width over the
/// length (1): needles, probes and plates are within it, metres taken as millimetres mostly not.
const MOST_RATIO: f64 = 500.0;
/// Points of the peg's axis that are checked.
const AXIS_POINTS: usize = 100;

/// How peg and hole must lie in their frames, as a phrase for error messages that follows
/// "expected": the counterpart of a [`Misfit`] as what was found.
pub const FITTING: &str = "a hole that the peg fits into: rim at z = 0 and bottom below, the peg's tip at z = 0 and the rest above, axes and corners in line";

/// Why a peg does not go into a hole: the peg is tested with its tip at half of the hole's depth
/// and the axes of both frames aligned. The variants display as what was found.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Misfit {
    /// The peg overlaps the walls by this depth (m), more than 0.2 mm.
    #[error("an overlap of {:.1} mm at half of the hole's depth", 1e3 * .0)]
    Overlap(f64),
    /// The body around the hole has material, more than 0.2 mm below its surface, on the part of
    /// the peg's axis that lies inside the peg.
    #[error("a solid where the peg's axis lies")]
    Blocked,
    /// The peg is more than 500 times as long as its hole is deep, or as it is wide, or as wide as
    /// it is long: as in another unit.
    #[error(
        "a peg {:.3} mm wide and {:.3} mm long for a hole {:.3} mm deep: which of these is in another unit?",
        1e3 * .width, 1e3 * .length, 1e3 * .depth
    )]
    Proportions {
        /// Width (m) of the peg: twice the greatest distance of its surface from its axis.
        width: f64,
        /// Length (m) of the peg.
        length: f64,
        /// Depth (m) of the hole.
        depth: f64,
    },
}

/// Contact manifold of parts of known shape: [`PegInHole`], [`BallInSocket`] or [`Plane`]. Nothing
/// is checked; whether a peg fits its hole, [`check_fit`] tells.
pub fn exact_manifold(parts: &Parts) -> Box<dyn ContactManifold> {
    match parts {
        Parts::PegInHole(parts) => Box::new(PegInHole::new(parts.as_ref().clone())),
        Parts::BallInSocket => Box::new(BallInSocket),
        Parts::OnPlane { points, radius } => Box::new(Plane::new(points.clone(), *radius)),
    }
}

/// Manifold of a peg (the tool) that goes `depth` (m, positive) into the body around a hole (the
/// fixture), frames as in [`PegInHoleShapes`](super::peg_in_hole::PegInHoleShapes). It is made of
/// prisms, which is faster, if both meshes are straight along z ([`prisms_of`]), else of the
/// meshes.
///
/// # Errors
/// With the tip at half of `depth`: [`Misfit::Blocked`] if there is material at one of 100 points
/// of the peg's axis, else [`Misfit::Overlap`] as of [`check_fit`].
pub fn peg_in_hole(parts: MeshPair, depth: f64) -> Result<Box<dyn ContactManifold>, Misfit> {
    check_axis(&parts, depth)?;
    let manifold: Box<dyn ContactManifold> = match prisms_of(&parts, depth) {
        Some(shapes) => Box::new(PegInHole::with_depth(shapes, depth)),
        None => Box::new(PegInHole::with_depth(parts, depth)),
    };
    check_fit(manifold.as_ref(), depth)?;
    Ok(manifold)
}

/// Checks a peg and a hole of `depth` (m, positive) by their lengths, and by their signed gap with
/// the tip at half of the depth and the axes of both frames aligned, which is the one row of the
/// manifold's residual. Manifolds with another number of rows pass. Only for a peg in a hole: a
/// [`Plane`] has one row too, of another meaning.
///
/// # Errors
/// [`Misfit::Proportions`] if lengths are as in different units, else
/// [`Misfit::Overlap`] if the gap is below −0.2 mm.
pub fn check_fit(manifold: &dyn ContactManifold, depth: f64) -> Result<(), Misfit> {
    check_proportions(&manifold.sketch().tool, depth)?;
    let mut rows = Residual::new();
    manifold.residual(&Pose::translation(0.0, 0.0, -0.5 * depth), 0.0, &mut rows);
    match rows.values() {
        [gap] if *gap < -MOST_OVERLAP => Err(Misfit::Overlap(-gap)),
        _ => Ok(()),
    }
}

/// Checks the length of a peg against its width and the depth (m) of its hole. Any greater
/// depth is allowed, as of a through hole.
fn check_proportions(peg: &Shape, depth: f64) -> Result<(), Misfit> {
    let Shape::Prism { outline, to: length, .. } = peg else { return Ok(()) };
    let width = 2.0 * outline.iter().map(|vertex| vertex.coords.norm()).fold(0.0, f64::max);
    let is_other_unit = |over: f64, under: f64| under > 0.0 && over > MOST_RATIO * under;
    let is_misfit = is_other_unit(*length, depth) || is_other_unit(*length, width) || is_other_unit(width, *length);
    if is_misfit { Err(Misfit::Proportions { width, length: *length, depth }) } else { Ok(()) }
}

/// Checks that no point of a peg's axis is inside both the peg and the body around the hole, with
/// the peg at half of `depth` (m): walls may be far from there.
fn check_axis(parts: &MeshPair, depth: f64) -> Result<(), Misfit> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Polygon, PrismPair};

    /// A square peg of these lengths (mm): its side, its length, and the depth of its hole.
    fn fit(side: f64, length: f64, depth: f64) -> Result<(), Misfit> {
        let square = |half: f64| {
            let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
            Polygon::new(corners.map(|(x, y)| nalgebra::Point2::new(1e-3 * x, 1e-3 * y)).to_vec()).expect("a square")
        };
        let hole = square(0.5 * side + 0.1);
        let parts = PrismPair::new(square(0.5 * side), 1e-3 * length, hole, 1e-3 * depth).expect("parts");
        check_fit(&PegInHole::new(parts), 1e-3 * depth)
    }

    #[test]
    fn lengths_in_metres_are_no_needles_and_plates() {
        for (side, length, depth) in [(25.0, 40.0, 30.0), (1.0, 250.0, 20.0), (150.0, 0.8, 0.7), (3.0, 20.0, 1000.0)] {
            assert_eq!(fit(side, length, depth), Ok(()), "{side} x {length} in {depth} mm");
        }
        for (side, length, depth) in [(25.0, 40.0, 0.03), (0.025, 40.0, 30.0), (25.0, 0.04, 30.0)] {
            let found = fit(side, length, depth);
            assert!(matches!(found, Err(Misfit::Proportions { .. })), "{side} x {length} in {depth} mm: {found:?}");
        }
    }
}
