//! Which edges of one outline are near which vertices of another, for exact pruning.

use super::profile::{Profile, distance_to_segment};

/// Edges kept for each vertex. Beyond these a query looks at every edge.
const KEPT: usize = 64;

/// For each vertex of one outline, the edges of another in order of their distance, both in the common frame in which
/// peg and hole are aligned. A vertex moved by `δ` is at least `distance − δ` away from an edge.
#[derive(Clone, Debug)]
pub(super) struct Nearness {
    stride: usize,
    complete: bool,
    edges: usize,
    near: Vec<(f64, u32)>,
}

impl Nearness {
    /// Tabulates the vertices of `of` against the edges of `to`.
    pub(super) fn new(of: &Profile, to: &Profile) -> Self {
        let stride = to.len().min(KEPT);
        let mut near = Vec::with_capacity(of.len() * stride);
        let mut row: Vec<(f64, u32)> = Vec::with_capacity(to.len());
        for vertex in of.vertices() {
            row.clear();
            row.extend((0..to.len()).map(|edge| (distance_to_segment(vertex, to.edge(edge)), edge as u32)));
            if stride < row.len() {
                row.select_nth_unstable_by(stride, |a, b| a.0.total_cmp(&b.0));
            }
            row[..stride].sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            near.extend_from_slice(&row[..stride]);
        }
        Nearness { stride, complete: stride == to.len(), edges: to.len(), near }
    }

    /// Distance of `vertex` from the nearest edge when aligned (m).
    pub(super) fn closest(&self, vertex: usize) -> f64 {
        self.near[vertex * self.stride].0
    }

    /// Calls `visit(edge)` for every edge that can be closer to `vertex` than the limit `visit` last returned, after
    /// the vertex and the edge together moved by at most `moved`.
    #[inline]
    pub(super) fn scan(&self, vertex: usize, moved: f64, mut visit: impl FnMut(usize) -> f64) {
        let mut limit = f64::INFINITY;
        for &(aligned, edge) in &self.near[vertex * self.stride..(vertex + 1) * self.stride] {
            if aligned - moved >= limit {
                return;
            }
            limit = visit(edge as usize);
        }
        if !self.complete {
            for edge in 0..self.edges {
                visit(edge);
            }
        }
    }
}
