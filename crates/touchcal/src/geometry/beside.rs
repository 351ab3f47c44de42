//! A body beside another, in the other's frame.

use std::cell::Cell;

use nalgebra::{Matrix3, Vector3};

use super::boxes::{Tree, near_pairs};
use super::facets::{Edge, Facets};
use super::lines::Lines;
use super::nearby::Pair;
use super::solid::Solid;

/// A body at a place beside another.
#[derive(Clone, Copy)]
pub(super) struct Beside<'a> {
    pub(super) body: &'a Solid,
    pub(super) other: &'a Solid,
    /// From this body's frame to the other's.
    pub(super) rotation: Matrix3<f64>,
    pub(super) translation: Vector3<f64>,
}

impl<'a> Beside<'a> {
    /// The other body beside this one.
    pub(super) fn turned_round(&self) -> Self {
        Beside {
            body: self.other,
            other: self.body,
            rotation: self.rotation.transpose(),
            translation: -self.rotation.tr_mul(&self.translation),
        }
    }

    /// What of this body can touch, in its own frame.
    #[inline]
    pub(super) fn own(&self) -> &'a Facets {
        &self.body.facets
    }

    /// What of the other can touch.
    #[inline]
    pub(super) fn others(&self) -> &'a Facets {
        &self.other.facets
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
    pub(super) fn lines(&self, own: &'a Edge, others: &'a Edge) -> Lines<'a> {
        let fixture_ends = others.ends.map(|end| self.others().vertices[end as usize]);
        Lines::new((own, own.ends.map(|end| self.vertex(end))), (others, fixture_ends))
    }

    /// Calls `visit` for what of one of this body's trees is nearer than `reach` to what of one of
    /// the other's: for all that is `known` to be near, if that was looked for before.
    pub(super) fn near(
        &self,
        known: Option<&[Pair]>,
        (own, others): (&Tree, &Tree),
        reach: &Cell<f64>,
        mut visit: impl FnMut(u32, u32),
    ) {
        match known {
            Some(pairs) => pairs.iter().for_each(|&(of_own, of_other)| visit(of_own, of_other)),
            None => near_pairs(own, (&self.rotation, &self.translation), others, reach, visit),
        }
    }
}
