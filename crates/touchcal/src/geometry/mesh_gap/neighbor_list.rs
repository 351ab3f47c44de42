//! Neighbour (Verlet) lists: pairs of features that are near each other, found once for all poses
//! nearby (Verlet, *Computer "experiments" on classical fluids*, 1967).

use std::cell::Cell;
use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{Matrix3, Vector3};

use super::posed_pair::PosedPair;
use super::tolerances::PAST_EDGE;
use crate::geometry::mesh::LeafPair;

/// Distance that points may move before a new search, as a share of the cutoff.
const SKIN: f64 = 0.1;
/// Most pairs that are kept, so that a contact takes no more than 16 KB; a larger list is made anew
/// each time.
const MAX_PAIRS: usize = 2000;
/// A list whose cutoff exceeds the one asked for by more than this factor is made smaller.
const MAX_EXCESS: f64 = 2.0;
/// More than what rounding adds to distances (m).
const ROUNDING: f64 = 1e-9;

/// Pairs of features of a tool and a fixture that are within a cutoff of each other at a reference
/// pose, or at any pose that moves no point of the tool by more than the skin, a tenth of the
/// cutoff (Verlet, *Computer "experiments" on classical fluids*, 1967). Made and used by
/// [`GapQuery::visit_below`](crate::geometry::GapQuery::visit_below), which keeps at most 16 KB.
#[derive(Clone, Debug)]
pub struct NeighborList {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    /// Distance (m) that points may be from their places at the reference pose.
    skin: f64,
    /// Distance (m) up to which all pairs are in the list at the reference pose.
    cutoff: f64,
    pub(super) tool: OnFaces,
    pub(super) fixture: OnFaces,
    /// Edges of the tool, and those of the fixture that they are near.
    pub(super) edges: Box<[LeafPair]>,
}

/// What of a body is near the faces of another.
#[derive(Clone, Debug)]
pub(super) struct OnFaces {
    /// Edges, and faces that they may pierce.
    pub(super) edges: Box<[LeafPair]>,
    /// Corners, and faces.
    pub(super) corners: Box<[LeafPair]>,
}

impl OnFaces {
    /// Among what is `known` to be near, if that was looked for before.
    fn new(body: &PosedPair<'_>, known: Option<&OnFaces>, (skin, cutoff): (f64, f64)) -> Self {
        let (own, others) = (body.own(), body.others());
        let mut edges = Vec::new();
        let known_edges = known.map(|known| &*known.edges);
        body.near(known_edges, (&own.edge_tree, &others.face_tree), &Cell::new(skin), |edge, face| {
            if others.faces[face as usize].may_be_pierced(body.ends(edge), skin) {
                edges.push((edge, face));
            }
        });
        let mut corners = Vec::new();
        let known_corners = known.map(|known| &*known.corners);
        body.near(known_corners, (&own.corner_tree, &others.face_tree), &Cell::new(cutoff), |corner, face| {
            let point = body.vertex(own.corners[corner as usize].vertex);
            if others.faces[face as usize].may_be_near(&point, skin, cutoff) {
                corners.push((corner, face));
            }
        });
        OnFaces { edges: ordered(edges), corners: ordered(corners) }
    }
}

/// Pairs in an order that does not depend on the pose.
fn ordered(mut pairs: Vec<LeafPair>) -> Box<[LeafPair]> {
    pairs.sort_unstable();
    pairs.into()
}

impl NeighborList {
    /// A list with all pairs nearer than `reach` (m) at a pose: that of the `cache` if it covers
    /// the pose, else a new one.
    pub(super) fn at<'r>(
        cache: &'r mut Option<Box<NeighborList>>,
        tool: &PosedPair<'_>,
        reach: f64,
    ) -> &'r NeighborList {
        // A foot may be a little past two sides of a hollow corner: with this much more, of any
        // that is wider than some degrees.
        let (reach, skin) = (reach.max(0.0) * (1.0 + PAST_EDGE), SKIN * reach.max(0.0));
        let nearby = match cache.take() {
            Some(before) if before.cutoff <= MAX_EXCESS * reach && before.covers(tool, 0.0, reach) => before,
            before => {
                let known = before.filter(|before| before.covers(tool, skin, reach + skin));
                Box::new(NeighborList::new(tool, known.as_deref(), (skin, reach + skin)))
            }
        };
        cache.insert(nearby)
    }

    /// All that is nearer than `cutoff` (m), or may pierce within `skin` (m); among what is
    /// `known`, if that was looked for before.
    fn new(tool: &PosedPair<'_>, known: Option<&NeighborList>, (skin, cutoff): (f64, f64)) -> Self {
        let limits = (skin + ROUNDING, cutoff + ROUNDING);
        let (own, others) = (tool.own(), tool.others());
        let mut edges = Vec::new();
        let known_edges = known.map(|known| &*known.edges);
        tool.near(known_edges, (&own.edge_tree, &others.edge_tree), &Cell::new(limits.1), |e, f| {
            if tool.lines(&own.edges[e as usize], &others.edges[f as usize]).are_nearer(limits.1) {
                edges.push((e, f));
            }
        });
        NeighborList {
            rotation: tool.rotation,
            translation: tool.translation,
            skin,
            cutoff,
            tool: OnFaces::new(tool, known.map(|known| &known.tool), limits),
            fixture: OnFaces::new(&tool.swapped(), known.map(|known| &known.fixture), limits),
            edges: ordered(edges),
        }
    }

    /// Whether it is small enough to be kept.
    pub(super) fn is_small(&self) -> bool {
        let of_faces = |body: &OnFaces| body.edges.len() + body.corners.len();
        of_faces(&self.tool) + of_faces(&self.fixture) + self.edges.len() <= MAX_PAIRS
    }

    /// Whether it has all that is nearer than `cutoff` (m) beside a tool there, or may pierce
    /// within `skin` (m).
    fn covers(&self, tool: &PosedPair<'_>, skin: f64, cutoff: f64) -> bool {
        let turned = tool.rotation - self.rotation;
        let (middle, radius) = tool.own().around;
        // A difference of rotations stretches nothing by more than its norm over √2. What is near
        // the tool is hardly farther out.
        let moved = (turned * middle + tool.translation - self.translation).norm()
            + turned.norm() * FRAC_1_SQRT_2 * (radius + self.cutoff);
        moved + skin <= self.skin && moved + cutoff <= self.cutoff
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::geometry::TriangleMesh;

    /// A body of corners on a cube of 20 mm.
    fn cube() -> TriangleMesh {
        let corner = |k: u32| Point3::from([k & 1, k >> 1 & 1, k >> 2].map(|side| 0.02 * f64::from(side)));
        let corners: Vec<Point3<f64>> = (0..8).map(corner).collect();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        TriangleMesh::new(&corners, &triangles).expect("a cube")
    }

    #[test]
    fn what_was_near_is_kept_until_it_may_not_be() {
        let (body, other) = (cube(), cube());
        let above = |turn: f64, height: f64| PosedPair {
            body: &body,
            other: &other,
            rotation: *nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), turn).matrix(),
            translation: Vector3::new(0.0, 0.0, 0.02 + height),
        };
        let mut cache = None;
        let mut searched_at = |turn: f64, height: f64, reach: f64| {
            let nearby = NeighborList::at(&mut cache, &above(turn, height), reach);
            (nearby.translation.z - 0.02, nearby.tool.corners.len())
        };
        let (_, count) = searched_at(0.0, 50e-6, 100e-6);
        assert!(count >= 4, "four corners over the other's upper side: {count}");
        let at = |found: (f64, usize)| (found.0 * 1e6).round();
        assert_eq!(at(searched_at(0.0, 55e-6, 100e-6)), 50.0, "5 µm are within the skin of 10 µm");
        assert_eq!(at(searched_at(1e-4, 50e-6, 100e-6)), 50.0, "2 µm at 20 mm");
        assert_eq!(at(searched_at(0.0, 61e-6, 100e-6)), 61.0, "11 µm are not");
        assert_eq!(at(searched_at(1e-3, 61e-6, 100e-6)), 61.0);
        assert_eq!(at(searched_at(0.0, 62e-6, 100e-6)), 62.0, "turned back by 1 mrad");
        assert_eq!(at(searched_at(0.0, 63e-6, 120e-6)), 63.0, "farther than was looked");
        assert_eq!(at(searched_at(0.0, 64e-6, 90e-6)), 63.0, "not much less far");
        let narrow = searched_at(0.0, 64e-6, 10e-6);
        assert_eq!((at(narrow), narrow.1), (64.0, 0), "much less far: nothing is left");
    }
}
