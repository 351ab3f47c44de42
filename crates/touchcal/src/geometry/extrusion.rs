//! The exact signed gap between a straight peg and a straight hole.

use super::blend::{self, Blend, Row};
use super::nearness::Nearness;
use super::profile::{Profile, foot_on_segment};
use super::round::{Round, is_circle};
use super::scan::{Candidate, Scan, Sink};
use crate::se3::{Pose, Twist};
use nalgebra::{Point2, Point3, Vector3};

/// Why a peg and a hole cannot be modelled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExtrusionError {
    /// A length that is not a positive finite number.
    #[error("{what}: expected a positive length in metres, found {found}")]
    Length {
        /// Which length.
        what: &'static str,
        /// The value given (m).
        found: f64,
    },
}

/// The pair of surface elements between which a distance is measured. Indices are those of the
/// profiles.
///
/// A *rim* edge is where a wall meets the top face, a *wall corner* the vertical edge at a hole
/// vertex. The peg has two end faces, the tip at z = 0 and the other at z = length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Feature {
    /// A corner of a peg end against the floor.
    CornerFloor {
        /// Peg vertex.
        peg_vertex: usize,
    },
    /// A corner of a peg end against the top face.
    CornerTop {
        /// Peg vertex.
        peg_vertex: usize,
    },
    /// A corner of a peg end against a wall, or against its rim from above.
    CornerWall {
        /// Peg vertex.
        peg_vertex: usize,
        /// Hole edge.
        hole_edge: usize,
    },
    /// A corner of the rim against a side face of the peg, or against an edge of its end.
    RimCornerSide {
        /// Hole vertex.
        hole_vertex: usize,
        /// Peg edge.
        peg_edge: usize,
    },
    /// A corner of the rim against an end face of the peg.
    RimCornerEnd {
        /// Hole vertex.
        hole_vertex: usize,
    },
    /// A wall corner against an edge of a peg end.
    WallCornerEndEdge {
        /// Hole vertex.
        hole_vertex: usize,
        /// Peg edge.
        peg_edge: usize,
    },
    /// A longitudinal edge of the peg against a rim edge.
    SideEdgeRim {
        /// Peg vertex.
        peg_vertex: usize,
        /// Hole edge.
        hole_edge: usize,
    },
    /// An edge of a peg end against a rim edge.
    EndEdgeRim {
        /// Peg edge.
        peg_edge: usize,
        /// Hole edge.
        hole_edge: usize,
    },
    /// A longitudinal edge of the peg against a wall corner.
    SideEdgeWallCorner {
        /// Peg vertex.
        peg_vertex: usize,
        /// Hole vertex.
        hole_vertex: usize,
    },
}

/// A signed distance between peg and hole, where it is attained and how it changes with the pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// Signed distance (m): positive free, negative penetrating.
    pub value: f64,
    /// `∂value/∂ξ` for `hole_from_peg · Exp(ξ)`, a twist row `[v; ω]`: `[n; p × n]` in the peg
    /// frame.
    pub gradient: Twist,
    /// The point of the peg at which it is attained, in the hole frame.
    pub point_in_hole: Point3<f64>,
    /// Unit normal in the hole frame, from the solid around the hole into the peg: moving the peg
    /// along it opens the gap.
    pub normal_in_hole: Vector3<f64>,
    /// Between what the distance is.
    pub feature: Feature,
}

/// A straight peg and the straight hole it goes into.
///
/// The peg is its outline extruded over `0 ≤ z ≤ length` of the peg frame, its tip face at z = 0.
/// The solid is the half space z ≤ 0 of the hole frame less the hole's outline extruded over
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
/// Edges that are parallel to 1e-12 are left to their end points.
#[derive(Clone, Debug)]
pub struct PegAndHole {
    pub(super) peg: Profile,
    pub(super) length: f64,
    pub(super) hole: Profile,
    pub(super) depth: f64,
    /// Convex vertices of the peg: only these can be nearest to a solid.
    pub(super) peg_corners: Vec<usize>,
    /// Reflex vertices of the hole: the convex corners of the solid.
    pub(super) wall_corners: Vec<usize>,
    /// Convex vertices of the hole, which span its hull.
    pub(super) hole_hull: Vec<usize>,
    pub(super) peg_to_hole: Nearness,
    pub(super) hole_to_peg: Nearness,
    /// The edges of the peg against those of the hole.
    pub(super) edge_to_edge: Nearness,
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
    round: Round,
}

impl PegAndHole {
    /// A peg of `length` (m) and a hole of `depth` (m), outlines in metres in their own frames.
    ///
    /// # Errors
    /// [`ExtrusionError::Length`] if a length is not positive and finite.
    pub fn new(peg: Profile, length: f64, hole: Profile, depth: f64) -> Result<Self, ExtrusionError> {
        for (what, found) in [("peg length", length), ("hole depth", depth)] {
            if !(found > 0.0 && found.is_finite()) {
                return Err(ExtrusionError::Length { what, found });
            }
        }
        let peg_to_hole = Nearness::new(&peg, &hole);
        let hole_to_peg = Nearness::new(&hole, &peg);
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
        let pick = |profile: &Profile, convex: bool| {
            (0..profile.len()).filter(|&i| profile.is_convex_at(i) == convex).collect::<Vec<_>>()
        };
        let wall_corners: Vec<usize> = pick(&hole, false);
        let peg_corners = pick(&peg, true);
        let from_walls = |&i: &usize| wall_corners.iter().map(move |&u| (i, u));
        let apart = |(i, u): (usize, usize)| (hole.vertices()[u] - peg.vertices()[i]).norm();
        let round = Round { peg: is_circle(&peg), hole: is_circle(&hole) };
        let from_axis = |edge: usize| foot_on_segment(&Point2::origin(), hole.edge(edge)).coords.norm();
        Ok(PegAndHole {
            inner_radius: round.hole.then(|| (0..hole.len()).map(from_axis).fold(f64::INFINITY, f64::min)),
            round,
            closest_corners: peg_corners.iter().flat_map(from_walls).map(apart).fold(f64::INFINITY, f64::min),
            peg_radius: peg.bounding_radius(),
            hole_radius: hole.bounding_radius(),
            edge_to_edge: Nearness::of_edges(&peg, &hole),
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

    /// Outline of the peg.
    pub fn peg(&self) -> &Profile {
        &self.peg
    }

    /// Length of the peg (m).
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Outline of the hole.
    pub fn hole(&self) -> &Profile {
        &self.hole
    }

    /// Depth of the hole (m).
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Bounding radius of the peg's outline (m).
    pub fn peg_radius(&self) -> f64 {
        self.peg_radius
    }

    /// Which of their outlines are circles, but for facets.
    pub fn round(&self) -> Round {
        self.round
    }

    /// The signed gap at a pose. Allocates nothing.
    pub fn gap(&self, hole_from_peg: &Pose) -> Gap {
        let scan = Scan::new(self, hole_from_peg);
        scan.gap(&smallest(&scan))
    }

    /// The mean of all features' signed distances `gₖ`, weighted by how near they are to the least
    /// one, and its gradient as in [`Gap::gradient`].
    ///
    /// `Σ wₖ gₖ / Σ wₖ` with `wₖ = exp(−x) (1 − (x/4)²)²`, `x = (gₖ − min g)/temperature` up to 4.
    /// Where the pose is known only to about the temperature (m), the least of several nearly equal
    /// gaps is too small on average (a minimum of noisy numbers), their blend is not; it also
    /// changes smoothly where the minimum jumps from feature to feature. At temperature 0 it is the
    /// gap.
    pub fn blended_gap(&self, hole_from_peg: &Pose, temperature: f64) -> (f64, Twist) {
        let scan = Scan::new(self, hole_from_peg);
        if temperature <= 0.0 {
            let least = smallest(&scan);
            return (least.value, scan.gradient(&least));
        }
        let mut nearest = blend::Nearest::within(blend::REACH * temperature, &scan);
        scan.run(&mut nearest);
        let mut blend = Blend::new(nearest.least, temperature);
        match nearest.kept() {
            Some(kept) => kept.iter().for_each(|row| blend.add(row)),
            None => scan.run(&mut Within {
                reach: nearest.reach(),
                visit: |c: &Candidate| blend.add(&Row { value: c.value, gradient: scan.gradient(c) }),
            }),
        }
        blend.mean()
    }

    /// Calls `visit` for the features whose signed distance exceeds the gap by at most `margin`
    /// (m), in no particular order, and returns the gap. Allocates nothing.
    ///
    /// A corner or edge that penetrates is reported against the nearest face or edge and that one's
    /// neighbours in a corner of the hole.
    pub fn visit_within(&self, hole_from_peg: &Pose, margin: f64, visit: impl FnMut(&Gap)) -> Gap {
        let scan = Scan::new(self, hole_from_peg);
        let gap = scan.gap(&smallest(&scan));
        visit_below(&scan, (gap.value + margin).next_up(), visit);
        gap
    }

    /// Calls `visit` as [`PegAndHole::visit_within`] does, for the features whose signed distance
    /// is below `reach` (m): in one sweep.
    pub fn visit_below(&self, hole_from_peg: &Pose, reach: f64, visit: impl FnMut(&Gap)) {
        visit_below(&Scan::new(self, hole_from_peg), reach, visit);
    }
}

fn visit_below(scan: &Scan, reach: f64, mut visit: impl FnMut(&Gap)) {
    scan.run(&mut Within { reach, visit: |candidate: &Candidate| visit(&scan.gap(candidate)) });
}

/// The least of all distances.
fn smallest(scan: &Scan) -> Candidate {
    let mut nearest = Smallest { best: Candidate::none() };
    scan.run(&mut nearest);
    nearest.best
}

/// Keeps the smallest distance.
struct Smallest {
    best: Candidate,
}

impl Sink for Smallest {
    const ALL: bool = false;

    fn reach(&self) -> f64 {
        self.best.value
    }

    #[inline]
    fn take(&mut self, candidate: Candidate) {
        self.best = candidate;
    }
}

/// Passes every distance below `reach` on.
struct Within<F> {
    reach: f64,
    visit: F,
}

impl<F: FnMut(&Candidate)> Sink for Within<F> {
    const ALL: bool = true;

    fn reach(&self) -> f64 {
        self.reach
    }

    fn take(&mut self, candidate: Candidate) {
        (self.visit)(&candidate);
    }
}
