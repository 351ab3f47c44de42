//! Which cost of the contacts is minimized.

use crate::solver::Loss;

/// Which cost of the contacts is minimized.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Objective {
    /// Squared distance from the manifolds' envelopes, in their own scale.
    Envelope,
    /// Whitened residuals with this loss.
    Residual(Loss),
    /// Marginal likelihood of one-sided contacts; of others whitened residuals with the problem's
    /// loss.
    ContactModes,
}
