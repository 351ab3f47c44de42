//! Penetration of one body into another: the edges that pierce the surface, the convex vertices
//! inside, and the distances of vertices from faces.

use std::cell::Cell;
use std::ops::Range;

use nalgebra::Vector3;

use super::neighbor_list::OnFaces;
use super::posed_pair::PosedPair;
use super::tolerances::{LEANING, PAST_EDGE, TOUCHING};
use crate::geometry::mesh::{Aabb, Bvh, ConvexEdge, ConvexVertex, Face};

/// How far around a corner inside faces are looked for, as a part of its depth: √2 to one that is
/// as high and as far beyond.
const AROUND: f64 = 1.5;

/// What of a posed body is inside another one.
pub(super) struct Penetration<'a> {
    pub(super) pair: PosedPair<'a>,
    /// Pairs of features that a former search found, if there is one.
    known: Option<&'a OnFaces>,
    /// Where edges pierce the other's surface, in their order and along each.
    piercings: Vec<Piercing>,
    /// Convex vertices inside the other body, the deepest first.
    inside: Vec<Inside>,
    is_inside: Vec<bool>,
    /// The edges of which a part is inside, and their piercings.
    within: Vec<(u32, Range<usize>)>,
}

/// A place where an edge pierces a surface.
struct Piercing {
    edge: u32,
    /// 0 to 1 along the edge.
    place: f64,
    enters: bool,
}

/// A convex vertex inside the other body.
struct Inside {
    corner: u32,
    /// Signed distance (m) from the other's surface.
    distance: f64,
    /// The nearest point of that surface.
    foot: Vector3<f64>,
}

/// An edge of which a part is inside the other body.
pub(super) struct EdgeInside<'p, 'a> {
    pub(super) edge: &'a ConvexEdge,
    /// Where it goes in and out; nowhere if all of it is inside.
    at: &'p [Piercing],
}

impl EdgeInside<'_, '_> {
    /// Whether a place along the edge, 0 to 1, is inside the other body.
    pub(super) fn is_inside(&self, place: f64) -> bool {
        let before = self.at.iter().rfind(|piercing| piercing.place <= place);
        before.map_or_else(|| is_start_inside(self.at), |last| last.enters)
    }
}

/// Whether an edge begins inside.
fn is_start_inside(at: &[Piercing]) -> bool {
    at.first().is_none_or(|first| !first.enters)
}

/// Whether an edge ends inside.
fn is_end_inside(at: &[Piercing]) -> bool {
    at.last().is_none_or(|last| last.enters)
}

impl<'a> Penetration<'a> {
    /// What of a body is inside the other or near it; of what is `known` to be near, if that was
    /// looked for before.
    pub(super) fn new(pair: PosedPair<'a>, known: Option<&'a OnFaces>) -> Self {
        let mut penetration = Penetration {
            pair,
            known,
            piercings: Vec::new(),
            inside: Vec::new(),
            is_inside: vec![false; pair.own().corners.len()],
            within: Vec::new(),
        };
        penetration.pierce();
        penetration.flood_interior();
        penetration
    }

    /// The signed distance (m) of the deepest corner inside the other body, zero if there is none.
    pub(super) fn deepest(&self) -> f64 {
        self.inside.first().map_or(0.0, |corner| corner.distance)
    }

    /// The least distance (m) of a corner from the other body: free bodies are no farther apart.
    pub(super) fn nearest_corner(&self) -> f64 {
        let mut nearest = f64::INFINITY;
        let mut last: Option<(Vector3<f64>, f64)> = None;
        for corner in &self.pair.own().corners {
            let point = self.pair.vertex(corner.vertex);
            // Two corners' distances differ by no more than there is between them.
            if last.is_some_and(|(other, distance)| distance - (point - other).norm() >= nearest) {
                continue;
            }
            let (distance, _) = self.pair.other.signed_distance(&point.into());
            nearest = nearest.min(distance);
            last = Some((point, distance));
        }
        nearest
    }

    /// The edges of which a part is inside the other body.
    pub(super) fn edges_within(&self) -> impl Iterator<Item = EdgeInside<'_, 'a>> {
        self.within.iter().map(|(edge, at)| EdgeInside {
            edge: &self.pair.own().edges[*edge as usize],
            at: &self.piercings[at.clone()],
        })
    }

    fn pierce(&mut self) {
        let mut piercings = Vec::new();
        let (body, others) = (self.pair, self.pair.others());
        let known = self.known.map(|known| &*known.edges);
        body.near(known, (&body.own().edge_tree, &others.face_tree), &Cell::new(0.0), |edge, face| {
            if let Some((place, enters)) = others.faces[face as usize].pierced(body.ends(edge)) {
                piercings.push(Piercing { edge, place, enters });
            }
        });
        piercings.sort_by(|a, b| a.edge.cmp(&b.edge).then(a.place.total_cmp(&b.place)));
        self.piercings = piercings;
    }

    /// Finds the corners inside, from the edges that pierce along those that do not, and the edges
    /// of which a part is inside.
    fn flood_interior(&mut self) {
        let features = self.pair.own();
        let mut is_known = vec![false; features.edges.len()];
        let mut next: Vec<u32> = Vec::new();
        for at in self.piercings.chunk_by(|a, b| a.edge == b.edge) {
            let edge = at[0].edge as usize;
            is_known[edge] = true;
            next.extend(is_start_inside(at).then_some(features.edges[edge].ends[0]));
            next.extend(is_end_inside(at).then_some(features.edges[edge].ends[1]));
        }
        if self.piercings.is_empty() {
            // All of it may be inside.
            next.extend(features.corners.first().map(|corner| corner.vertex));
        }
        let mut is_visited = vec![false; features.corners.len()];
        while let Some(vertex) = next.pop() {
            let Some(&corner) = features.corner_at.get(&vertex) else { continue };
            if std::mem::replace(&mut is_visited[corner as usize], true) {
                continue;
            }
            let (distance, foot) = self.pair.other.signed_distance(&self.pair.vertex(vertex).into());
            if distance < 0.0 {
                self.is_inside[corner as usize] = true;
                self.inside.push(Inside { corner, distance, foot: foot.coords });
                for &edge in &features.corners[corner as usize].edges {
                    if !std::mem::replace(&mut is_known[edge as usize], true) {
                        self.within.push((edge, 0..0));
                        next.extend(features.edges[edge as usize].ends);
                    }
                }
            }
        }
        self.inside.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.corner.cmp(&b.corner)));
        let mut first = 0;
        for at in self.piercings.chunk_by(|a, b| a.edge == b.edge) {
            let range = first..first + at.len();
            first = range.end;
            // Where rounding has it the wrong way round, at contact, it is not inside.
            let [start, end] = features.edges[at[0].edge as usize].ends.map(|vertex| self.is_vertex_inside(vertex));
            if is_start_inside(at) == start && is_end_inside(at) == end {
                self.within.push((at[0].edge, range));
            }
        }
    }

    fn is_vertex_inside(&self, vertex: u32) -> bool {
        self.pair.own().corner_at.get(&vertex).is_some_and(|&corner| self.is_inside[corner as usize])
    }

    /// Passes on how far corners are from faces of the other body, if less than `limit`, which may
    /// be lowered on the way: the distance, the corner's place and the face's normal.
    pub(super) fn corners_on_faces(&self, limit: &Cell<f64>, emit: &mut impl FnMut(f64, Vector3<f64>, Vector3<f64>)) {
        self.inside.iter().for_each(|inside| self.corner_inside(inside, limit, emit));
        if limit.get() <= 0.0 {
            return;
        }
        let (body, others) = (&self.pair, self.pair.others());
        let known = self.known.map(|known| &*known.corners);
        body.near(known, (&body.own().corner_tree, &others.face_tree), limit, |k, face| {
            if self.is_inside[k as usize] {
                return;
            }
            let (corner, face) = (&body.own().corners[k as usize], &others.faces[face as usize]);
            let point = body.vertex(corner.vertex);
            let height = face.height(&point);
            let is_near = (-TOUCHING..limit.get()).contains(&height)
                && face.beyond(&point).is_some_and(|beyond| beyond <= PAST_EDGE * height + TOUCHING);
            if is_near && !self.leans(corner, face) {
                emit(height, point, face.normal);
            }
        });
    }

    /// A corner inside, against the nearest face and that one's neighbours in a hollow corner.
    fn corner_inside(
        &self,
        inside: &Inside,
        limit: &Cell<f64>,
        emit: &mut impl FnMut(f64, Vector3<f64>, Vector3<f64>),
    ) {
        if inside.distance >= limit.get() {
            return;
        }
        let (body, others) = (&self.pair, self.pair.others());
        let corner = &body.own().corners[inside.corner as usize];
        let point = body.vertex(corner.vertex);
        let enough = -inside.distance * (1.0 + 1e-6) + TOUCHING;
        let mut is_reported = false;
        let own = Bvh::new(&[Aabb::around([body.own().vertices[corner.vertex as usize]])]);
        let farthest = Cell::new(limit.get().max(AROUND * enough));
        body.near(None, (&own, &others.face_tree), &farthest, |_, face| {
            let face = &others.faces[face as usize];
            let height = face.height(&point);
            if height < -enough || face.beyond(&point).is_none_or(|beyond| beyond > enough) {
                return;
            }
            is_reported |= height < 0.0;
            if height < limit.get() && (height < 0.0 || !self.leans(corner, face)) {
                emit(height, point, face.normal);
            }
        });
        if !is_reported {
            emit(inside.distance, point, (inside.foot - point) / -inside.distance);
        }
    }

    /// Whether a part of the body pair the corner is nearer to the face.
    fn leans(&self, corner: &ConvexVertex, face: &Face) -> bool {
        let normal = self.pair.rotation.tr_mul(&face.normal);
        corner.along.iter().any(|along| along.dot(&normal) < -LEANING)
    }
}
