//! The surfaces of a hole: how candidate contacts are numbered.

use nalgebra::{Point3, Vector3};

use super::hole::Hole;
use crate::geometry::SignedGap;
use crate::manifold::contact_manifold::SurfaceCounts;
use crate::manifold::gate::axis_direction;
use crate::se3::Pose;

/// How near (m) the end of a peg may come to the rim's height before its edges and the rim's take
/// turns in touching.
const AT_RIM: f64 = 0.2e-3;
/// Regions of a hole, by the depth of the tip: a peg that is hardly in leans otherwise than one
/// that is deep in.
const QUARTERS: usize = 4;
/// Surfaces of each region that push in each of six directions, near the peg's tip or at the rim.
const NEARER: usize = 12;
/// With the farther ones of a direction, at either end.
const SURFACES: usize = NEARER + 2;
/// Numbers of regions and surfaces of a hole.
pub(super) const SURFACE_COUNTS: SurfaceCounts = SurfaceCounts { regions: QUARTERS, per_region: SURFACES };

/// Whether the peg's end reaches from below the rim to above it. Edge then rolls over edge, and the
/// features that are near depend on the noise.
pub(super) fn is_at_rim(hole: &Hole, hole_from_peg: &Pose) -> bool {
    let axis = hole_from_peg.rotation * Vector3::z();
    let near = hole.peg_radius * axis.xy().norm() + AT_RIM;
    // Round edges meet where the tip is lower by the sum of their radii.
    (-near - hole.sum_of_edge_radii..near).contains(&hole_from_peg.translation.z)
}

/// Number of the surface that a candidate contact is of, where nearer candidates have `taken` some.
/// The farther of two candidates of one direction and end moves with the nearer one, as alike
/// corners do: that it is free says nothing about how often the nearer one is.
pub(super) fn surface_of(hole: &Hole, gap: &SignedGap, hole_from_peg: &Pose, taken: &[usize]) -> usize {
    let (normal, point) = (gap.normal_in_fixture, gap.point_in_fixture);
    let end = usize::from(is_near_rim(&point, hole_from_peg));
    let depth = (-hole_from_peg.translation.z / hole.depth).clamp(0.0, 1.0);
    let quarter = ((depth * QUARTERS as f64) as usize).min(QUARTERS - 1);
    let first = SURFACES * quarter;
    let surface = first + 2 * axis_direction(&normal) + end;
    if taken.contains(&surface) { first + NEARER + end } else { surface }
}

/// Whether a point of the peg's surface, in the hole's frame, is nearer to the rim than to the
/// peg's tip.
pub(super) fn is_near_rim(point_in_hole: &Point3<f64>, hole_from_peg: &Pose) -> bool {
    point_in_hole.z.abs() < hole_from_peg.inverse_transform_point(point_in_hole).z.abs()
}
