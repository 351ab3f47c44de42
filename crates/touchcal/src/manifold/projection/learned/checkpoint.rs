//! How to train, and all that training needs to go on.

use std::f64::consts::PI;

use super::adam::AdamState;
use super::network::Network;
use super::scaling::{Output, Scaling};

/// Share of the steps in which the rate rises from zero.
const WARM_UP: f64 = 0.02;
/// Rate at the end, as a share of the greatest.
const FINAL_RATE: f64 = 1e-3;

/// Options of training a network; all numbers but `patience` and `seed` must be above zero, and the
/// rate finite, which [`Training::start`](super::Training::start) checks.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingOptions {
    /// Width of each hidden layer, from input to output; empty for a linear map. Inputs and outputs
    /// are six each.
    pub hidden: Vec<usize>,
    /// Quantity that the network's outputs represent.
    pub output: Output,
    /// Number of pairs in each step (a batch).
    pub batch: usize,
    /// Total number of steps, those before a checkpoint included.
    pub steps: u64,
    /// Peak learning rate of Adam (no unit): about the change of a weight in a step. It rises
    /// linearly in the first 2 % of the steps and then falls to a thousandth along a cosine
    /// (Loshchilov & Hutter 2017, arXiv 1608.03983).
    pub rate: f64,
    /// Number of different pairs to learn from, rounded up to whole batches; they are taken in turn
    /// and repeated.
    pub pairs: u64,
    /// Number of held-out pairs on which the best weights are chosen.
    pub held_out: usize,
    /// Steps between two evaluations on the held-out pairs; the last step is always followed by
    /// one.
    pub check_every: u64,
    /// Number of successive evaluations on the held-out pairs without better weights after which
    /// training stops early; 0 never stops early.
    pub patience: u64,
    /// Seed of the initial weights; the pairs have a seed of their own.
    pub seed: u64,
}

impl Default for TrainingOptions {
    /// A network of four layers of 512 whose outputs are poses, 20 000 steps of 1024 pairs, at a
    /// rate of 1e-3, among 2²⁰ pairs, 8192 held out and looked at every 500 steps, without
    /// patience: minutes on two cores.
    fn default() -> Self {
        TrainingOptions {
            hidden: vec![512; 4],
            output: Output::Pose,
            batch: 1024,
            steps: 20_000,
            rate: 1e-3,
            pairs: 1 << 20,
            held_out: 8192,
            check_every: 500,
            patience: 0,
            seed: 1,
        }
    }
}

impl TrainingOptions {
    /// Learning rate of step `k`, counted from 0: linear rise, then cosine; a thousandth of the
    /// peak from the last step (`k` = `steps` − 1) on.
    pub fn rate_at(&self, k: u64) -> f64 {
        let rise = (WARM_UP * self.steps as f64).max(1.0);
        let done = k as f64 + 1.0;
        if done < rise {
            return self.rate * done / rise;
        }
        let share = ((done - rise) / (self.steps as f64 - rise).max(1.0)).min(1.0);
        self.rate * (FINAL_RATE + (1.0 - FINAL_RATE) * 0.5 * (1.0 + (PI * share).cos()))
    }
}

/// Weights with the least loss on the held-out pairs so far.
#[derive(Clone, Debug, PartialEq)]
pub struct BestWeights {
    /// Network with the least loss on the held-out pairs.
    pub network: Network,
    /// Mean square of the network's output errors over the held-out pairs (no unit);
    /// [`Scaling::distance`] converts it to a distance (m).
    pub loss: f64,
    /// Number of steps after which these weights were found; at most [`AdamState::steps`].
    pub step: u64,
}

/// State of training. From the same checkpoint and [`TrainingSource`](super::TrainingSource) the
/// same weights follow, bit for bit, on the processor.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Options of the training.
    pub options: TrainingOptions,
    /// Conversion between coordinates of poses and the network's inputs and outputs.
    pub scaling: Scaling,
    /// Network with the current weights.
    pub network: Network,
    /// Running means of the gradients, and the number of steps done, with which
    /// [`Training::resume`](super::Training::resume) goes on.
    pub adam: AdamState,
    /// Best weights so far; `None` before the first evaluation on the held-out pairs.
    pub best: Option<BestWeights>,
}
