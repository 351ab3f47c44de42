//! Tolerances that searches for pairs of features share.

/// Sine of the angle by which a vertex or edge may lean over the feature it is compared with: the
/// nearer feature beside it differs by less than noise.
pub(super) const LEANING: f64 = 0.3;
/// Distances (m) up to this are contact, be the bodies free or overlapping.
pub(super) const TOUCHING: f64 = 1e-12;
/// How far beyond a concave edge a face still counts, as a share of the distance from it: a tilt
/// makes right angles a little obtuse.
pub(super) const PAST_EDGE: f64 = 0.01;
