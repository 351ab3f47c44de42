//! What is reused from one evaluation of a contact to the next.

use crate::geometry::NeighborList;

/// What a manifold keeps of one contact between evaluations by
/// [`ContactManifold::candidate_contacts`](super::ContactManifold::candidate_contacts) at nearby
/// poses; empty by default.
///
/// A cache changes the speed of an evaluation, never its result, to the bit. Each contact of each
/// manifold needs a cache of its own.
#[derive(Clone, Debug, Default)]
pub struct ContactCache {
    /// Pairs of features of tool and fixture that are near each other.
    pub(super) neighbors: Option<Box<NeighborList>>,
}
