//! Progress of a running estimation.

/// A stage of the estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Towards the manifolds' envelopes.
    Coarse,
    /// Onto the manifolds.
    Fine,
    /// Gradient descent.
    Descent,
}

/// Progress of a running estimation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Current stage.
    pub stage: Stage,
    /// Linearizations so far in this stage.
    pub iteration: usize,
    /// Current cost (dimensionless); of gradient descent the loss (m).
    pub cost: f64,
}

/// Called at each step of an estimation; may end it.
pub(crate) type Observer<'o> = &'o mut dyn FnMut(&Progress) -> std::ops::ControlFlow<()>;
