//! Why and where a minimization stopped.

/// Why a minimization stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The measured quantity of [`Termination`] fell below its threshold.
    Converged,
    /// The iteration limit came first.
    IterationLimit,
    /// No step, however short, lowered the cost.
    NoDescent,
    /// The cost became NaN or infinite.
    NotFinite,
    /// The caller asked to stop.
    Interrupted,
}

impl StopReason {
    /// The reason as written in files: `converged`, `iteration_limit`, …
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

/// Why and where a minimization stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Termination {
    /// Why.
    pub reason: StopReason,
    /// Newton decrement `gᵀH⁻¹g` of the last step (in units of the cost, dimensionless); of
    /// gradient descent, the share of the loss that a further step would take off.
    pub measured: f64,
    /// Value below which `measured` counts as converged.
    pub threshold: f64,
    /// Linearizations of all stages, or steps of gradient descent.
    pub iterations: usize,
}
