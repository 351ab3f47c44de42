//! The signed gap between two bodies of any shape.

use std::cell::Cell;

use nalgebra::{Point3, Vector3};

use super::beside::Beside;
use super::blend::{self, Blend, Row};
use super::facets::{Edge, Facets};
use super::lines::{Lines, Places};
use super::nearby::{Nearby, Pair};
use super::placed::{LEANING, Placed, TOUCHING, Within};
use super::solid::Solid;
use crate::se3::{Pose, Twist, twist};

/// Distance (m) up to which free bodies are looked at for what is nearest; farther where nothing
/// is.
const NEAR: f64 = 0.1e-3;
/// Distance (m) up to which it is sooner to look than to ask how far corners are.
const NEAR_ENOUGH: f64 = 1e-3;
/// Depth (m) of a corner from which corners alone tell how deep an overlap is.
const DEEP: f64 = 2e-3;
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

/// A signed distance between tool and fixture, where it is attained and how it changes with the
/// pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// Signed distance (m): positive free, negative penetrating.
    pub value: f64,
    /// `∂value/∂ξ` for `fixture_from_tool · Exp(ξ)`, a twist row `[v; ω]`: `[n; p × n]` in the tool
    /// frame.
    pub gradient: Twist,
    /// The point of the tool at which it is attained, in the fixture frame.
    pub point_in_fixture: Point3<f64>,
    /// Unit normal in the fixture frame, from the fixture into the tool: moving the tool along it
    /// opens the gap.
    pub normal_in_fixture: Vector3<f64>,
}

/// Two bodies, of which one touches the other.
///
/// # Signed gap
/// The least of signed distances between what can touch: corners of one against faces of the other,
/// edges against edges. Outside contact it is the distance between the bodies. In contact each
/// distance passes through zero with an unchanged slope, and below measures how far a corner lies
/// beyond the nearest faces, or an edge beyond an edge.
///
/// What overlaps is found from the edges of one body that pierce the surface of the other: from
/// where they end inside, along edges that do not pierce, to all corners inside, as deep as their
/// signed distance ([`Solid::signed_distance`]); and between the edges of both bodies of which a
/// part is inside. Where a corner is more than 2 mm inside, edges are left out.
#[derive(Clone, Debug)]
pub struct Solids {
    tool: Solid,
    fixture: Solid,
}

impl Solids {
    /// A tool and what it touches, each in its own frame.
    pub fn new(tool: Solid, fixture: Solid) -> Self {
        Solids { tool, fixture }
    }

    /// The tool.
    pub fn tool(&self) -> &Solid {
        &self.tool
    }

    /// What it touches.
    pub fn fixture(&self) -> &Solid {
        &self.fixture
    }

    /// The signed gap at a pose. Infinite if the bodies are more than 10 m apart.
    pub fn gap(&self, fixture_from_tool: &Pose) -> Touch {
        Sweep::new(self.tool_beside_fixture(fixture_from_tool), None).gap()
    }

    /// The mean of the distances that are nearly the least, and its gradient, as
    /// [`PegAndHole::blended_gap`](super::extrusion::PegAndHole::blended_gap) has it.
    pub fn blended_gap(&self, fixture_from_tool: &Pose, temperature: f64) -> (f64, Twist) {
        let sweep = Sweep::new(self.tool_beside_fixture(fixture_from_tool), None);
        let found = if temperature > 0.0 { sweep.nearest(blend::REACH * temperature) } else { Vec::new() };
        let Some(least) = least(&found) else {
            let gap = sweep.gap();
            return (gap.value, gap.gradient);
        };
        let row = |found: &Found| Row { value: found.value, gradient: sweep.gradient(found) };
        let mut blend = Blend::new(row(least), temperature);
        found.iter().for_each(|found| blend.add(&row(found)));
        blend.mean()
    }

    /// Calls `visit` for what is nearer than `reach` (m), in no particular order; for the deepest
    /// overlap alone if a corner is more than 2 mm inside.
    ///
    /// What is near is kept in `recall`, of these two bodies: at a pose nearby it is not looked for
    /// again. What is visited does not depend on it.
    pub fn visit_below(
        &self,
        fixture_from_tool: &Pose,
        reach: f64,
        recall: &mut Option<Box<Nearby>>,
        mut visit: impl FnMut(&Touch),
    ) {
        let tool = self.tool_beside_fixture(fixture_from_tool);
        let nearby = Nearby::at(recall, &tool, reach);
        let sweep = Sweep::new(tool, Some(nearby));
        if sweep.deepest() < -DEEP {
            visit(&self.gap(fixture_from_tool));
        } else {
            let found = sweep.below(reach, f64::INFINITY);
            found.iter().filter(|found| found.value < reach).for_each(|found| visit(&sweep.touch(found)));
        }
        recall.take_if(|nearby| !nearby.is_small());
    }

    /// The tool at a pose.
    fn tool_beside_fixture(&self, fixture_from_tool: &Pose) -> Beside<'_> {
        Beside {
            body: &self.tool,
            other: &self.fixture,
            rotation: *fixture_from_tool.rotation.to_rotation_matrix().matrix(),
            translation: fixture_from_tool.translation.vector,
        }
    }
}

/// A signed distance, the tool's point and the normal from the fixture into the tool, in the
/// fixture frame.
#[derive(Clone, Debug)]
struct Found {
    value: f64,
    point: Vector3<f64>,
    normal: Vector3<f64>,
}

/// The least of all.
fn least(found: &[Found]) -> Option<&Found> {
    found.iter().min_by(|a, b| a.value.total_cmp(&b.value))
}

/// Two bodies at a pose.
struct Sweep<'a> {
    /// The edges of the bodies that are near each other, if they were looked for before.
    known: Option<&'a [Pair]>,
    tool: Placed<'a>,
    fixture: Placed<'a>,
}

impl<'a> Sweep<'a> {
    /// Of all, or of what is known to be near.
    fn new(tool: Beside<'a>, known: Option<&'a Nearby>) -> Self {
        Sweep {
            known: known.map(|nearby| &*nearby.edges),
            tool: Placed::new(tool, known.map(|nearby| &nearby.tool)),
            fixture: Placed::new(tool.turned_round(), known.map(|nearby| &nearby.fixture)),
        }
    }

    /// From the fixture's frame to the tool's.
    #[inline]
    fn in_tool(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.tool.beside.rotation.tr_mul(direction)
    }

    fn gradient(&self, found: &Found) -> Twist {
        let normal = self.in_tool(&found.normal);
        let point = self.in_tool(&(found.point - self.tool.beside.translation));
        twist(&normal, &point.cross(&normal))
    }

    fn touch(&self, found: &Found) -> Touch {
        let gradient = self.gradient(found);
        let (value, point_in_fixture, normal_in_fixture) = (found.value, found.point.into(), found.normal);
        Touch { value, gradient, point_in_fixture, normal_in_fixture }
    }

    /// The signed distance (m) of the deepest corner, zero if none is inside the other body.
    fn deepest(&self) -> f64 {
        self.tool.deepest().min(self.fixture.deepest())
    }

    /// The least signed distance; infinite if the bodies are more than 10 m apart.
    fn gap(&self) -> Touch {
        let nothing = Found { value: f64::INFINITY, point: Vector3::zeros(), normal: Vector3::z() };
        self.touch(least(&self.nearest(0.0)).unwrap_or(&nothing))
    }

    /// What is nearest, and all that is at most `margin` (m) farther, among others.
    fn nearest(&self, margin: f64) -> Vec<Found> {
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
    fn below(&self, reach: f64, margin: f64) -> Vec<Found> {
        let limit = Cell::new(reach);
        let mut kept: Vec<Found> = Vec::new();
        let keep = |kept: &mut Vec<Found>, found: Found| {
            limit.set(limit.get().min(found.value + margin));
            kept.push(found);
        };
        self.tool.corners_on_faces(&limit, &mut |value, point, normal| keep(&mut kept, Found { value, point, normal }));
        self.fixture.corners_on_faces(&limit, &mut |value, point, normal| {
            let Beside { rotation, translation, .. } = &self.tool.beside;
            keep(&mut kept, Found { value, point: rotation * point + translation, normal: -(rotation * normal) });
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
            let (tool, fixture) = (self.tool.beside.own(), self.fixture.beside.own());
            self.tool.beside.near(self.known, (&tool.edge_tree, &fixture.edge_tree), &limit, |e, f| {
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
    fn overlap(&self, of_tool: &Within<'_, 'a>, of_fixture: &Within<'_, 'a>, limit: f64) -> Option<Found> {
        let lines = self.tool.beside.lines(of_tool.edge, of_fixture.edge);
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
                .all(|face| behind(&(self.tool.beside.rotation * face), lines.fixture_ends, p));
        (is_overlap && self.is_one_place(&p, &q)).then_some(found)
    }

    /// Whether a point of the tool inside the fixture and one of the fixture inside the tool are of
    /// one place in the overlap: not much farther from each other than from the surface.
    fn is_one_place(&self, p: &Vector3<f64>, q: &Vector3<f64>) -> bool {
        let apart = (p - q).norm();
        let is_deep = |body: &Solid, point: Vector3<f64>| apart < -OBLIQUE * body.signed_distance(&point.into()).0;
        apart < ONE_PLACE
            || (is_deep(self.fixture.beside.body, *p)
                && is_deep(self.tool.beside.body, self.in_tool(&(q - self.tool.beside.translation))))
    }

    /// Two edges that have not passed each other, if nearer than `limit` (m), where overlaps are as
    /// deep as `deepest` (m).
    fn free(&self, e: &'a Edge, f: &'a Edge, limit: f64, deepest: f64) -> Option<Found> {
        let lines = self.tool.beside.lines(e, f);
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
    fn crossing(&self, lines: &Lines<'_>, places: Places) -> Option<Found> {
        let normal = lines.normal()?;
        let in_tool = self.in_tool(&normal);
        let (e, f) = (lines.of_tool, lines.of_fixture);
        let side = normal.dot(&(f.normals[0] + f.normals[1])) - in_tool.dot(&(e.normals[0] + e.normals[1]));
        let (normal, in_tool) = if side < 0.0 { (-normal, -in_tool) } else { (normal, in_tool) };
        let leans = e.into.iter().any(|into| into.dot(&in_tool) < -LEANING)
            || f.into.iter().any(|into| into.dot(&normal) > LEANING);
        let (p, q) = lines.points(places);
        (!leans).then(|| Found { value: normal.dot(&(p - q)), point: p, normal })
    }

    /// The end of an edge against an edge or another end, at places of which one is 0 or 1.
    fn end(&self, lines: &Lines<'_>, (s, t): Places) -> Option<Found> {
        let (p, q) = lines.points((s, t));
        let value = (p - q).norm();
        if value <= TOUCHING {
            return None;
        }
        let normal = (p - q) / value;
        let in_tool = self.in_tool(&normal);
        let corner = |facets: &'a Facets, edge: &Edge, at: f64| -> Option<Option<&'a [Vector3<f64>]>> {
            let end = usize::from(at == 1.0);
            if at > 0.0 && at < 1.0 {
                return Some(None);
            }
            // The corner's directions, if this edge speaks for it.
            let corner = facets.corner_at.get(&edge.ends[end]).filter(|_| edge.speaks[end])?;
            Some(Some(facets.corners[*corner as usize].along.as_slice()))
        };
        let (e, f) = (lines.of_tool, lines.of_fixture);
        let of_tool = corner(self.tool.beside.own(), e, s)?.unwrap_or(&e.into);
        let of_fixture = corner(self.fixture.beside.own(), f, t)?.unwrap_or(&f.into);
        // Nearest in earnest: the fixture falls away on all sides, and the tool hardly leans.
        let is_nearest = of_fixture.iter().all(|away| away.dot(&normal) <= TOUCHING)
            && of_tool.iter().all(|away| away.dot(&in_tool) >= -LEANING);
        is_nearest.then_some(Found { value, point: p, normal })
    }
}
