//! Features of a body that can touch another: faces, convex edges and convex vertices, and trees to
//! search them.

use std::collections::{HashMap, HashSet};

use nalgebra::{Point3, Vector3};

use super::bvh::{Aabb, Bvh};
use super::coplanar_faces::{CoplanarFace, coplanar_faces};

/// Angle (rad) between faces below which the edge between them is none.
const SMOOTH: f64 = 1e-4;
/// Distances (m) beyond a side up to this are none.
const ROUNDING: f64 = 1e-12;

/// A flat convex part of the surface.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    pub(crate) normal: Vector3<f64>,
    /// `normal · p` of its points.
    pub(crate) offset: f64,
    pub(crate) sides: Box<[Side]>,
}

/// A side of a face.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Side {
    /// Unit normal in the face's plane, away from it.
    outward: Vector3<f64>,
    /// `outward · p` of its points.
    offset: f64,
    /// Whether the surface rises there: the free space has a corner.
    is_concave: bool,
}

impl Side {
    /// How far a point of the plane lies beyond.
    #[inline]
    fn beyond(&self, point: &Vector3<f64>) -> f64 {
        self.outward.dot(point) - self.offset
    }
}

impl Face {
    /// Height of a point above the plane.
    #[inline]
    pub(crate) fn height(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// How far beyond sides in hollow corners the foot of a point lies; nothing if it lies beyond
    /// another one.
    #[inline]
    pub(crate) fn beyond(&self, point: &Vector3<f64>) -> Option<f64> {
        let mut beyond: f64 = 0.0;
        for side in self.sides.iter() {
            let outside = side.beyond(point);
            if outside > ROUNDING {
                if !side.is_concave {
                    return None;
                }
                beyond = beyond.max(outside);
            }
        }
        Some(beyond)
    }

    /// Whether a point within `limit` (m) of the plane may have its foot on the face, or in a
    /// hollow corner beyond it, when it moves by `room` (m).
    pub(crate) fn may_be_near(&self, point: &Vector3<f64>, room: f64, limit: f64) -> bool {
        let is_near = |side: &Side| side.beyond(point) <= if side.is_concave { limit } else { room };
        self.height(point).abs() <= limit && self.sides.iter().all(is_near)
    }

    /// Whether a segment may pass through when it moves by `room` (m): a part of it is that near to
    /// the plane, and not all of that part is farther beyond one side.
    pub(crate) fn may_be_pierced(&self, [from, to]: [Vector3<f64>; 2], room: f64) -> bool {
        let (above, then) = (self.height(&from), self.height(&to));
        // Places along it between which it is near the plane.
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (start, end) in [(above - room, then - room), (-above - room, -then - room)] {
            match (start > 0.0, end > 0.0) {
                (true, true) => return false,
                (true, false) => first = first.max(start / (start - end)),
                (false, true) => last = last.min(start / (start - end)),
                (false, false) => {}
            }
        }
        let [first, last] = [first, last].map(|place| from + (to - from) * place);
        self.sides.iter().all(|side| side.beyond(&first).min(side.beyond(&last)) <= room)
    }

    /// Where a segment passes through, 0 to 1, and whether it goes down there.
    #[inline]
    pub(crate) fn pierced(&self, [from, to]: [Vector3<f64>; 2]) -> Option<(f64, bool)> {
        let (above, then) = (self.height(&from), self.height(&to));
        if (above > 0.0) == (then > 0.0) {
            return None;
        }
        let place = above / (above - then);
        let point = from + (to - from) * place;
        self.sides.iter().all(|side| side.beyond(&point) <= ROUNDING).then_some((place, above > 0.0))
    }
}

/// A convex edge: the surface folds away from it on both sides.
#[derive(Clone, Debug)]
pub(crate) struct ConvexEdge {
    /// Its vertices.
    pub(crate) ends: [u32; 2],
    /// From the edge into its two faces, unit vectors square to it.
    pub(crate) into: [Vector3<f64>; 2],
    /// Normals of the two faces.
    pub(crate) normals: [Vector3<f64>; 2],
    /// Whether this edge, of several that end at a vertex, reports its contacts.
    pub(crate) owns_vertex: [bool; 2],
    /// Whether the body continues beyond the end: a concave edge begins there.
    pub(crate) continues: [bool; 2],
}

impl ConvexEdge {
    /// Whether a place along the edge, 0 to 1, is on it, or at most `beyond` (m) past an end where
    /// the body goes on.
    #[inline]
    pub(crate) fn reaches(&self, place: f64, length: f64, beyond: f64) -> bool {
        let past = |end: usize| if self.continues[end] { beyond } else { 0.0 };
        -place * length <= past(0) && (place - 1.0) * length <= past(1)
    }
}

/// A vertex at which a convex edge ends.
#[derive(Clone, Debug)]
pub(crate) struct ConvexVertex {
    pub(crate) vertex: u32,
    /// Unit directions of the edges that meet there, concave ones too.
    pub(crate) along: Vec<Vector3<f64>>,
    /// The convex edges that end there.
    pub(crate) edges: Vec<u32>,
}

/// The features of a body, in its frame.
#[derive(Clone, Debug)]
pub(crate) struct MeshFeatures {
    pub(crate) vertices: Vec<Vector3<f64>>,
    /// Middle (m) and radius (m) of a sphere around all.
    pub(crate) around: (Vector3<f64>, f64),
    pub(crate) faces: Vec<Face>,
    pub(crate) edges: Vec<ConvexEdge>,
    pub(crate) corners: Vec<ConvexVertex>,
    /// The corner at a vertex.
    pub(crate) corner_at: HashMap<u32, u32>,
    pub(crate) face_tree: Bvh,
    pub(crate) edge_tree: Bvh,
    pub(crate) corner_tree: Bvh,
}

impl MeshFeatures {
    /// Of a closed surface.
    pub(crate) fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let vertices: Vec<Vector3<f64>> = vertices.iter().map(|p| p.coords).collect();
        let at = |i: u32| vertices[i as usize];
        let polygons = coplanar_faces(&vertices, triangles);
        let Folds { faces, edges, meeting } = Folds::new(&vertices, &polygons);
        let mut corners: Vec<ConvexVertex> = meeting
            .iter()
            .filter(|(_, others)| others.iter().any(|&(_, is_convex)| is_convex))
            .map(|(&vertex, others)| {
                let along = others.iter().map(|&(other, _)| (at(other) - at(vertex)).normalize()).collect();
                ConvexVertex { vertex, along, edges: Vec::new() }
            })
            .collect();
        corners.sort_unstable_by_key(|corner| corner.vertex);
        let (joints, mut corners): (Vec<ConvexVertex>, Vec<ConvexVertex>) =
            corners.into_iter().partition(is_on_an_edge);
        let mut edges = joined(&edges, &joints.iter().map(|joint| joint.vertex).collect());
        let corner_at: HashMap<u32, u32> = corners.iter().zip(0..).map(|(corner, k)| (corner.vertex, k)).collect();
        assign_vertices(&mut edges, &mut corners, &corner_at, &meeting);
        let around = |all: &[u32]| Aabb::around(all.iter().map(|&vertex| at(vertex)));
        let around_face: Vec<Aabb> = polygons.iter().map(|polygon| around(&polygon.vertices)).collect();
        let around_edge: Vec<Aabb> = edges.iter().map(|edge| around(&edge.ends)).collect();
        let around_corner: Vec<Aabb> = corners.iter().map(|corner| around(&[corner.vertex])).collect();
        let [face_tree, edge_tree, corner_tree] = [&around_face, &around_edge, &around_corner].map(|all| Bvh::new(all));
        let around = sphere_around(&vertices);
        MeshFeatures { faces, edges, corners, corner_at, face_tree, edge_tree, corner_tree, vertices, around }
    }
}

/// Other ends of the edges that meet at each vertex, and whether these edges are convex.
type MeetingEdges = HashMap<u32, Vec<(u32, bool)>>;

/// Faces, and the edges along which the surface folds.
struct Folds {
    faces: Vec<Face>,
    /// Convex edges, not yet joined.
    edges: Vec<ConvexEdge>,
    meeting: MeetingEdges,
}

impl Folds {
    fn new(vertices: &[Vector3<f64>], polygons: &[CoplanarFace]) -> Self {
        let at = |i: u32| vertices[i as usize];
        // Of the polygon that each directed side is of.
        let normals: HashMap<(u32, u32), Vector3<f64>> =
            polygons.iter().flat_map(|polygon| polygon.sides().map(|side| (side, polygon.normal))).collect();
        let mut edges: Vec<ConvexEdge> = Vec::new();
        let mut meeting: MeetingEdges = HashMap::new();
        let mut faces = Vec::with_capacity(polygons.len());
        for polygon in polygons {
            let (normal, offset) = (polygon.normal, polygon.offset);
            let sides = polygon.sides().map(|(from, to)| {
                let along = (at(to) - at(from)).normalize();
                let outward = along.cross(&normal);
                let other = normals.get(&(to, from)).copied().unwrap_or(normal);
                let fold = normal.cross(&other).dot(&along);
                let is_smooth = fold.abs() < SMOOTH && normal.dot(&other) > 0.0;
                if from < to && !is_smooth {
                    let is_convex = fold > 0.0;
                    meeting.entry(from).or_default().push((to, is_convex));
                    meeting.entry(to).or_default().push((from, is_convex));
                    if is_convex {
                        let into = [-outward, along.cross(&other)];
                        edges.push(ConvexEdge {
                            ends: [from, to],
                            into,
                            normals: [normal, other],
                            owns_vertex: [false; 2],
                            continues: [false; 2],
                        });
                    }
                }
                Side { outward, offset: outward.dot(&at(from)), is_concave: !is_smooth && fold < 0.0 }
            });
            faces.push(Face { normal, offset, sides: sides.collect() });
        }
        Folds { faces, edges, meeting }
    }
}

/// Lists at each vertex its edges, and chooses the edge that owns it.
fn assign_vertices(
    edges: &mut [ConvexEdge],
    corners: &mut [ConvexVertex],
    corner_at: &HashMap<u32, u32>,
    meeting: &MeetingEdges,
) {
    let mut owned = HashSet::new();
    let is_concave = |vertex: &u32| meeting[vertex].iter().any(|&(_, is_convex)| !is_convex);
    for (k, edge) in (0..).zip(edges) {
        for corner in edge.ends.iter().filter_map(|end| corner_at.get(end)) {
            corners[*corner as usize].edges.push(k);
        }
        edge.continues = [is_concave(&edge.ends[0]), is_concave(&edge.ends[1])];
        for end in 0..2 {
            let vertex = edge.ends[end];
            edge.owns_vertex[end] = corner_at.contains_key(&vertex) && owned.insert(vertex);
        }
    }
}

/// Middle and radius of a sphere around points: that of a box around them.
fn sphere_around(points: &[Vector3<f64>]) -> (Vector3<f64>, f64) {
    let none = Vector3::repeat(f64::INFINITY);
    let (low, high) = points.iter().fold((none, -none), |(low, high), p| (low.inf(p), high.sup(p)));
    let middle = (low + high) / 2.0;
    (middle, (high - middle).norm())
}

/// Edges that a joint cuts in two as one.
fn joined(edges: &[ConvexEdge], joints: &HashSet<u32>) -> Vec<ConvexEdge> {
    let mut meeting: HashMap<u32, Vec<usize>> = HashMap::new();
    for (k, edge) in edges.iter().enumerate() {
        edge.ends.iter().filter(|end| joints.contains(end)).for_each(|&end| meeting.entry(end).or_default().push(k));
    }
    let mut is_done = vec![false; edges.len()];
    let mut whole = Vec::new();
    for k in 0..edges.len() {
        if std::mem::replace(&mut is_done[k], true) {
            continue;
        }
        let mut ends = edges[k].ends;
        for end in &mut ends {
            let on = |end: &u32, is_done: &[bool]| meeting.get(end)?.iter().copied().find(|&other| !is_done[other]);
            while let Some(next) = on(end, &is_done) {
                is_done[next] = true;
                let [a, b] = edges[next].ends;
                *end = if a == *end { b } else { a };
            }
        }
        whole.push(ConvexEdge { ends, ..edges[k].clone() });
    }
    whole
}

/// Whether a vertex only cuts a straight edge in two.
fn is_on_an_edge(corner: &ConvexVertex) -> bool {
    matches!(corner.along.as_slice(), [a, b] if a.dot(b) < -1.0 + 0.5 * SMOOTH * SMOOTH)
}
