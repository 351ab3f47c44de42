//! A body beside another, in the other's frame: which of its edges pierce the other, which corners
//! are inside it, how far the corners are from its faces.

use std::cell::Cell;
use std::ops::Range;

use nalgebra::Vector3;

use super::beside::Beside;
use super::boxes::{Box3, Tree};
use super::facets::{Corner, Edge, Face};
use super::nearby::OnFaces;

/// Sine of the angle by which a corner or edge may lean over what it is compared with: the nearer
/// one beside it differs by less than noise.
pub(super) const LEANING: f64 = 0.3;
/// Distances (m) up to this are contact, be the bodies free or overlapping.
pub(super) const TOUCHING: f64 = 1e-12;
/// How far beyond a hollow corner a face still counts, as a part of the distance from it: a tilt
/// makes right angles a little obtuse.
pub(super) const PAST_CORNER: f64 = 0.01;
/// How far around a corner inside faces are looked for, as a part of its depth: √2 to one that is
/// as high and as far beyond.
const AROUND: f64 = 1.5;

/// A body at a place beside another.
pub(super) struct Placed<'a> {
    pub(super) beside: Beside<'a>,
    /// What of it is near the other's faces, if that was looked for before.
    known: Option<&'a OnFaces>,
    /// Where edges pierce the other's surface, in their order and along each.
    piercings: Vec<Piercing>,
    /// Corners inside the other, the deepest first.
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

/// A corner inside the other body.
struct Inside {
    corner: u32,
    /// Signed distance (m) from the other's surface.
    distance: f64,
    /// The nearest point of that surface.
    foot: Vector3<f64>,
}

/// An edge of which a part is inside the other body.
pub(super) struct Within<'p, 'a> {
    pub(super) edge: &'a Edge,
    /// Where it goes in and out; nowhere if all of it is inside.
    at: &'p [Piercing],
}

impl Within<'_, '_> {
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

impl<'a> Placed<'a> {
    /// What of a body is inside the other or near it; of what is `known` to be near, if that was
    /// looked for before.
    pub(super) fn new(beside: Beside<'a>, known: Option<&'a OnFaces>) -> Self {
        let mut placed = Placed {
            beside,
            known,
            piercings: Vec::new(),
            inside: Vec::new(),
            is_inside: vec![false; beside.own().corners.len()],
            within: Vec::new(),
        };
        placed.pierce();
        placed.go_inside();
        placed
    }

    /// The signed distance (m) of the deepest corner inside the other body, zero if there is none.
    pub(super) fn deepest(&self) -> f64 {
        self.inside.first().map_or(0.0, |corner| corner.distance)
    }

    /// The least distance (m) of a corner from the other body: free bodies are no farther apart.
    pub(super) fn nearest_corner(&self) -> f64 {
        let mut nearest = f64::INFINITY;
        let mut last: Option<(Vector3<f64>, f64)> = None;
        for corner in &self.beside.own().corners {
            let point = self.beside.vertex(corner.vertex);
            // Two corners' distances differ by no more than there is between them.
            if last.is_some_and(|(other, distance)| distance - (point - other).norm() >= nearest) {
                continue;
            }
            let (distance, _) = self.beside.other.signed_distance(&point.into());
            nearest = nearest.min(distance);
            last = Some((point, distance));
        }
        nearest
    }

    /// The edges of which a part is inside the other body.
    pub(super) fn edges_within(&self) -> impl Iterator<Item = Within<'_, 'a>> {
        self.within.iter().map(|(edge, at)| Within {
            edge: &self.beside.own().edges[*edge as usize],
            at: &self.piercings[at.clone()],
        })
    }

    fn pierce(&mut self) {
        let mut piercings = Vec::new();
        let (body, others) = (self.beside, self.beside.others());
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
    fn go_inside(&mut self) {
        let facets = self.beside.own();
        let mut is_known = vec![false; facets.edges.len()];
        let mut next: Vec<u32> = Vec::new();
        for at in self.piercings.chunk_by(|a, b| a.edge == b.edge) {
            let edge = at[0].edge as usize;
            is_known[edge] = true;
            next.extend(is_start_inside(at).then_some(facets.edges[edge].ends[0]));
            next.extend(is_end_inside(at).then_some(facets.edges[edge].ends[1]));
        }
        if self.piercings.is_empty() {
            // All of it may be inside.
            next.extend(facets.corners.first().map(|corner| corner.vertex));
        }
        let mut is_asked = vec![false; facets.corners.len()];
        while let Some(vertex) = next.pop() {
            let Some(&corner) = facets.corner_at.get(&vertex) else { continue };
            if std::mem::replace(&mut is_asked[corner as usize], true) {
                continue;
            }
            let (distance, foot) = self.beside.other.signed_distance(&self.beside.vertex(vertex).into());
            if distance < 0.0 {
                self.is_inside[corner as usize] = true;
                self.inside.push(Inside { corner, distance, foot: foot.coords });
                for &edge in &facets.corners[corner as usize].edges {
                    if !std::mem::replace(&mut is_known[edge as usize], true) {
                        self.within.push((edge, 0..0));
                        next.extend(facets.edges[edge as usize].ends);
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
            let [start, end] = facets.edges[at[0].edge as usize].ends.map(|vertex| self.is_vertex_inside(vertex));
            if is_start_inside(at) == start && is_end_inside(at) == end {
                self.within.push((at[0].edge, range));
            }
        }
    }

    fn is_vertex_inside(&self, vertex: u32) -> bool {
        self.beside.own().corner_at.get(&vertex).is_some_and(|&corner| self.is_inside[corner as usize])
    }

    /// Passes on how far corners are from faces of the other body, if less than `limit`, which may
    /// be lowered on the way: the distance, the corner's place and the face's normal.
    pub(super) fn corners_on_faces(&self, limit: &Cell<f64>, emit: &mut impl FnMut(f64, Vector3<f64>, Vector3<f64>)) {
        self.inside.iter().for_each(|inside| self.corner_inside(inside, limit, emit));
        if limit.get() <= 0.0 {
            return;
        }
        let (body, others) = (&self.beside, self.beside.others());
        let known = self.known.map(|known| &*known.corners);
        body.near(known, (&body.own().corner_tree, &others.face_tree), limit, |k, face| {
            if self.is_inside[k as usize] {
                return;
            }
            let (corner, face) = (&body.own().corners[k as usize], &others.faces[face as usize]);
            let point = body.vertex(corner.vertex);
            let height = face.height(&point);
            let is_near = (-TOUCHING..limit.get()).contains(&height)
                && face.beyond(&point).is_some_and(|beyond| beyond <= PAST_CORNER * height + TOUCHING);
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
        let (body, others) = (&self.beside, self.beside.others());
        let corner = &body.own().corners[inside.corner as usize];
        let point = body.vertex(corner.vertex);
        let enough = -inside.distance * (1.0 + 1e-6) + TOUCHING;
        let mut is_told = false;
        let own = Tree::new(&[Box3::around([body.own().vertices[corner.vertex as usize]])]);
        let farthest = Cell::new(limit.get().max(AROUND * enough));
        body.near(None, (&own, &others.face_tree), &farthest, |_, face| {
            let face = &others.faces[face as usize];
            let height = face.height(&point);
            if height < -enough || face.beyond(&point).is_none_or(|beyond| beyond > enough) {
                return;
            }
            is_told |= height < 0.0;
            if height < limit.get() && (height < 0.0 || !self.leans(corner, face)) {
                emit(height, point, face.normal);
            }
        });
        if !is_told {
            emit(inside.distance, point, (inside.foot - point) / -inside.distance);
        }
    }

    /// Whether a part of the body beside the corner is nearer to the face.
    fn leans(&self, corner: &Corner, face: &Face) -> bool {
        let normal = self.beside.rotation.tr_mul(&face.normal);
        corner.along.iter().any(|along| along.dot(&normal) < -LEANING)
    }
}
