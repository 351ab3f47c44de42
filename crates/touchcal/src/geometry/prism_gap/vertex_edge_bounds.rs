//! Which edges of one outline are near which vertices of another, for exact pruning.

use crate::geometry::polygon::{Polygon, foot_on_segment};
use nalgebra::{Point2, Vector2};

/// Edges kept for each vertex, at least, and entries of a table up to which it has them all. Beyond
/// those kept a query looks at every edge.
const KEPT: usize = 64;
const ENTRIES: usize = 1 << 17;

/// Edges that every bound looks at: in a T-slot few others are ever near.
const FIRST: usize = 3;

/// Rounding of distances (m) that no edge is left out for.
const SLACK: f64 = 1e-12;

/// An edge near a vertex.
#[derive(Clone, Debug)]
pub(super) struct NearEdge {
    /// Distance (m) when aligned.
    pub(super) aligned: f64,
    /// Unit vector from the edge's nearest point to the vertex when aligned: all of the edge lies
    /// at least `aligned` behind the vertex along it. Not a number if they touch.
    pub(super) away: Vector2<f64>,
    pub(super) edge: u32,
    /// Ends of the edge.
    pub(super) ends: [Vector2<f64>; 2],
}

/// For each vertex or edge of one outline, the edges of another in order of their distance, both in
/// the common frame in which peg and hole are aligned. A vertex moved by `δ` is at least `distance
/// − |δ|` and at least `distance + away · δ` from an edge.
#[derive(Clone, Debug)]
pub(super) struct VertexEdgeBounds {
    stride: usize,
    complete: bool,
    edges: usize,
    near: Vec<NearEdge>,
}

impl VertexEdgeBounds {
    /// Tabulates the vertices of `of` against the edges of `to`.
    pub(super) fn new(of: &Polygon, to: &Polygon) -> Self {
        VertexEdgeBounds::tabulate(of.len(), to, |i, edge| {
            let vertex = &of.vertices()[i];
            vertex - foot_on_segment(vertex, to.edge(edge))
        })
    }

    /// Tabulates the edges of `of` against those of `to`.
    pub(super) fn of_edges(of: &Polygon, to: &Polygon) -> Self {
        VertexEdgeBounds::tabulate(of.len(), to, |i, edge| {
            let ((a, b), (r, s)) = (of.edge(i), to.edge(edge));
            let apart = |p: &Point2<f64>, q: &Point2<f64>, r: &Point2<f64>, s: &Point2<f64>| {
                (q - p).perp(&(r - p)) * (q - p).perp(&(s - p)) < 0.0
            };
            if apart(&a, &b, &r, &s) && apart(&r, &s, &a, &b) {
                return Vector2::zeros();
            }
            let ways = [
                a - foot_on_segment(&a, (r, s)),
                b - foot_on_segment(&b, (r, s)),
                foot_on_segment(&r, (a, b)) - r,
                foot_on_segment(&s, (a, b)) - s,
            ];
            ways.into_iter().fold(ways[0], |least, way| if way.norm() < least.norm() { way } else { least })
        })
    }

    /// Tabulates `count` vertices or edges against the edges of `to`, given the shortest way from
    /// the latter to the former.
    fn tabulate(count: usize, to: &Polygon, way: impl Fn(usize, usize) -> Vector2<f64>) -> Self {
        let stride = to.len().min(KEPT.max(ENTRIES / count));
        let mut near = Vec::with_capacity(count * stride);
        let mut row: Vec<NearEdge> = Vec::with_capacity(to.len());
        for i in 0..count {
            row.clear();
            row.extend((0..to.len()).map(|edge| {
                let away = way(i, edge);
                let aligned = away.norm();
                let (a, b) = to.edge(edge);
                NearEdge { aligned, away: away / aligned, edge: edge as u32, ends: [a.coords, b.coords] }
            }));
            if stride < row.len() {
                row.select_nth_unstable_by(stride, |a, b| a.aligned.total_cmp(&b.aligned));
            }
            row[..stride].sort_unstable_by(|a, b| a.aligned.total_cmp(&b.aligned));
            near.extend_from_slice(&row[..stride]);
        }
        VertexEdgeBounds { stride, complete: stride == to.len(), edges: to.len(), near }
    }

    /// Edges near a vertex, nearest first.
    fn row(&self, vertex: usize) -> &[NearEdge] {
        &self.near[vertex * self.stride..(vertex + 1) * self.stride]
    }

    /// The edges whose distance when aligned is below `limit` (m); more if not all distances are
    /// tabulated.
    pub(super) fn within(&self, of: usize, limit: f64) -> impl Iterator<Item = usize> {
        let row = self.row(of);
        let all = !self.complete && row[row.len() - 1].aligned < limit;
        let near = if all { &[] } else { &row[..row.partition_point(|near| near.aligned < limit)] };
        near.iter().map(|near| near.edge as usize).chain(0..if all { self.edges } else { 0 })
    }

    /// Distance of `vertex` from the nearest edge when aligned (m).
    pub(super) fn closest(&self, vertex: usize) -> f64 {
        self.row(vertex)[0].aligned
    }

    /// Calls `visit(edge)` for every edge that can be closer to `vertex` than `limit`, which each
    /// visit returns anew, where `moved` and `parted` are those of [`VertexEdgeBounds::bound`].
    #[inline]
    pub(super) fn scan(
        &self,
        vertex: usize,
        (mut limit, moved): (f64, f64),
        parted: impl Fn(&NearEdge) -> f64,
        mut visit: impl FnMut(usize) -> f64,
    ) {
        for near in self.row(vertex) {
            if near.aligned - moved >= limit {
                return;
            }
            if near.aligned + parted(near) < limit + SLACK || near.aligned == 0.0 {
                limit = visit(near.edge as usize);
            }
        }
        if !self.complete {
            for edge in 0..self.edges {
                visit(edge);
            }
        }
    }

    /// A lower bound of the distance of `vertex` from all edges, where `parted` returns how much
    /// farther along [`NearEdge::away`] vertex and edge at least are than when aligned, having
    /// moved by at most `moved` together.
    ///
    /// While it is positive, no edge passes the vertex on the straight way from the aligned place:
    /// the vertex stays on the side of the outline where it is when aligned. Negative, it bounds
    /// nothing.
    #[inline]
    pub(super) fn bound(&self, vertex: usize, moved: f64, parted: impl Fn(&NearEdge) -> f64) -> f64 {
        let mut bound = f64::INFINITY;
        let row = self.row(vertex);
        // The first few without a branch.
        let mut rest = row;
        if let Some((first, others)) = row.split_first_chunk::<FIRST>() {
            for near in first {
                bound = lesser(near.aligned + parted(near), bound);
            }
            rest = others;
        }
        for near in rest {
            if near.aligned - moved >= bound || bound < 0.0 {
                return bound;
            }
            bound = lesser(near.aligned + parted(near), bound);
        }
        if self.complete { bound } else { bound.min(row[row.len() - 1].aligned - moved) }
    }
}

/// The lesser of two numbers; the second if one is not a number.
#[inline]
pub(super) fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
