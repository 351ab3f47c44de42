//! Adam (Kingma & Ba, *Adam: a method for stochastic optimization* (2015), algorithm 1).

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Constants of Adam (Kingma & Ba 2015, algorithm 1): decay rates of its running means, and the one
/// that bounds steps where gradients vanish.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adam {
    /// Decay rate β₁ of the running mean of the gradient (1), from 0 to below 1.
    pub beta1: f64,
    /// Decay rate β₂ of the running mean of the squared gradient (1), from 0 to below 1.
    pub beta2: f64,
    /// Constant ε > 0 added to the root of the mean square, in units of the gradient.
    pub epsilon: f64,
}

/// Factors of one step `θ ← θ − rate · m / (√v + epsilon)`, element by element, with the running
/// means `m ← β₁ m + (1 − β₁) g` and `v ← β₂ v + (1 − β₂) g²` of the gradient `g`, both from zero.
/// Their bias corrections are folded into the two factors (Kingma & Ba 2015, end of section 2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdamStep {
    /// Learning rate times `√(1 − β₂ᵗ) / (1 − β₁ᵗ)`, in units of the parameters; `t` is the number
    /// of the step.
    pub rate: f64,
    /// ε times `√(1 − β₂ᵗ)`, in units of the gradient.
    pub epsilon: f64,
}

impl Adam {
    /// Factors of step number `t`, counted from 1 (0 gives a NaN rate), for the learning rate
    /// `rate`: the length of a step along each parameter where the gradient is constant, in units
    /// of the parameters.
    pub fn step(&self, rate: f64, t: u64) -> AdamStep {
        let t = t as f64;
        let root = (1.0 - self.beta2.powf(t)).sqrt();
        AdamStep { rate: rate * root / (1.0 - self.beta1.powf(t)), epsilon: self.epsilon * root }
    }
}

/// Running means of a gradient and of its square, element by element.
#[derive(Clone, Debug)]
pub(crate) struct AdamMoments {
    adam: Adam,
    steps: u64,
    mean: DVector<f64>,
    square: DVector<f64>,
}

impl AdamMoments {
    /// Both means zero, for `size` parameters.
    pub fn new(adam: Adam, size: usize) -> Self {
        AdamMoments { adam, steps: 0, mean: DVector::zeros(size), square: DVector::zeros(size) }
    }

    /// The next step's direction for a learning rate of one, of about unit entries; the step is
    /// against it. `gradient` has one entry for each parameter, as many as given to
    /// [`AdamMoments::new`].
    pub fn direction(&mut self, gradient: &DVector<f64>) -> DVector<f64> {
        let Adam { beta1, beta2, .. } = self.adam;
        self.steps += 1;
        self.mean = &self.mean * beta1 + gradient * (1.0 - beta1);
        self.square = &self.square * beta2 + gradient.component_mul(gradient) * (1.0 - beta2);
        let step = self.adam.step(1.0, self.steps);
        self.mean.zip_map(&self.square, |mean, square| step.rate * mean / (square.sqrt() + step.epsilon))
    }
}
