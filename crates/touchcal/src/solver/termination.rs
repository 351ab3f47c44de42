//! Why and where a minimization stopped.

use serde::{Deserialize, Serialize};

/// Why a minimization stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StopReason {
    /// The measured quantity of [`Termination`] reached its threshold; or that quantity was within
    /// ten times the threshold where no step lowered the cost, on a kink of the cost.
    Converged,
    /// The maximum number of iterations came before the threshold was reached; in gradient descent,
    /// the threshold was not reached after all steps.
    IterationLimit,
    /// No step, however short, lowered the cost, and the threshold was not reached.
    NoDescent,
    /// The cost was NaN or infinite: at the start, or at a step of gradient descent.
    /// Levenberg–Marquardt takes no step to such a cost.
    NotFinite,
    /// The observer ended the minimization.
    Interrupted,
}

impl StopReason {
    /// Name in files: `converged`, `iteration_limit`, `no_descent`, `not_finite`, `interrupted`.
    pub fn name(self) -> &'static str {
        match self {
            StopReason::Converged => "converged",
            StopReason::IterationLimit => "iteration_limit",
            StopReason::NoDescent => "no_descent",
            StopReason::NotFinite => "not_finite",
            StopReason::Interrupted => "interrupted",
        }
    }
}

/// Reason, accuracy and number of iterations at which a minimization stopped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Termination {
    /// Why the minimization stopped.
    pub reason: StopReason,
    /// Newton decrement `gᵀH⁻¹g` of the last step (1, in units of the cost), with half the cost's
    /// gradient `g` and the information `H`; infinite before the first step. With the observed
    /// information of contact modes, that which is left after the last step. In gradient descent,
    /// the share of the loss (0 to 1) by which a further step would lower it, and 0 if it was
    /// interrupted or not finite.
    pub measured: f64,
    /// Value of `measured`, in its unit, at or below which the minimization has converged.
    pub threshold: f64,
    /// Number of linearizations in all stages, or of steps in gradient descent.
    pub iterations: usize,
}
