//! Adam, fused with the gradient: a block of weights moves as soon as its gradient is known, while
//! both are in the cache.

use rayon::prelude::*;

use super::network::{CHUNK, Layer, Network, Tape, bias_gradient, weight_gradient};
use crate::solver::Adam;

const ADAM: Adam = Adam { beta1: 0.9, beta2: 0.999, epsilon: 1e-8 };
pub(super) const KEEP_FIRST: f32 = ADAM.beta1 as f32;
pub(super) const KEEP_SECOND: f32 = ADAM.beta2 as f32;
pub(super) const TAKE_FIRST: f32 = (1.0 - ADAM.beta1) as f32;
pub(super) const TAKE_SECOND: f32 = (1.0 - ADAM.beta2) as f32;

/// State of the optimizer Adam: running means of the gradient and of its square, not bias-corrected
/// (Kingma & Ba 2015, arXiv 1412.6980).
#[derive(Clone, Debug, PartialEq)]
pub struct AdamState {
    /// Running mean of the gradient by each weight and bias, shaped as the network's layers.
    pub first: Vec<Layer>,
    /// Running mean of the squared gradient by each weight and bias, shaped as the network's
    /// layers.
    pub second: Vec<Layer>,
    /// Number of steps done; 0 before the first.
    pub steps: u64,
}

impl AdamState {
    /// The state before the first step: zeros in the shape of the network's layers.
    pub fn new(network: &Network) -> AdamState {
        let zeros: Vec<Layer> = network.layers().iter().map(|l| Layer::zeros(l.inputs(), l.outputs())).collect();
        AdamState { first: zeros.clone(), second: zeros, steps: 0 }
    }

    /// Moves the weights by one step along the gradient that `tapes` hold.
    pub(super) fn step(&mut self, network: &mut Network, tapes: &[Tape], rate: f64) {
        self.steps += 1;
        let step = Step::new(rate, self.steps);
        let layers = network.layers_mut().par_iter_mut().zip(&mut self.first).zip(&mut self.second).enumerate();
        layers.for_each(|(l, ((layer, first), second))| {
            let block = CHUNK * layer.inputs();
            let (weights, bias) = layer.parts_mut();
            let ((first, first_bias), (second, second_bias)) = (first.parts_mut(), second.parts_mut());
            let blocks =
                weights.par_chunks_mut(block).zip(first.par_chunks_mut(block)).zip(second.par_chunks_mut(block));
            blocks.enumerate().for_each_init(Vec::new, |gradient, (k, ((weights, first), second))| {
                gradient.resize(weights.len(), 0.0);
                weight_gradient(tapes, l, k * CHUNK, gradient);
                step.apply(weights, first, second, gradient);
            });
            step.apply(bias, first_bias, second_bias, &bias_gradient(tapes, l));
        });
    }
}

/// A step's numbers in single precision.
pub(super) struct Step {
    /// Learning rate with Adam's correction of the bias of the means.
    pub rate: f32,
    /// Term that keeps the division by small gradients finite, with the same correction.
    pub epsilon: f32,
}

impl Step {
    /// Step number `t` (from 1) with this learning rate.
    pub fn new(rate: f64, t: u64) -> Step {
        let step = ADAM.step(rate, t);
        Step { rate: step.rate as f32, epsilon: step.epsilon as f32 }
    }

    fn apply(&self, weights: &mut [f32], first: &mut [f32], second: &mut [f32], gradient: &[f32]) {
        for (((w, m), v), g) in weights.iter_mut().zip(first).zip(second).zip(gradient) {
            *m = KEEP_FIRST * *m + TAKE_FIRST * g;
            *v = KEEP_SECOND * *v + TAKE_SECOND * g * g;
            *w -= self.rate * *m / (v.sqrt() + self.epsilon);
        }
    }
}
