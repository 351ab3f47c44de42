//! Which edges of one outline are near which vertices of another, for exact pruning.

use super::profile::{Profile, foot_on_segment};
use nalgebra::Vector2;

/// Edges kept for each vertex. Beyond these a query looks at every edge.
const KEPT: usize = 64;

/// Rounding of distances (m) that no edge is left out for.
const SLACK: f64 = 1e-12;

/// An edge near a vertex.
#[derive(Clone, Debug)]
pub(super) struct Neighbour {
    /// Distance (m) when aligned.
    pub(super) aligned: f64,
    /// Unit vector from the edge's nearest point to the vertex when aligned: all of the edge lies at least `aligned`
    /// behind the vertex along it. Not a number if they touch.
    pub(super) away: Vector2<f64>,
    pub(super) edge: u32,
}

/// For each vertex of one outline, the edges of another in order of their distance, both in the common frame in which
/// peg and hole are aligned. A vertex moved by `δ` is at least `distance − |δ|` and at least `distance + away · δ` from
/// an edge.
#[derive(Clone, Debug)]
pub(super) struct Nearness {
    stride: usize,
    complete: bool,
    edges: usize,
    near: Vec<Neighbour>,
}

impl Nearness {
    /// Tabulates the vertices of `of` against the edges of `to`.
    pub(super) fn new(of: &Profile, to: &Profile) -> Self {
        let stride = to.len().min(KEPT);
        let mut near = Vec::with_capacity(of.len() * stride);
        let mut row: Vec<Neighbour> = Vec::with_capacity(to.len());
        for vertex in of.vertices() {
            row.clear();
            row.extend((0..to.len()).map(|edge| {
                let away = vertex - foot_on_segment(vertex, to.edge(edge));
                let aligned = away.norm();
                Neighbour { aligned, away: away / aligned, edge: edge as u32 }
            }));
            if stride < row.len() {
                row.select_nth_unstable_by(stride, |a, b| a.aligned.total_cmp(&b.aligned));
            }
            row[..stride].sort_unstable_by(|a, b| a.aligned.total_cmp(&b.aligned));
            near.extend_from_slice(&row[..stride]);
        }
        Nearness { stride, complete: stride == to.len(), edges: to.len(), near }
    }

    /// Edges near a vertex, nearest first.
    fn row(&self, vertex: usize) -> &[Neighbour] {
        &self.near[vertex * self.stride..(vertex + 1) * self.stride]
    }

    /// Distance of `vertex` from the nearest edge when aligned (m).
    pub(super) fn closest(&self, vertex: usize) -> f64 {
        self.row(vertex)[0].aligned
    }

    /// Calls `visit(edge)` for every edge that can be closer to `vertex` than the limit `visit` last returned, where `moved` and
    /// `parted` are those of [`Nearness::bound`].
    #[inline]
    pub(super) fn scan(
        &self,
        vertex: usize,
        moved: f64,
        parted: impl Fn(&Neighbour) -> f64,
        mut visit: impl FnMut(usize) -> f64,
    ) {
        let mut limit = f64::INFINITY;
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

    /// A lower bound of the distance of `vertex` from all edges, where `parted` returns how much farther along
    /// [`Neighbour::away`] vertex and edge at least are than when aligned, having moved by at most `moved` together.
    ///
    /// While it is positive, no edge passes the vertex on the straight way from the aligned place: the vertex stays on the
    /// side of the outline where it is when aligned. Negative, it bounds nothing.
    #[inline]
    pub(super) fn bound(&self, vertex: usize, moved: f64, parted: impl Fn(&Neighbour) -> f64) -> f64 {
        let mut bound = f64::INFINITY;
        let row = self.row(vertex);
        for near in row {
            if near.aligned - moved >= bound || bound < 0.0 {
                return bound;
            }
            bound = bound.min(near.aligned + parted(near));
        }
        if self.complete { bound } else { bound.min(row[row.len() - 1].aligned - moved) }
    }
}
