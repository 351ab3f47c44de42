//! Distances between points and the image of an outline, in the plane.

use super::vertex_edge_bounds::{NearEdge, VertexEdgeBounds, lesser};
use crate::geometry::polygon::Polygon;
use nalgebra::{Matrix2, Vector2};

/// Distances (m) up to this are contact: the direction from foot to point is left to the edge.
pub(super) const TOUCHING: f64 = 1e-12;
/// How far beyond a corner of the free side an edge's line still counts, as a part of the distance
/// from it: a tilt makes right angles a little obtuse.
const PAST_CORNER: f64 = 0.01;

/// An outline seen along an axis: an affine image of the polygon in a plane.
pub(super) struct ProjectedPolygon<'a> {
    pub(super) polygon: &'a Polygon,
    pub(super) linear: Matrix2<f64>,
    pub(super) offset: Vector2<f64>,
    /// Height of an outline point along the axis: `slope · p + height`.
    pub(super) slope: Vector2<f64>,
    pub(super) height: f64,
    /// Most that an outline point is displaced from its aligned place.
    pub(super) moved: f64,
    /// +1, or −1 where the image is mirrored.
    pub(super) turn: f64,
    pub(super) near: &'a VertexEdgeBounds,
}

/// The point of a loop nearest to a query.
#[derive(Clone, Copy)]
pub(super) struct ClosestPoint {
    pub(super) edge: usize,
    /// Place along the edge, 0 to 1.
    pub(super) t: f64,
    pub(super) distance: f64,
}

impl ClosestPoint {
    const NONE: ClosestPoint = ClosestPoint { edge: 0, t: 0.0, distance: f64::INFINITY };

    pub(super) fn at_vertex(&self) -> bool {
        self.t <= 0.0 || self.t >= 1.0
    }
}

/// A signed distance from a loop in its plane: positive along `normal`.
pub(super) struct Offset {
    pub(super) edge: usize,
    pub(super) t: f64,
    pub(super) value: f64,
    /// Unit normal of the loop towards the free side.
    pub(super) normal: Vector2<f64>,
}

impl ProjectedPolygon<'_> {
    #[inline]
    pub(super) fn segment(&self, edge: usize) -> (Vector2<f64>, Vector2<f64>) {
        let (a, b) = self.polygon.edge(edge);
        (self.linear * a.coords + self.offset, self.linear * (b - a))
    }

    pub(super) fn point(&self, edge: usize, t: f64) -> Vector2<f64> {
        let (a, along) = self.segment(edge);
        a + along * t
    }

    /// Height of an outline point along the axis.
    #[inline]
    pub(super) fn height_of(&self, point: &Vector2<f64>) -> f64 {
        self.slope.dot(point) + self.height
    }

    /// How much farther a query vertex and an edge at least are than when aligned, see
    /// [`VertexEdgeBounds::bound`]; the vertex itself moved by `moved`.
    #[inline]
    pub(super) fn parted(&self, near: &NearEdge, moved: &Vector2<f64>) -> f64 {
        // Points p of the edge move by (linear − 1) p + offset; of these only the first depends on
        // p.
        let [a, b] = &near.ends;
        let turned = self.linear.tr_mul(&near.away) - near.away;
        near.away.dot(&(moved - self.offset)) + lesser(-turned.dot(a), -turned.dot(b))
    }

    /// A lower bound of the distance of a query vertex that stays in its place, see
    /// [`VertexEdgeBounds::bound`].
    #[inline]
    pub(super) fn bound(&self, vertex: usize) -> f64 {
        self.near.bound(vertex, self.moved, |near| self.parted(near, &Vector2::zeros()))
    }

    /// Height of a point of an edge.
    #[inline]
    pub(super) fn height_at(&self, edge: usize, t: f64) -> f64 {
        let (a, b) = self.polygon.edge(edge);
        self.slope.dot(&(a.coords + (b - a) * t)) + self.height
    }

    #[inline(always)]
    pub(super) fn foot(&self, edge: usize, x: &Vector2<f64>) -> ClosestPoint {
        let (a, along) = self.segment(edge);
        let t = ((x - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        ClosestPoint { edge, t, distance: (x - a - along * t).norm() }
    }

    /// Nearest point of the loop to the query, and nearest point that counts and is closer than
    /// `reach`.
    #[inline]
    pub(super) fn nearest(&self, query: &Query, reach: f64) -> (ClosestPoint, ClosestPoint) {
        let (mut any, mut counted) = (ClosestPoint::NONE, ClosestPoint::NONE);
        let parted = |near: &NearEdge| self.parted(near, &query.moved);
        self.near.scan(query.vertex, (f64::INFINITY, self.moved), parted, |edge| {
            let foot = self.foot(edge, &query.x);
            if foot.distance < any.distance {
                any = foot;
            }
            if foot.distance < counted.distance {
                let height = self.height_at(edge, foot.t);
                if query.range.0 <= height && height <= query.range.1 {
                    counted = foot;
                }
            }
            any.distance.max(counted.distance.min(reach))
        });
        (any, counted)
    }

    /// Whether `x`, whose nearest point is `foot`, lies within the outline.
    pub(super) fn encloses(&self, x: &Vector2<f64>, foot: &ClosestPoint) -> bool {
        let left = |edge: usize| {
            let (a, along) = self.segment(edge);
            along.perp(&(x - a)) * self.turn > 0.0
        };
        if !foot.at_vertex() {
            return left(foot.edge);
        }
        let (before, after) = self.edges_at(foot);
        if self.polygon.is_convex_at(after) { left(before) && left(after) } else { left(before) || left(after) }
    }

    /// The edges before and after the vertex at which a foot lies.
    pub(super) fn edges_at(&self, foot: &ClosestPoint) -> (usize, usize) {
        let n = self.polygon.len();
        let after = if foot.t <= 0.0 { foot.edge } else { (foot.edge + 1) % n };
        ((after + n - 1) % n, after)
    }

    /// Signed distance from an edge's line; `free` is +1 if the free side is the inside of the
    /// outline, else −1.
    #[inline(always)]
    pub(super) fn line_offset(&self, x: &Vector2<f64>, edge: usize, free: f64) -> Offset {
        let (a, along) = self.segment(edge);
        let inverse = 1.0 / along.norm().max(f64::MIN_POSITIVE);
        let t = (x - a).dot(&along) * (inverse * inverse);
        let along = along * (inverse * self.turn * free);
        let normal = Vector2::new(-along.y, along.x);
        Offset { edge, t, value: normal.dot(&(x - a)), normal }
    }

    /// Signed distance on the free side: from the edge, or from the vertex at which the foot lies.
    #[inline(always)]
    pub(super) fn foot_offset(&self, x: &Vector2<f64>, foot: &ClosestPoint, free: f64) -> Offset {
        let line = self.line_offset(x, foot.edge, free);
        if foot.distance <= TOUCHING || (!foot.at_vertex() && line.value > 0.0) {
            return line;
        }
        let normal = (x - self.point(foot.edge, foot.t)) / foot.distance;
        Offset { t: foot.t, value: foot.distance, normal, ..line }
    }

    /// Distance on the free side from an edge, or from an end of it, in which case its place is
    /// clamped to 0 or 1. A vertex counts once, at the start of its edge, and only if it points to
    /// the free side; in a corner of the free side lines count a little beyond it.
    #[inline(always)]
    pub(super) fn edge_offset(&self, x: &Vector2<f64>, edge: usize, free: f64) -> Option<Offset> {
        let line = self.line_offset(x, edge, free);
        let within = line.t > 0.0 && line.t < 1.0;
        if within && line.value > 0.0 {
            return Some(line);
        }
        if !within {
            let (a, b) = self.polygon.edge(edge);
            let vertex = if line.t <= 0.0 { edge } else { (edge + 1) % self.polygon.len() };
            if self.polygon.is_convex_at(vertex) == (free > 0.0) {
                let beyond = (-line.t).max(line.t - 1.0) * (self.linear * (b - a)).norm();
                return (beyond <= PAST_CORNER * line.value + TOUCHING).then_some(line);
            }
            if line.t > 0.0 {
                return None;
            }
        }
        let t = line.t.clamp(0.0, 1.0);
        let away = x - self.point(edge, t);
        let distance = away.norm();
        if distance <= TOUCHING {
            return Some(Offset { t, ..line });
        }
        Some(Offset { t, value: distance, normal: away / distance, ..line })
    }

    /// Signed distances on the penetrating side: beyond a vertex both edges continue straight,
    /// beyond an edge the neighbours that it meets in a corner of the free side count as long as
    /// they are not passed too.
    pub(super) fn beyond(&self, x: &Vector2<f64>, foot: &ClosestPoint, free: f64) -> [Option<Offset>; 3] {
        if foot.at_vertex() {
            let (before, after) = self.edges_at(foot);
            return [Some(self.line_offset(x, before, free)), Some(self.line_offset(x, after, free)), None];
        }
        let n = self.polygon.len();
        let (before, after) = ((foot.edge + n - 1) % n, (foot.edge + 1) % n);
        let neighbour = |edge: usize, corner: usize| {
            let offset = self.line_offset(x, edge, free);
            (self.polygon.is_convex_at(corner) == (free > 0.0) && offset.value >= 0.0).then_some(offset)
        };
        [Some(self.line_offset(x, foot.edge, free)), neighbour(before, foot.edge), neighbour(after, after)]
    }
}

/// A point to compare with a loop.
pub(super) struct Query {
    pub(super) vertex: usize,
    pub(super) x: Vector2<f64>,
    /// How far the vertex is from its aligned place.
    pub(super) moved: Vector2<f64>,
    /// Heights of the loop that count.
    pub(super) range: (f64, f64),
    /// +1 if the free side is the inside of the loop, else −1.
    pub(super) free: f64,
}

/// Most that the map displaces a point of an outline, attained at a vertex of its hull.
pub(super) fn displacement(polygon: &Polygon, hull: &[usize], linear: &Matrix2<f64>, offset: &Vector2<f64>) -> f64 {
    let change = linear - Matrix2::identity();
    let place = |i: usize| (change * polygon.vertices()[i].coords + offset).norm_squared();
    (-hull.iter().fold(0.0, |most, &i| lesser(-place(i), most))).sqrt()
}

/// An outline in its own plane.
pub(super) fn still<'a>(polygon: &'a Polygon, near: &'a VertexEdgeBounds) -> ProjectedPolygon<'a> {
    ProjectedPolygon {
        polygon,
        linear: Matrix2::identity(),
        offset: Vector2::zeros(),
        slope: Vector2::zeros(),
        height: 0.0,
        moved: 0.0,
        turn: 1.0,
        near,
    }
}
