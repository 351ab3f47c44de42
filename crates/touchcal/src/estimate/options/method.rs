//! The search for the minimum of the cost.

use serde::{Deserialize, Serialize};

/// How the cost is minimized.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Method {
    /// Coarse-to-fine Levenberg–Marquardt (Madsen, Nielsen & Tingleff 2004), with a marginal
    /// likelihood for one-sided contacts, whose minimum Newton's method finds in the end.
    #[default]
    LevenbergMarquardt,
    /// Gradient descent on mean absolute distances, for comparison (Negi, Manyar & Gupta 2025).
    GradientDescent(GradientDescent),
}

/// Optimizer, number and length of the steps of gradient descent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GradientDescent {
    /// Rule by which gradients become steps.
    pub optimizer: Optimizer,
    /// Number of steps; with 0 the parameters stay zero and the search counts as not converged.
    pub steps: usize,
    /// Length of the first step (1, > 0), in units of each parameter's scale (prior standard
    /// deviation, or plausible size without a prior); it decreases to zero as half a cosine.
    pub rate: f64,
    /// Maximum number of contacts used, 0 counting as 1: every n-th of the log, with the least n
    /// that suffices.
    pub contacts: usize,
}

impl GradientDescent {
    /// Every so many contacts of `all` are used.
    pub(crate) fn stride(&self, all: usize) -> usize {
        all.div_ceil(self.contacts.max(1)).max(1)
    }

    /// Number of contacts of `all` that are used.
    pub fn contacts_used(&self, all: usize) -> usize {
        all.div_ceil(self.stride(all))
    }
}

impl Default for GradientDescent {
    /// Adam, 5000 steps, the first of 5 % of a plausible size, on 500 contacts.
    fn default() -> Self {
        GradientDescent { optimizer: Optimizer::Adam, steps: 5000, rate: 0.05, contacts: 500 }
    }
}

/// Rule of gradient descent's steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Optimizer {
    /// Against the gradient, divided by the norm of the first gradient.
    Plain,
    /// Adam (Kingma & Ba 2015, algorithm 1).
    Adam,
}
