//! How well an arm should explain contacts that it was not calibrated with: from the noise and from
//! what a calibration leaves uncertain.
//!
//! The residual of contact `i` is `rᵢ = nᵢ + Jᵢ δ`, with noise `nᵢ` of covariance `Dᵢ` and the
//! errors `δ` of the calibrated parameters, of covariance `Σ` and common to all contacts. The sum
//! `S = Σᵢ ‖rᵢ‖²` over contacts has, with `M = Σᵢ JᵢᵀJᵢ`,
//!
//! - expectation `Σᵢ tr Dᵢ + tr ΣM`,
//! - variance `Σᵢ (2 tr Dᵢ² + 4 tr Dᵢ Jᵢ Σ Jᵢᵀ) + 2 tr (ΣM)²`,
//!
//! and nearly the distribution of a multiple of χ² that has both.
//!
//! Source: Box, *Some theorems on quadratic forms applied in the study of analysis of variance
//! problems, I* (1954), theorem 3.1.

mod arm_fit;
mod distances;
mod held_out;
mod least_gap;
mod location;
mod new_contacts;
mod place_fit;
mod prediction_model;
mod scatter;

pub use arm_fit::arm_fit;
pub use held_out::evaluate_held_out;
pub(super) use held_out::held_out;
pub(super) use new_contacts::new_contacts;
pub(super) use place_fit::with_fitted_places;
