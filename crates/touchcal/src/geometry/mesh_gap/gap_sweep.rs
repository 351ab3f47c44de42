//! Signed distances between the features of two meshes at a pose.

use std::cell::Cell;

use nalgebra::Vector3;

use super::edge_pair::{EdgePair, Places};
use super::neighbor_list::NeighborList;
use super::penetration::{EdgeInside, Penetration};
use super::posed_pair::PosedPair;
use super::tolerances::{LEANING, TOUCHING};
use crate::geometry::gap::SignedGap;
use crate::geometry::mesh::{ConvexEdge, LeafPair, MeshFeatures, TriangleMesh};
use crate::se3::{Twist, twist};

/// Distance (m) up to which free bodies are looked at for what is nearest; farther where nothing
/// is.
const NEAR: f64 = 0.1e-3;
/// Distance (m) up to which it is sooner to look than to ask how far corners are.
const NEAR_ENOUGH: f64 = 1e-3;
/// Depth (m) of a corner from which corners alone tell how deep an overlap is.
pub(super) const DEEP: f64 = 2e-3;
/// Distance (m) up to which overlaps are of one place: parts are not so thin.
const ONE_PLACE: f64 = 0.5e-3;
/// How many times as deep as to the surface farther overlaps may be.
const OBLIQUE: f64 = 2.0;
/// Share of an overlap of edges below which a way out past the end of one of them is shorter.
const SHALLOWER: f64 = 0.9;
/// More than what rounding adds to a distance, as a part of it.
const ROUNDING: f64 = 1e-9;
/// Distance (m) beyond which nothing is looked for.
const FAR: f64 = 10.0;

/// A signed distance, the tool's point and the normal from the fixture into the tool, in the
/// fixture frame.
#[derive(Clone, Debug)]
pub(super) struct FeatureDistance {
    pub(super) value: f64,
    point: Vector3<f64>,
    normal: Vector3<f64>,
}

/// The least of all.
pub(super) fn least(found: &[FeatureDistance]) -> Option<&FeatureDistance> {
    found.iter().min_by(|a, b| a.value.total_cmp(&b.value))
}

/// Two bodies at a pose.
pub(super) struct GapSweep<'a> {
    /// The edges of the bodies that are near each other, if they were looked for before.
    known: Option<&'a [LeafPair]>,
    tool: Penetration<'a>,
    fixture: Penetration<'a>,
}

impl<'a> GapSweep<'a> {
    /// Of all, or of what is known to be near.
    pub(super) fn new(tool: PosedPair<'a>, known: Option<&'a NeighborList>) -> Self {
        GapSweep {
            known: known.map(|nearby| &*nearby.edges),
            tool: Penetration::new(tool, known.map(|nearby| &nearby.tool)),
            fixture: Penetration::new(tool.swapped(), known.map(|nearby| &nearby.fixture)),
        }
    }

    /// From the fixture's frame to the tool's.
    #[inline]
    fn in_tool(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.tool.pair.rotation.tr_mul(direction)
    }

    pub(super) fn gradient(&self, found: &FeatureDistance) -> Twist {
        let normal = self.in_tool(&found.normal);
        let point = self.in_tool(&(found.point - self.tool.pair.translation));
        twist(&normal, &point.cross(&normal))
    }

    pub(super) fn signed_gap(&self, found: &FeatureDistance) -> SignedGap {
        let gradient = self.gradient(found);
        let (value, point_in_fixture, normal_in_fixture) = (found.value, found.point.into(), found.normal);
        SignedGap { value, gradient, point_in_fixture, normal_in_fixture }
    }

    /// The signed distance (m) of the deepest corner, zero if none is inside the other body.
    pub(super) fn deepest(&self) -> f64 {
        self.tool.deepest().min(self.fixture.deepest())
    }

    /// The least signed distance; infinite if the bodies are more than 10 m apart.
    pub(super) fn gap(&self) -> SignedGap {
        let nothing = FeatureDistance { value: f64::INFINITY, point: Vector3::zeros(), normal: Vector3::z() };
        self.signed_gap(least(&self.nearest(0.0)).unwrap_or(&nothing))
    }

    /// What is nearest, and all that is at most `margin` (m) farther, among others.
    pub(super) fn nearest(&self, margin: f64) -> Vec<FeatureDistance> {
        let mut reach = NEAR;
        while reach < FAR {
            let found = self.below(reach + margin, margin);
            if least(&found).is_some_and(|least| least.value <= reach) {
                return found;
            }
            // Where nothing is near, as far as the nearest corner; but corners that lean do not
            // touch: the nearest may be none of them.
            let at_least = if reach < NEAR_ENOUGH { 0.0 } else { self.tool.nearest_corner() * (1.0 + ROUNDING) };
            reach = at_least.max(4.0 * reach);
        }
        Vec::new()
    }

    /// What is nearer than `reach` (m), unless it is more than `margin` (m) farther than the
    /// nearest.
    pub(super) fn below(&self, reach: f64, margin: f64) -> Vec<FeatureDistance> {
        let limit = Cell::new(reach);
        let mut kept: Vec<FeatureDistance> = Vec::new();
        let keep = |kept: &mut Vec<FeatureDistance>, found: FeatureDistance| {
            limit.set(limit.get().min(found.value + margin));
            kept.push(found);
        };
        self.tool.corners_on_faces(&limit, &mut |value, point, normal| {
            keep(&mut kept, FeatureDistance { value, point, normal })
        });
        self.fixture.corners_on_faces(&limit, &mut |value, point, normal| {
            let PosedPair { rotation, translation, .. } = &self.tool.pair;
            keep(
                &mut kept,
                FeatureDistance { value, point: rotation * point + translation, normal: -(rotation * normal) },
            );
        });
        if self.deepest() < -DEEP {
            return kept;
        }
        for of_tool in self.tool.edges_within() {
            for of_fixture in self.fixture.edges_within() {
                if let Some(found) = self.overlap(&of_tool, &of_fixture, limit.get()) {
                    keep(&mut kept, found);
                }
            }
        }
        if limit.get() > 0.0 {
            let deepest = least(&kept).map_or(0.0, |least| -least.value.min(0.0));
            let (tool, fixture) = (self.tool.pair.own(), self.fixture.pair.own());
            self.tool.pair.near(self.known, (&tool.edge_tree, &fixture.edge_tree), &limit, |e, f| {
                let (e, f) = (&tool.edges[e as usize], &fixture.edges[f as usize]);
                if let Some(found) = self.free(e, f, limit.get(), deepest) {
                    keep(&mut kept, found);
                }
            });
        }
        kept
    }

    /// Two edges of which a part is inside the other body, where they have passed each other, if
    /// their distance is below `limit` (m).
    fn overlap(
        &self,
        of_tool: &EdgeInside<'_, 'a>,
        of_fixture: &EdgeInside<'_, 'a>,
        limit: f64,
    ) -> Option<FeatureDistance> {
        let lines = self.tool.pair.lines(of_tool.edge, of_fixture.edge);
        let limit = limit.min(-TOUCHING);
        if !lines.are_apart(-limit) {
            return None;
        }
        let (s, t) = lines.nearest()?;
        if !(of_tool.is_inside(s) && of_fixture.is_inside(t)) {
            return None;
        }
        let found = self.crossing(&lines, (s, t)).filter(|found| found.value < limit)?;
        let depth = -found.value;
        // Unless one ends shallower behind a face of the other.
        let behind = |face: &Vector3<f64>, ends: [Vector3<f64>; 2], at: Vector3<f64>| {
            ends.iter().any(|end| face.dot(&(at - end)) >= SHALLOWER * depth)
        };
        let (p, q) = lines.points((s, t));
        let is_overlap = lines.reach((s, t), depth.max(-self.deepest()))
            && lines.of_fixture.normals.iter().all(|face| behind(face, lines.tool_ends, q))
            && lines
                .of_tool
                .normals
                .iter()
                .all(|face| behind(&(self.tool.pair.rotation * face), lines.fixture_ends, p));
        (is_overlap && self.is_one_place(&p, &q)).then_some(found)
    }

    /// Whether a point of the tool inside the fixture and one of the fixture inside the tool are of
    /// one place in the overlap: not much farther from each other than from the surface.
    fn is_one_place(&self, p: &Vector3<f64>, q: &Vector3<f64>) -> bool {
        let apart = (p - q).norm();
        let is_deep =
            |body: &TriangleMesh, point: Vector3<f64>| apart < -OBLIQUE * body.signed_distance(&point.into()).0;
        apart < ONE_PLACE
            || (is_deep(self.fixture.pair.body, *p)
                && is_deep(self.tool.pair.body, self.in_tool(&(q - self.tool.pair.translation))))
    }

    /// Two edges that have not passed each other, if nearer than `limit` (m), where overlaps are as
    /// deep as `deepest` (m).
    fn free(&self, e: &'a ConvexEdge, f: &'a ConvexEdge, limit: f64, deepest: f64) -> Option<FeatureDistance> {
        let lines = self.tool.pair.lines(e, f);
        if lines.are_apart(limit) {
            return None;
        }
        if let Some(places) = lines.nearest() {
            // Past the end of an edge where its body goes on, the other edge is within that body.
            let may_cross = lines.reach(places, deepest) && lines.are_nearer(limit);
            let crossing = if may_cross { self.crossing(&lines, places) } else { None };
            let found = crossing.filter(|found| found.value >= -TOUCHING);
            if found.is_some() || lines.reach(places, 0.0) {
                return found;
            }
        }
        self.end(&lines, lines.nearest_end()).filter(|found| found.value < limit)
    }

    /// Two edges that pass each other at places, along the normal of both, unless a face beside one
    /// of them is nearer.
    fn crossing(&self, lines: &EdgePair<'_>, places: Places) -> Option<FeatureDistance> {
        let normal = lines.normal()?;
        let in_tool = self.in_tool(&normal);
        let (e, f) = (lines.of_tool, lines.of_fixture);
        let side = normal.dot(&(f.normals[0] + f.normals[1])) - in_tool.dot(&(e.normals[0] + e.normals[1]));
        let (normal, in_tool) = if side < 0.0 { (-normal, -in_tool) } else { (normal, in_tool) };
        let leans = e.into.iter().any(|into| into.dot(&in_tool) < -LEANING)
            || f.into.iter().any(|into| into.dot(&normal) > LEANING);
        let (p, q) = lines.points(places);
        (!leans).then(|| FeatureDistance { value: normal.dot(&(p - q)), point: p, normal })
    }

    /// The end of an edge against an edge or another end, at places of which one is 0 or 1.
    fn end(&self, lines: &EdgePair<'_>, (s, t): Places) -> Option<FeatureDistance> {
        let (p, q) = lines.points((s, t));
        let value = (p - q).norm();
        if value <= TOUCHING {
            return None;
        }
        let normal = (p - q) / value;
        let in_tool = self.in_tool(&normal);
        let corner = |features: &'a MeshFeatures, edge: &ConvexEdge, at: f64| -> Option<Option<&'a [Vector3<f64>]>> {
            let end = usize::from(at == 1.0);
            if at > 0.0 && at < 1.0 {
                return Some(None);
            }
            // The corner's directions, if this edge owns_vertex for it.
            let corner = features.corner_at.get(&edge.ends[end]).filter(|_| edge.owns_vertex[end])?;
            Some(Some(features.corners[*corner as usize].along.as_slice()))
        };
        let (e, f) = (lines.of_tool, lines.of_fixture);
        let of_tool = corner(self.tool.pair.own(), e, s)?.unwrap_or(&e.into);
        let of_fixture = corner(self.fixture.pair.own(), f, t)?.unwrap_or(&f.into);
        // Nearest in earnest: the fixture falls away on all sides, and the tool hardly leans.
        let is_nearest = of_fixture.iter().all(|away| away.dot(&normal) <= TOUCHING)
            && of_tool.iter().all(|away| away.dot(&in_tool) >= -LEANING);
        is_nearest.then_some(FeatureDistance { value, point: p, normal })
    }
}
