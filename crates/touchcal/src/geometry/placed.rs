//! A body beside another, in the other's frame: which of its edges pierce the other, which corners are inside it, how far the corners are from its faces.

use std::cell::Cell;
use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::boxes::{Box3, Tree, near_pairs};
use super::facets::{Corner, Edge, Face, Facets};
use super::solid::Solid;

/// Sine of the angle by which a corner or edge may lean over what it is compared with: the nearer one beside it differs by less than noise.
pub(super) const LEANING: f64 = 0.3;
/// Distances (m) up to this are contact, be the bodies free or overlapping.
pub(super) const TOUCHING: f64 = 1e-12;
/// How far beyond a hollow corner a face still counts, as a part of the distance from it: a tilt makes right angles a little obtuse.
const PAST_CORNER: f64 = 0.01;
/// How far around a corner inside faces are looked for, as a part of its depth: √2 to one that is as high and as far beyond.
const AROUND: f64 = 1.5;

/// A body at a place beside another.
pub(super) struct Placed<'a> {
    pub(super) facets: &'a Facets,
    other: &'a Solid,
    /// From this body's frame to the other's.
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
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
pub(super) struct Within<'a> {
    pub(super) edge: &'a Edge,
    /// Where it goes in and out; nowhere if all of it is inside.
    at: &'a [Piercing],
}

impl Within<'_> {
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
    /// A body beside another, whose frame is turned and moved from its own.
    pub(super) fn new(facets: &'a Facets, other: &'a Solid, rotation: Matrix3<f64>, translation: Vector3<f64>) -> Self {
        let mut placed = Placed {
            facets,
            other,
            rotation,
            translation,
            piercings: Vec::new(),
            inside: Vec::new(),
            is_inside: vec![false; facets.corners.len()],
            within: Vec::new(),
        };
        placed.pierce();
        placed.go_inside();
        placed
    }

    /// A vertex, in the other's frame.
    #[inline]
    fn vertex(&self, vertex: u32) -> Vector3<f64> {
        self.rotation * self.facets.vertices[vertex as usize] + self.translation
    }

    /// Calls `visit` for what of one of this body's trees is nearer than `reach` to what of one of the other's.
    pub(super) fn near(&self, own: &Tree, others: &Tree, reach: &Cell<f64>, visit: impl FnMut(u32, u32)) {
        near_pairs(own, (&self.rotation, &self.translation), others, reach, visit);
    }

    /// The ends of an edge, in the other's frame.
    #[inline]
    pub(super) fn ends(&self, edge: &Edge) -> [Vector3<f64>; 2] {
        edge.ends.map(|end| self.vertex(end))
    }

    /// The signed distance (m) of the deepest corner inside the other body, zero if there is none.
    pub(super) fn deepest(&self) -> f64 {
        self.inside.first().map_or(0.0, |corner| corner.distance)
    }

    /// The least distance (m) of a corner from the other body: free bodies are no farther apart.
    pub(super) fn nearest_corner(&self) -> f64 {
        let mut nearest = f64::INFINITY;
        let mut last: Option<(Vector3<f64>, f64)> = None;
        for corner in &self.facets.corners {
            let point = self.vertex(corner.vertex);
            // Two corners' distances differ by no more than there is between them.
            if last.is_some_and(|(other, distance)| distance - (point - other).norm() >= nearest) {
                continue;
            }
            let (distance, _) = self.other.signed_distance(&point.into());
            nearest = nearest.min(distance);
            last = Some((point, distance));
        }
        nearest
    }

    /// The edges of which a part is inside the other body.
    pub(super) fn edges_within(&self) -> impl Iterator<Item = Within<'_>> {
        self.within
            .iter()
            .map(|(edge, at)| Within { edge: &self.facets.edges[*edge as usize], at: &self.piercings[at.clone()] })
    }

    fn pierce(&mut self) {
        let mut piercings = Vec::new();
        let faces = &self.other.facets;
        self.near(&self.facets.edge_tree, &faces.face_tree, &Cell::new(0.0), |edge, face| {
            let ends = self.ends(&self.facets.edges[edge as usize]);
            if let Some((place, enters)) = faces.faces[face as usize].pierced(ends) {
                piercings.push(Piercing { edge, place, enters });
            }
        });
        piercings.sort_unstable_by(|a, b| a.edge.cmp(&b.edge).then(a.place.total_cmp(&b.place)));
        self.piercings = piercings;
    }

    /// Finds the corners inside, from the edges that pierce along those that do not, and the edges of which a part is inside.
    fn go_inside(&mut self) {
        let facets = self.facets;
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
            let (distance, foot) = self.other.signed_distance(&self.vertex(vertex).into());
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
        self.facets.corner_at.get(&vertex).is_some_and(|&corner| self.is_inside[corner as usize])
    }

    /// Passes on how far corners are from faces of the other body, if less than `limit`, which may be lowered on the way: the distance, the corner's place and the face's normal.
    pub(super) fn corners_on_faces(&self, limit: &Cell<f64>, emit: &mut impl FnMut(f64, Vector3<f64>, Vector3<f64>)) {
        self.inside.iter().for_each(|inside| self.corner_inside(inside, limit, emit));
        if limit.get() <= 0.0 {
            return;
        }
        let corners = &self.facets.corners;
        let faces = &self.other.facets;
        self.near(&self.facets.corner_tree, &faces.face_tree, limit, |k, face| {
            if self.is_inside[k as usize] {
                return;
            }
            let (corner, face) = (&corners[k as usize], &faces.faces[face as usize]);
            let point = self.vertex(corner.vertex);
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
        let corner = &self.facets.corners[inside.corner as usize];
        let point = self.vertex(corner.vertex);
        let enough = -inside.distance * (1.0 + 1e-6) + TOUCHING;
        let mut is_told = false;
        let faces = &self.other.facets;
        let own = Tree::new(&[Box3::around([self.facets.vertices[corner.vertex as usize]])]);
        self.near(&own, &faces.face_tree, &Cell::new(limit.get().max(AROUND * enough)), |_, face| {
            let face = &faces.faces[face as usize];
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
        let normal = self.rotation.tr_mul(&face.normal);
        corner.along.iter().any(|along| along.dot(&normal) < -LEANING)
    }
}
