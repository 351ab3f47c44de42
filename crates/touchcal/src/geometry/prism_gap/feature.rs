//! Pairs of surface elements of a straight peg and a straight hole, and distances between them.

use nalgebra::Vector3;

/// The pair of surface elements of a straight peg and a straight hole between which a distance is
/// measured. Vertices and edges are indices into the outlines
/// [`PrismPair::peg`](super::prism_pair::PrismPair::peg) and
/// [`PrismPair::hole`](super::prism_pair::PrismPair::hole), edge `i` from vertex `i` to the next.
///
/// A *rim* edge is where a wall meets the top face, a *wall corner* the vertical edge at a hole
/// vertex. The peg has two end faces, the tip at z = 0 and the other at z = length. Where edges are
/// round these are the elements of the sharp parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Feature {
    /// A corner of a peg end against the floor (z = −depth) of the hole.
    CornerFloor {
        /// Index of the vertex of the peg's outline.
        peg_vertex: usize,
    },
    /// A corner of a peg end against the top face (z = 0) of the body around the hole.
    CornerTop {
        /// Index of the vertex of the peg's outline.
        peg_vertex: usize,
    },
    /// A corner of a peg end against a wall, or against its rim from above.
    CornerWall {
        /// Index of the vertex of the peg's outline.
        peg_vertex: usize,
        /// Index of the edge of the hole's outline.
        hole_edge: usize,
    },
    /// A corner of the rim against a side face of the peg, or against an edge of its end.
    RimCornerSide {
        /// Index of the vertex of the hole's outline.
        hole_vertex: usize,
        /// Index of the edge of the peg's outline.
        peg_edge: usize,
    },
    /// A corner of the rim against an end face of the peg.
    RimCornerEnd {
        /// Index of the vertex of the hole's outline.
        hole_vertex: usize,
    },
    /// A wall corner against an edge of a peg end.
    WallCornerEndEdge {
        /// Index of the vertex of the hole's outline.
        hole_vertex: usize,
        /// Index of the edge of the peg's outline.
        peg_edge: usize,
    },
    /// A longitudinal edge of the peg against a rim edge.
    SideEdgeRim {
        /// Index of the vertex of the peg's outline at which the longitudinal edge lies.
        peg_vertex: usize,
        /// Index of the edge of the hole's outline.
        hole_edge: usize,
    },
    /// An edge of a peg end against a rim edge.
    EndEdgeRim {
        /// Index of the edge of the peg's outline.
        peg_edge: usize,
        /// Index of the edge of the hole's outline.
        hole_edge: usize,
    },
    /// A longitudinal edge of the peg against a wall corner.
    SideEdgeWallCorner {
        /// Index of the vertex of the peg's outline at which the longitudinal edge lies.
        peg_vertex: usize,
        /// Index of the vertex of the hole's outline.
        hole_vertex: usize,
    },
}

/// A signed distance. `normal` points from the solid into the peg, `point` lies on the peg; both
/// are in the peg frame if `in_peg`, else in the hole frame.
#[derive(Clone, Debug)]
pub(super) struct FeatureDistance {
    pub(super) value: f64,
    pub(super) point: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
    pub(super) in_peg: bool,
    pub(super) feature: Feature,
}

impl FeatureDistance {
    /// Farther than anything.
    pub(super) const fn none() -> Self {
        FeatureDistance {
            value: f64::INFINITY,
            point: Vector3::new(0.0, 0.0, 0.0),
            normal: Vector3::new(0.0, 0.0, 1.0),
            in_peg: false,
            feature: Feature::CornerFloor { peg_vertex: 0 },
        }
    }
}

impl FeatureDistance {
    /// This overlap, or the one ended by moving the peg's `point` by `out` (hole frame) if that is
    /// shorter.
    pub(super) fn or_shallower(self, point: Vector3<f64>, out: Vector3<f64>, feature: Feature) -> Self {
        let distance = out.norm();
        if self.value < 0.0 && distance >= -self.value {
            return self;
        }
        let normal = if distance > 0.0 { out / distance } else { Vector3::z() };
        FeatureDistance { value: -distance, point, normal, in_peg: false, feature }
    }
}

/// Receives distances of a sweep.
pub(super) trait Sink {
    /// Whether near misses are wanted, or only the smallest.
    const ALL: bool;
    /// Distances from here on are of no interest.
    fn reach(&self) -> f64;
    /// Receives a distance below [`Sink::reach`].
    fn take(&mut self, candidate: FeatureDistance);
}
