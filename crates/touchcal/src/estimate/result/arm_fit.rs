//! Whether an arm meets the fixtures of its problem.

/// Whether the contacts of an arm are where its fixtures are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArmFit {
    /// Contacts are as near to their manifolds as noise and tolerances allow.
    Met,
    /// The arm misses a fixture: it is not calibrated, or the problem does not describe what it
    /// touched.
    Missed {
        /// Index of the fixture in [`Problem::fixtures`](crate::estimate::Problem::fixtures), the
        /// one that is missed most.
        fixture: usize,
        /// Root mean square distance of its contacts from its manifold (m).
        found: f64,
        /// Distance that noise and declared tolerances allow (m).
        allowed: f64,
    },
    /// No fixture with contacts has a known shape at a bounded place.
    Unknown,
}
