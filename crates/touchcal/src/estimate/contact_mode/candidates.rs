//! The candidate contacts of one pose.

use nalgebra::{SMatrix, SVector};

use crate::manifold::MAX_ROWS;

/// One number for each candidate contact.
pub(crate) type CandidateVector<const N: usize = MAX_ROWS> = SVector<f64, N>;
/// One number for each pair of candidate contacts.
pub(crate) type CandidateMatrix<const N: usize = MAX_ROWS> = SMatrix<f64, N, N>;

/// The candidate contacts of one pose, the first `count` of each array.
pub(crate) struct CandidateContacts {
    /// Number of candidates, at most [`MAX_ROWS`].
    pub count: usize,
    /// Signed distance (m) of each candidate, negative in penetration.
    pub distances: CandidateVector,
    /// Covariance of the distances' noise (m²).
    pub covariance: CandidateMatrix,
    /// Odds `κⱼ` (m) of each candidate's surface.
    pub odds: CandidateVector,
    /// Odds `η` of no contact (1).
    pub no_contact: f64,
    /// Whether derivatives by `ln κⱼ` are needed, as for the covariance.
    pub with_odds_derivatives: bool,
}
