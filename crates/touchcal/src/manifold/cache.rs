//! What is reused from one evaluation of a contact to the next.

use crate::geometry::NeighborList;

/// What manifolds keep of one contact between evaluations at nearby poses.
///
/// Speed depends on the cache, results do not, to the bit. A cache belongs to one contact of one
/// manifold.
#[derive(Clone, Debug, Default)]
pub struct ContactCache {
    /// Pairs of features of tool and fixture that are near each other.
    pub(super) neighbors: Option<Box<NeighborList>>,
}
