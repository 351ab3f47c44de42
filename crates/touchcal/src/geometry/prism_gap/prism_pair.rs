//! The exact signed gap between a straight peg and a straight hole.

use super::vertex_edge_bounds::VertexEdgeBounds;
use crate::geometry::polygon::{Polygon, foot_on_segment};
use crate::geometry::recognize::AxialSymmetry;
use crate::geometry::recognize::is_circle;
use nalgebra::Point2;
use serde::{Deserialize, Serialize};

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
    /// An edge radius that is negative, not finite, or too large for the part.
    #[error(
        "edge radius of the {part}: expected 0 or more, and small enough for each edge of its outline and for its length or depth, in metres, found {found}"
    )]
    EdgeRadius {
        /// Name of the part: "peg" or "hole".
        part: &'static str,
        /// The value given (m).
        found: f64,
    },
}

/// Radii (m) to which edges of a peg and of the solid around its hole are rounded; 0 for sharp
/// ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EdgeRadii {
    /// Radius of all edges of the peg at which it is convex, among them those of its ends.
    pub peg: f64,
    /// Radius of all edges at which the solid around the hole is convex, among them the rim.
    pub hole: f64,
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
/// # Round edges
/// With [edge radii](EdgeRadii) each body is its opening by a ball of that radius: eroded by it,
/// then dilated (Serra, *Image Analysis and Mathematical Morphology*, 1982, chapter II). Here a
/// prism is eroded to the prism of the mitred offset of its outline: at concave corners that is
/// dilated to the same body. The distance between two dilated bodies is that of the eroded ones
/// less both radii, so that the gap is as exact as that of sharp edges.
///
/// # Numerics
/// Edges that are parallel to 1e-12 are represented by their end points.
#[derive(Clone, Debug)]
pub struct PrismPair {
    peg: Polygon,
    length: f64,
    hole: Polygon,
    /// Depth of the hole (m), the same after erosion.
    pub(super) depth: f64,
    pub(super) edge_radii: EdgeRadii,
    /// Outline of the eroded peg.
    pub(super) eroded_peg: Polygon,
    /// Length of the eroded peg (m).
    pub(super) eroded_length: f64,
    /// Outline of the hole in the eroded solid.
    pub(super) eroded_hole: Polygon,
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
    /// Bounding radius of the eroded peg's outline (m).
    pub(super) peg_radius: f64,
    /// Bounding radius of the outline of the hole in the eroded solid (m).
    pub(super) hole_radius: f64,
    /// Radius (m) of the circle that a round hole in the eroded solid holds.
    pub(super) inner_radius: Option<f64>,
    symmetry: AxialSymmetry,
}

impl PrismPair {
    /// A peg of `length` (m) and a hole of `depth` (m) with sharp edges, outlines in x and y of
    /// their own frames (m). Whether the peg fits the hole is not checked.
    ///
    /// # Errors
    /// [`PrismPairError::Length`] if a length is not positive and finite.
    pub fn new(peg: Polygon, length: f64, hole: Polygon, depth: f64) -> Result<Self, PrismPairError> {
        PrismPair::build((peg, length), (hole, depth), EdgeRadii::default())
    }

    /// The same peg and hole with edges of these radii, in place of the former.
    ///
    /// # Errors
    /// [`PrismPairError::EdgeRadius`] if a radius is negative, not finite, or not below half of the
    /// peg's length, the hole's depth, and the length of each edge of the outline between a convex
    /// and a concave corner; or if another edge shrinks to nothing, as those of a fillet do whose
    /// radius is smaller.
    pub fn with_edge_radii(&self, edge_radii: EdgeRadii) -> Result<Self, PrismPairError> {
        if edge_radii == self.edge_radii {
            return Ok(self.clone());
        }
        PrismPair::build((self.peg.clone(), self.length), (self.hole.clone(), self.depth), edge_radii)
    }

    /// The same peg in another hole, of `depth` (m); both have the edge radii of this pair.
    ///
    /// # Errors
    /// As [`PrismPair::new`] and [`PrismPair::with_edge_radii`].
    pub fn with_hole(&self, hole: Polygon, depth: f64) -> Result<Self, PrismPairError> {
        PrismPair::build((self.peg.clone(), self.length), (hole, depth), self.edge_radii)
    }

    fn build(
        (peg, length): (Polygon, f64),
        (hole, depth): (Polygon, f64),
        edge_radii: EdgeRadii,
    ) -> Result<Self, PrismPairError> {
        for (what, found) in [("peg length", length), ("hole depth", depth)] {
            if !(found > 0.0 && found.is_finite()) {
                return Err(PrismPairError::Length { what, found });
            }
        }
        let EdgeRadii { peg: peg_edge, hole: hole_edge } = edge_radii;
        let eroded_length = length - 2.0 * peg_edge;
        let eroded_peg = eroded(&peg, peg_edge, -1.0).filter(|_| eroded_length > 0.0);
        let eroded_peg = eroded_peg.ok_or(PrismPairError::EdgeRadius { part: "peg", found: peg_edge })?;
        let eroded_hole = eroded(&hole, hole_edge, 1.0).filter(|_| hole_edge < depth);
        let eroded_hole = eroded_hole.ok_or(PrismPairError::EdgeRadius { part: "hole", found: hole_edge })?;
        let peg_to_hole = VertexEdgeBounds::new(&eroded_peg, &eroded_hole);
        let hole_to_peg = VertexEdgeBounds::new(&eroded_hole, &eroded_peg);
        let signed = |(i, is_apart): (usize, bool), bounds: &VertexEdgeBounds| {
            if is_apart { bounds.closest(i) } else { -bounds.closest(i) }
        };
        let of_peg = eroded_peg.vertices().iter().map(|p| eroded_hole.contains(p)).enumerate();
        let of_hole = eroded_hole.vertices().iter().map(|p| !eroded_peg.contains(p)).enumerate();
        let pick = |profile: &Polygon, convex: bool| {
            (0..profile.len()).filter(|&i| profile.is_convex_at(i) == convex).collect::<Vec<_>>()
        };
        let wall_corners: Vec<usize> = pick(&eroded_hole, false);
        let peg_corners = pick(&eroded_peg, true);
        let from_walls = |&i: &usize| wall_corners.iter().map(move |&u| (i, u));
        let apart = |(i, u): (usize, usize)| (eroded_hole.vertices()[u] - eroded_peg.vertices()[i]).norm();
        let symmetry = AxialSymmetry { peg: is_circle(&peg), hole: is_circle(&hole) };
        let from_axis = |edge: usize| foot_on_segment(&Point2::origin(), eroded_hole.edge(edge)).coords.norm();
        Ok(PrismPair {
            inner_radius: symmetry.hole.then(|| (0..eroded_hole.len()).map(from_axis).fold(f64::INFINITY, f64::min)),
            symmetry,
            closest_corners: peg_corners.iter().flat_map(from_walls).map(apart).fold(f64::INFINITY, f64::min),
            peg_radius: eroded_peg.bounding_radius(),
            hole_radius: eroded_hole.bounding_radius(),
            edge_to_edge: VertexEdgeBounds::of_edges(&eroded_peg, &eroded_hole),
            peg_clearance: of_peg.map(|vertex| signed(vertex, &peg_to_hole)).collect(),
            hole_clearance: of_hole.map(|vertex| signed(vertex, &hole_to_peg)).collect(),
            peg_corners,
            wall_corners,
            hole_hull: pick(&eroded_hole, true),
            peg,
            length,
            hole,
            depth,
            edge_radii,
            eroded_peg,
            eroded_length,
            eroded_hole,
            peg_to_hole,
            hole_to_peg,
        })
    }

    /// Outline of the peg in x and y of the peg frame (m), with sharp edges.
    pub fn peg(&self) -> &Polygon {
        &self.peg
    }

    /// Length of the peg (m): its end faces are at z = 0 and z = length of the peg frame.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Outline of the hole in x and y of the hole frame (m), with sharp edges.
    pub fn hole(&self) -> &Polygon {
        &self.hole
    }

    /// Depth of the hole (m): its floor is at z = −depth of the hole frame.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Radii to which edges are rounded.
    pub fn edge_radii(&self) -> EdgeRadii {
        self.edge_radii
    }

    /// Largest distance (m) of the peg's outline, with sharp edges, from the z axis of the peg.
    pub fn peg_radius(&self) -> f64 {
        self.peg.bounding_radius()
    }

    /// Whether the outlines of peg and hole are circles about the z axis of their frame, up to
    /// facets; see [`AxialSymmetry`] for the tolerances.
    pub fn symmetry(&self) -> AxialSymmetry {
        self.symmetry
    }
}

/// The outline (m) of a body after erosion by a ball of `radius` (m): moved outwards with `sign` 1,
/// of a hole, and inwards with −1. `None` if the radius is negative, not finite, or too large for
/// an edge.
fn eroded(outline: &Polygon, radius: f64, sign: f64) -> Option<Polygon> {
    if radius == 0.0 {
        return Some(outline.clone());
    }
    // An edge from a convex to a concave corner keeps its length when moved; the round of the
    // convex one must end on it.
    let is_long = |i: usize| {
        let (a, b) = outline.edge(i);
        outline.is_convex_at(i) == outline.is_convex_at((i + 1) % outline.len()) || (b - a).norm() > radius
    };
    let has_room = radius > 0.0 && (0..outline.len()).all(is_long);
    outline.offset_mitred(sign * radius).ok().filter(|_| has_room)
}
