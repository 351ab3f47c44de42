//! The signed gap between two bodies of any shape.

use std::cell::Cell;

use nalgebra::{Matrix3, Point3, Vector3};

use super::blend::{self, Blend, Row};
use super::boxes::{Box3, near_pairs};
use super::facets::{Edge, Facets};
use super::solid::Solid;
use crate::se3::{Pose, Twist, twist};

/// Overlaps (m) up to this are looked for at first, deeper ones where what was found is half as deep, or a sentinel is.
const DEEP: f64 = 0.5e-3;
/// How many of the tool's corners, far from each other, are asked how deep they are.
const SENTINELS: usize = 8;
/// Sine of the angle by which a corner or edge may lean over what it is compared with: the nearer one beside it differs by less than noise.
const LEANING: f64 = 0.3;
/// How far beyond a hollow corner a face still counts, as a part of the distance from it: a tilt makes right angles a little obtuse.
const PAST_CORNER: f64 = 0.01;
/// Share of an overlap of edges below which a way out past the end of one of them is shorter.
const SHALLOWER: f64 = 0.9;
/// Distances (m) up to this are contact.
const TOUCHING: f64 = 1e-12;
/// Sine of the angle below which edges are parallel.
const PARALLEL: f64 = 1e-9;
/// Distance (m) beyond which nothing is looked for.
const FAR: f64 = 10.0;

/// A signed distance between tool and fixture, where it is attained and how it changes with the pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// Signed distance (m): positive free, negative penetrating.
    pub value: f64,
    /// `∂value/∂ξ` for `fixture_from_tool · Exp(ξ)`, a twist row `[v; ω]`: `[n; p × n]` in the tool frame.
    pub gradient: Twist,
    /// The point of the tool at which it is attained, in the fixture frame.
    pub point_in_fixture: Point3<f64>,
    /// Unit normal in the fixture frame, from the fixture into the tool: moving the tool along it opens the gap.
    pub normal_in_fixture: Vector3<f64>,
}

/// Two bodies, of which one touches the other.
///
/// # Signed gap
/// The least of signed distances between what can touch: corners of one against faces of the other, edges against edges. Outside contact it is the distance
/// between the bodies. In contact each distance passes through zero with an unchanged slope, and below measures how far a corner lies beyond the
/// nearest faces, or an edge beyond an edge.
///
/// A corner that penetrates is told from one that only lies behind some face by its signed distance from the body ([`Solid::signed_distance`]).
#[derive(Clone, Debug)]
pub struct Solids {
    tool: Solid,
    fixture: Solid,
    /// Vertices of the tool far from each other.
    sentinels: Vec<u32>,
}

impl Solids {
    /// A tool and what it touches, each in its own frame.
    pub fn new(tool: Solid, fixture: Solid) -> Self {
        let sentinels = far_apart(&tool.facets);
        Solids { tool, fixture, sentinels }
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
        let mut sweep = Sweep::new(self, fixture_from_tool);
        let nearest = sweep.nearest(0.0).into_iter().min_by(|a, b| a.value.total_cmp(&b.value));
        sweep.touch(&nearest.unwrap_or(Found { value: f64::INFINITY, point: Vector3::zeros(), normal: Vector3::z() }))
    }

    /// The mean of the distances that are nearly the least, and its gradient, as [`PegAndHole::blended_gap`](super::extrusion::PegAndHole::blended_gap) has it.
    pub fn blended_gap(&self, fixture_from_tool: &Pose, temperature: f64) -> (f64, Twist) {
        let mut sweep = Sweep::new(self, fixture_from_tool);
        let found = if temperature > 0.0 { sweep.nearest(blend::REACH * temperature) } else { Vec::new() };
        let Some(least) = found.iter().min_by(|a, b| a.value.total_cmp(&b.value)) else {
            let gap = self.gap(fixture_from_tool);
            return (gap.value, gap.gradient);
        };
        let row = |found: &Found| Row { value: found.value, gradient: sweep.gradient(found) };
        let mut blend = Blend::new(row(least), temperature);
        found.iter().for_each(|found| blend.add(&row(found)));
        blend.mean()
    }

    /// Calls `visit` for what is nearer than `reach` (m), in no particular order.
    pub fn visit_below(&self, fixture_from_tool: &Pose, reach: f64, mut visit: impl FnMut(&Touch)) {
        let mut sweep = Sweep::new(self, fixture_from_tool);
        let found = sweep.below(reach, f64::INFINITY);
        found.iter().filter(|found| found.value < reach).for_each(|found| visit(&sweep.touch(found)));
    }
}

/// Corners far from each other, the next always the one farthest from those before.
fn far_apart(facets: &Facets) -> Vec<u32> {
    let mut chosen: Vec<u32> = Vec::new();
    let mut apart: Vec<f64> = vec![f64::INFINITY; facets.corners.len()];
    while chosen.len() < SENTINELS.min(facets.corners.len()) {
        let farthest = (0..apart.len()).fold(0, |best, k| if apart[k] > apart[best] { k } else { best });
        let vertex = facets.corners[farthest].vertex;
        let place = facets.vertices[vertex as usize];
        for (corner, apart) in facets.corners.iter().zip(&mut apart) {
            *apart = apart.min((facets.vertices[corner.vertex as usize] - place).norm());
        }
        chosen.push(vertex);
    }
    chosen
}

/// An edge, its ends, and the point of it at which it passes another.
type Passing<'e> = (&'e Edge, [Vector3<f64>; 2], Vector3<f64>);

/// The least value.
fn least(found: &[Found]) -> f64 {
    found.iter().map(|found| found.value).fold(f64::INFINITY, f64::min)
}

/// A signed distance, the tool's point and the normal from the fixture into the tool, in the fixture frame.
#[derive(Clone, Debug)]
struct Found {
    value: f64,
    point: Vector3<f64>,
    normal: Vector3<f64>,
}

/// Two bodies at a pose.
struct Sweep<'a> {
    pair: &'a Solids,
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    /// Vertices of the tool in the fixture frame.
    moved: Vec<Vector3<f64>>,
    /// How deep (m) overlaps are looked for.
    deep: f64,
}

impl<'a> Sweep<'a> {
    fn new(pair: &'a Solids, fixture_from_tool: &Pose) -> Self {
        let rotation = *fixture_from_tool.rotation.to_rotation_matrix().matrix();
        let translation = fixture_from_tool.translation.vector;
        let moved: Vec<Vector3<f64>> =
            pair.tool.facets.vertices.iter().map(|vertex| rotation * vertex + translation).collect();
        let depth = |&vertex: &u32| -pair.fixture.signed_distance(&moved[vertex as usize].into()).0;
        let deepest = pair.sentinels.iter().map(depth).fold(0.0, f64::max);
        Sweep { pair, rotation, translation, moved, deep: DEEP.max(1.5 * deepest) }
    }

    fn gradient(&self, found: &Found) -> Twist {
        let normal = self.rotation.tr_mul(&found.normal);
        let point = self.rotation.tr_mul(&(found.point - self.translation));
        twist(&normal, &point.cross(&normal))
    }

    fn touch(&self, found: &Found) -> Touch {
        let gradient = self.gradient(found);
        let (value, point_in_fixture, normal_in_fixture) = (found.value, found.point.into(), found.normal);
        Touch { value, gradient, point_in_fixture, normal_in_fixture }
    }

    /// What is nearest, and all that is at most `margin` (m) farther, among others.
    fn nearest(&mut self, margin: f64) -> Vec<Found> {
        let mut reach = self.deep + margin;
        while reach < FAR {
            let found = self.below(reach, margin);
            if least(&found) + margin <= reach {
                return found;
            }
            reach *= 4.0;
        }
        Vec::new()
    }

    /// What is nearer than `reach` (m), unless it is more than `margin` (m) farther than the nearest.
    fn below(&mut self, reach: f64, margin: f64) -> Vec<Found> {
        loop {
            let mut kept: Vec<Found> = Vec::new();
            self.run(reach.max(self.deep), &mut |found: Found, limit: &Cell<f64>| {
                limit.set(limit.get().min((found.value + margin).max(self.deep)));
                kept.push(found);
            });
            if least(&kept) >= -0.5 * self.deep || self.deep > FAR {
                return kept;
            }
            self.deep *= 4.0;
        }
    }

    /// Passes on what is nearer than `reach`, which may be lowered on the way.
    fn run(&self, reach: f64, sink: &mut impl FnMut(Found, &Cell<f64>)) {
        let limit = Cell::new(reach);
        let (tool, fixture) = (&self.pair.tool.facets, &self.pair.fixture.facets);
        let place = |vertex: u32| self.moved[vertex as usize];
        let turn = |normal: &Vector3<f64>| self.rotation.tr_mul(normal);
        corners_on_faces(tool, &self.pair.fixture, (place, turn), &limit, &mut |value, point, normal| {
            sink(Found { value, point, normal }, &limit);
        });
        let back = |vertex: u32| self.rotation.tr_mul(&(fixture.vertices[vertex as usize] - self.translation));
        let turn = |normal: &Vector3<f64>| self.rotation * normal;
        corners_on_faces(fixture, &self.pair.tool, (back, turn), &limit, &mut |value, point, normal| {
            let point = self.rotation * point + self.translation;
            sink(Found { value, point, normal: -(self.rotation * normal) }, &limit);
        });
        let edge_boxes = tool.edge_tree.boxes(|k| Box3::around(tool.edges[k as usize].ends.map(place)));
        let edges = (&fixture.edge_tree, fixture.edge_boxes.as_slice());
        near_pairs((&tool.edge_tree, &edge_boxes), edges, &limit, |of_tool, of_fixture| {
            let (e, f) = (&tool.edges[of_tool as usize], &fixture.edges[of_fixture as usize]);
            if let Some(found) = self.edges(e, f).filter(|found| found.value < limit.get()) {
                sink(found, &limit);
            }
        });
    }

    /// An edge of the tool against one of the fixture.
    fn edges(&self, e: &Edge, f: &Edge) -> Option<Found> {
        let [e0, e1] = e.ends.map(|end| self.moved[end as usize]);
        let [f0, f1] = f.ends.map(|end| self.pair.fixture.facets.vertices[end as usize]);
        let (u, v, w) = (e1 - e0, f1 - f0, e0 - f0);
        let (uu, vv, uv, uw, vw) = (u.norm_squared(), v.norm_squared(), u.dot(&v), u.dot(&w), v.dot(&w));
        let across = uu * vv - uv * uv;
        if across > PARALLEL * PARALLEL * uu * vv {
            let (s, t) = ((uv * vw - vv * uw) / across, (uu * vw - uv * uw) / across);
            // Past the end of an edge where its body goes on, the other edge is within that body.
            if e.reaches(s, uu.sqrt(), self.deep) && f.reaches(t, vv.sqrt(), self.deep) {
                let found =
                    self.crossing((e, [e0, e1], e0 + u * s), (f, [f0, f1], f0 + v * t), u.cross(&v).normalize());
                if found.is_some() {
                    return found;
                }
            }
        }
        // Somewhere an end is nearest, to an end or to a point in between.
        let on_f = |p: &Vector3<f64>| (v.dot(&(p - f0)) / vv).clamp(0.0, 1.0);
        let on_e = |p: &Vector3<f64>| (u.dot(&(p - e0)) / uu).clamp(0.0, 1.0);
        let ends = [(0.0, on_f(&e0)), (1.0, on_f(&e1)), (on_e(&f0), 0.0), (on_e(&f1), 1.0)];
        let apart = |&(s, t): &(f64, f64)| (w + u * s - v * t).norm_squared();
        let nearest = ends.into_iter().min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        self.end(e, f, nearest, (e0 + u * nearest.0, f0 + v * nearest.1))
    }

    /// Two edges with their ends, of the tool and of the fixture, that pass each other at `p` and `q`, along the normal of both, either way.
    fn crossing(
        &self,
        (e, e_ends, p): Passing<'_>,
        (f, f_ends, q): Passing<'_>,
        normal: Vector3<f64>,
    ) -> Option<Found> {
        let in_tool = self.rotation.tr_mul(&normal);
        let side = normal.dot(&(f.normals[0] + f.normals[1])) - in_tool.dot(&(e.normals[0] + e.normals[1]));
        let (normal, in_tool) = if side < 0.0 { (-normal, -in_tool) } else { (normal, in_tool) };
        let leans = e.into.iter().any(|into| into.dot(&in_tool) < -LEANING)
            || f.into.iter().any(|into| into.dot(&normal) > LEANING);
        if leans {
            return None;
        }
        let value = normal.dot(&(p - q));
        // Edges that have passed each other overlap as deep as that, unless one ends shallower behind a face of the other.
        let behind = |face: &Vector3<f64>, ends: [Vector3<f64>; 2], at: Vector3<f64>| {
            ends.iter().any(|end| face.dot(&(at - end)) >= SHALLOWER * -value)
        };
        let overlaps = || {
            value > -self.deep
                && f.normals.iter().all(|face| behind(face, e_ends, q))
                && e.normals.iter().all(|face| behind(&(self.rotation * face), f_ends, p))
        };
        (value >= 0.0 || overlaps()).then_some(Found { value, point: p, normal })
    }

    /// The end of an edge against an edge or another end: `s` of the tool's edge at `p`, `t` of the fixture's at `q`.
    fn end(&self, e: &Edge, f: &Edge, (s, t): (f64, f64), (p, q): (Vector3<f64>, Vector3<f64>)) -> Option<Found> {
        let value = (p - q).norm();
        if value <= TOUCHING {
            return None;
        }
        let normal = (p - q) / value;
        let in_tool = self.rotation.tr_mul(&normal);
        let corner = |facets: &'a Facets, edge: &Edge, at: f64| -> Option<Option<&'a [Vector3<f64>]>> {
            let end = usize::from(at == 1.0);
            if at > 0.0 && at < 1.0 {
                return Some(None);
            }
            // The corner's directions, if this edge speaks for it.
            let corner = facets.corner_at.get(&edge.ends[end]).filter(|_| edge.speaks[end])?;
            Some(Some(facets.corners[*corner as usize].along.as_slice()))
        };
        let of_tool = corner(&self.pair.tool.facets, e, s)?.unwrap_or(&e.into);
        let of_fixture = corner(&self.pair.fixture.facets, f, t)?.unwrap_or(&f.into);
        // Nearest in earnest: the fixture falls away on all sides, and the tool hardly leans.
        let is_nearest = of_fixture.iter().all(|away| away.dot(&normal) <= TOUCHING)
            && of_tool.iter().all(|away| away.dot(&in_tool) >= -LEANING);
        is_nearest.then_some(Found { value, point: p, normal })
    }
}

/// Corners of one body against faces of another, in the other's frame: the `place` of a vertex there, and the `turn` of a direction back. `emit` gets a distance, the
/// corner's place and the face's normal.
fn corners_on_faces(
    corners: &Facets,
    body: &Solid,
    (place, turn): (impl Fn(u32) -> Vector3<f64>, impl Fn(&Vector3<f64>) -> Vector3<f64>),
    limit: &Cell<f64>,
    emit: &mut impl FnMut(f64, Vector3<f64>, Vector3<f64>),
) {
    // Behind a face or past its side, which a corner is that penetrates: which corner, which face, its height above it, how far past its sides.
    let mut doubtful: Vec<(u32, u32, f64, f64)> = Vec::new();
    let corner_boxes = corners.corner_tree.boxes(|k| Box3::around([place(corners.corners[k as usize].vertex)]));
    let faces = (&body.facets.face_tree, body.facets.face_boxes.as_slice());
    near_pairs((&corners.corner_tree, &corner_boxes), faces, limit, |k, face_index| {
        let corner = &corners.corners[k as usize];
        let face = &body.facets.faces[face_index as usize];
        let point = place(corner.vertex);
        let height = face.height(&point);
        if height >= limit.get() {
            return;
        }
        let Some(beyond) = face.beyond(&point) else { return };
        let normal = turn(&face.normal);
        if height >= 0.0 && corner.along.iter().any(|along| along.dot(&normal) < -LEANING) {
            return;
        }
        if height < -TOUCHING || beyond > PAST_CORNER * height + TOUCHING {
            doubtful.push((k, face_index, height, beyond));
        } else {
            emit(height, point, face.normal);
        }
    });
    doubtful.sort_unstable_by_key(|&(corner, face, _, _)| (corner, face));
    for of_corner in doubtful.chunk_by(|a, b| a.0 == b.0) {
        let point = place(corners.corners[of_corner[0].0 as usize].vertex);
        let (distance, foot) = body.signed_distance(&point.into());
        if distance >= 0.0 {
            continue;
        }
        let enough = -distance * (1.0 + 1e-6) + TOUCHING;
        let mut is_told = false;
        for &(_, face, height, beyond) in of_corner {
            if -height <= enough && beyond <= enough {
                is_told |= height < 0.0;
                emit(height, point, body.facets.faces[face as usize].normal);
            }
        }
        if !is_told {
            emit(distance, point, (foot.coords - point) / -distance);
        }
    }
}
