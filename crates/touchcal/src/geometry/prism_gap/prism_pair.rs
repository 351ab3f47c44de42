//! The exact signed gap between a straight peg and a straight hole.

use super::vertex_edge_bounds::VertexEdgeBounds;
use crate::geometry::polygon::{Polygon, foot_on_segment};
use crate::geometry::recognize::AxialSymmetry;
use crate::geometry::recognize::is_circle;
use nalgebra::Point2;

/// Why no [`PrismPair`] can be made of outlines and lengths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrismPairError {
    /// A length that is not a positive finite number; the peg's is checked first.
    #[error("{what}: expected a positive length in metres, found {found}")]
    Length {
        /// Name of the length: "peg length" or "hole depth".
        what: &'static str,
        /// The value given (m).
        found: f64,
    },
}

/// A straight peg and the straight hole it goes into.
///
/// The peg is its outline extruded over `0 ≤ z ≤ length` of the peg frame, its tip face at z = 0.
/// The solid is the half space z ≤ 0 of the hole frame without the hole's outline extruded over
/// `−depth ≤ z ≤ 0`; it extends sideways without limit.
///
/// # Signed gap
/// The minimum over features of signed distances. Outside contact it is the distance between the
/// two bodies, at any pose. The distance of each feature that can be in contact (corner against
/// face, edge against edge) passes through zero with an unchanged slope, so poses scattered about a
/// contact see no kink. Deeper, it measures how far a corner or edge lies beyond the nearest face
/// or edge; it is negative exactly when the bodies overlap.
///
/// # Numerics
/// Edges that are parallel to 1e-12 are represented by their end points.
#[derive(Clone, Debug)]
pub struct PrismPair {
    pub(super) peg: Polygon,
    pub(super) length: f64,
    pub(super) hole: Polygon,
    pub(super) depth: f64,
    /// Convex vertices of the peg: only these can be nearest to a solid.
    pub(super) peg_corners: Vec<usize>,
    /// Reflex vertices of the hole: the convex corners of the solid.
    pub(super) wall_corners: Vec<usize>,
    /// Convex vertices of the hole, which span its hull.
    pub(super) hole_hull: Vec<usize>,
    pub(super) peg_to_hole: VertexEdgeBounds,
    pub(super) hole_to_peg: VertexEdgeBounds,
    /// The edges of the peg against those of the hole.
    pub(super) edge_to_edge: VertexEdgeBounds,
    /// Signed distance (m) of each peg vertex from the walls when aligned, positive inside the
    /// hole.
    pub(super) peg_clearance: Vec<f64>,
    /// Signed distance (m) of each hole vertex from the peg when aligned, positive outside the peg.
    pub(super) hole_clearance: Vec<f64>,
    /// Least distance (m) between corners of the peg and of the walls when aligned.
    pub(super) closest_corners: f64,
    /// Bounding radius of the peg's outline (m).
    pub(super) peg_radius: f64,
    /// And of the hole's.
    pub(super) hole_radius: f64,
    /// Radius (m) of the circle that a round hole holds.
    pub(super) inner_radius: Option<f64>,
    symmetry: AxialSymmetry,
}

impl PrismPair {
    /// A peg of `length` (m) and a hole of `depth` (m), outlines in x and y of their own frames
    /// (m). Whether the peg fits the hole is not checked.
    ///
    /// # Errors
    /// [`PrismPairError::Length`] if a length is not positive and finite.
    pub fn new(peg: Polygon, length: f64, hole: Polygon, depth: f64) -> Result<Self, PrismPairError> {
        for (what, found) in [("peg length", length), ("hole depth", depth)] {
            if !(found > 0.0 && found.is_finite()) {
                return Err(PrismPairError::Length { what, found });
            }
        }
        let peg_to_hole = VertexEdgeBounds::new(&peg, &hole);
        let hole_to_peg = VertexEdgeBounds::new(&hole, &peg);
        let clearance = |inside: bool, distance: f64| if inside { distance } else { -distance };
        let peg_clearance = peg
            .vertices()
            .iter()
            .enumerate()
            .map(|(i, p)| clearance(hole.contains(p), peg_to_hole.closest(i)))
            .collect();
        let hole_clearance = hole
            .vertices()
            .iter()
            .enumerate()
            .map(|(i, p)| clearance(!peg.contains(p), hole_to_peg.closest(i)))
            .collect();
        let pick = |profile: &Polygon, convex: bool| {
            (0..profile.len()).filter(|&i| profile.is_convex_at(i) == convex).collect::<Vec<_>>()
        };
        let wall_corners: Vec<usize> = pick(&hole, false);
        let peg_corners = pick(&peg, true);
        let from_walls = |&i: &usize| wall_corners.iter().map(move |&u| (i, u));
        let apart = |(i, u): (usize, usize)| (hole.vertices()[u] - peg.vertices()[i]).norm();
        let symmetry = AxialSymmetry { peg: is_circle(&peg), hole: is_circle(&hole) };
        let from_axis = |edge: usize| foot_on_segment(&Point2::origin(), hole.edge(edge)).coords.norm();
        Ok(PrismPair {
            inner_radius: symmetry.hole.then(|| (0..hole.len()).map(from_axis).fold(f64::INFINITY, f64::min)),
            symmetry,
            closest_corners: peg_corners.iter().flat_map(from_walls).map(apart).fold(f64::INFINITY, f64::min),
            peg_radius: peg.bounding_radius(),
            hole_radius: hole.bounding_radius(),
            edge_to_edge: VertexEdgeBounds::of_edges(&peg, &hole),
            peg_corners,
            wall_corners,
            hole_hull: pick(&hole, true),
            peg,
            length,
            hole,
            depth,
            peg_to_hole,
            hole_to_peg,
            peg_clearance,
            hole_clearance,
        })
    }

    /// Outline of the peg in x and y of the peg frame (m).
    pub fn peg(&self) -> &Polygon {
        &self.peg
    }

    /// Length of the peg (m): its end faces are at z = 0 and z = length of the peg frame.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Outline of the hole in x and y of the hole frame (m).
    pub fn hole(&self) -> &Polygon {
        &self.hole
    }

    /// Depth of the hole (m): its floor is at z = −depth of the hole frame.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Largest distance (m) of the peg's outline from the z axis of the peg.
    pub fn peg_radius(&self) -> f64 {
        self.peg_radius
    }

    /// Whether the outlines of peg and hole are circles about the z axis of their frame, up to
    /// facets; see [`AxialSymmetry`] for the tolerances.
    pub fn symmetry(&self) -> AxialSymmetry {
        self.symmetry
    }
}
