//! Progress of a running estimation.

use serde::{Deserialize, Serialize};

/// Stage of a running estimation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// Levenberg–Marquardt on the distances of the contacts from the manifolds' envelopes.
    Coarse,
    /// Levenberg–Marquardt, expectation–maximisation or Newton's method on the residuals or
    /// likelihoods of contacts.
    Fine,
    /// Gradient descent on mean absolute distances
    /// ([`Method::GradientDescent`](crate::estimate::Method)).
    Descent,
}

/// Progress of a running estimation, passed to its observer at each step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Stage of the estimation.
    pub stage: Stage,
    /// Linearizations so far in the present minimization, or iterations of
    /// expectation–maximisation or Newton's method, from 1; steps from 1 in [`Stage::Descent`].
    pub iteration: usize,
    /// Cost at the present parameters (1), the one that [`calibrate`](crate::estimate::calibrate())
    /// minimizes in this stage; in [`Stage::Descent`] the loss (m).
    pub cost: f64,
}

/// Called at each step of an estimation; may end it.
pub(crate) type Observer<'o> = &'o mut dyn FnMut(&Progress) -> std::ops::ControlFlow<()>;
