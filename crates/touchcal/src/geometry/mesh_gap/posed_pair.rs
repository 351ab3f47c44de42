//! Two bodies at a pose.

use std::cell::Cell;

use nalgebra::{Matrix3, Vector3};

use super::edge_pair::EdgePair;
use crate::geometry::mesh::{Bvh, ConvexEdge, LeafPair, MeshFeatures, TriangleMesh, leaf_pairs};

/// A body at a pose relative to another.
#[derive(Clone, Copy)]
pub(super) struct PosedPair<'a> {
    pub(super) body: &'a TriangleMesh,
    pub(super) other: &'a TriangleMesh,
    /// From this body's frame to the other's.
    pub(super) rotation: Matrix3<f64>,
    pub(super) translation: Vector3<f64>,
}

impl<'a> PosedPair<'a> {
    /// The other body beside this one.
    pub(super) fn swapped(&self) -> Self {
        PosedPair {
            body: self.other,
            other: self.body,
            rotation: self.rotation.transpose(),
            translation: -self.rotation.tr_mul(&self.translation),
        }
    }

    /// What of this body can touch, in its own frame.
    #[inline]
    pub(super) fn own(&self) -> &'a MeshFeatures {
        &self.body.features
    }

    /// What of the other can touch.
    #[inline]
    pub(super) fn others(&self) -> &'a MeshFeatures {
        &self.other.features
    }

    /// A vertex, in the other's frame.
    #[inline]
    pub(super) fn vertex(&self, vertex: u32) -> Vector3<f64> {
        self.rotation * self.own().vertices[vertex as usize] + self.translation
    }

    /// The ends of an edge, in the other's frame.
    #[inline]
    pub(super) fn ends(&self, edge: u32) -> [Vector3<f64>; 2] {
        self.own().edges[edge as usize].ends.map(|end| self.vertex(end))
    }

    /// An edge of this body, as the tool's, and one of the other, as the fixture's.
    #[inline]
    pub(super) fn lines(&self, own: &'a ConvexEdge, others: &'a ConvexEdge) -> EdgePair<'a> {
        let fixture_ends = others.ends.map(|end| self.others().vertices[end as usize]);
        EdgePair::new((own, own.ends.map(|end| self.vertex(end))), (others, fixture_ends))
    }

    /// Calls `visit` for what of one of this body's trees is nearer than `reach` to what of one of
    /// the other's: for all that is `known` to be near, if that was looked for before.
    pub(super) fn near(
        &self,
        known: Option<&[LeafPair]>,
        (own, others): (&Bvh, &Bvh),
        reach: &Cell<f64>,
        mut visit: impl FnMut(u32, u32),
    ) {
        match known {
            Some(pairs) => pairs.iter().for_each(|&(of_own, of_other)| visit(of_own, of_other)),
            None => leaf_pairs(own, (&self.rotation, &self.translation), others, reach, visit),
        }
    }
}
