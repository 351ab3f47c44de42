//! How to train, and all that training needs to go on.

use std::f64::consts::PI;

use super::adam::AdamState;
use super::network::Network;
use super::scaling::{Output, Scaling};

/// Share of the steps in which the rate rises from zero.
const WARM_UP: f64 = 0.02;
/// Rate at the end, as a share of the greatest.
const FINAL_RATE: f64 = 1e-3;

/// How to learn.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingOptions {
    /// Width of each hidden layer.
    pub hidden: Vec<usize>,
    /// What outputs stand for.
    pub output: Output,
    /// Pairs a step.
    pub batch: usize,
    /// Steps in all.
    pub steps: u64,
    /// Greatest learning rate. It rises linearly in the first 2 % of the steps and then falls to a
    /// thousandth along a cosine (Loshchilov & Hutter 2017, arXiv 1608.03983).
    pub rate: f64,
    /// Different pairs to learn from, rounded up to whole batches; they are taken in turn, again
    /// and again.
    pub pairs: u64,
    /// Held-out pairs on which the best weights are chosen.
    pub held_out: usize,
    /// Steps between two looks at them.
    pub check_every: u64,
    /// Looks in a row that may find no better weights before training stops early; 0 to go on
    /// always.
    pub patience: u64,
    /// Seed of the first weights; the pairs have their own.
    pub seed: u64,
}

impl Default for TrainingOptions {
    /// A network of four layers of 512 that learns in minutes on two cores.
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
    /// Learning rate of step `k`, the first one being 0.
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

/// The best weights so far.
#[derive(Clone, Debug, PartialEq)]
pub struct BestWeights {
    /// The weights.
    pub network: Network,
    /// Their loss on the held-out pairs.
    pub loss: f64,
    /// Steps after which they were found.
    pub step: u64,
}

/// All that training needs to go on: from the same one, the same weights follow, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// How to learn.
    pub options: TrainingOptions,
    /// What the network's numbers mean.
    pub scaling: Scaling,
    /// The weights.
    pub network: Network,
    /// Running means of the gradients, and the number of steps done.
    pub adam: AdamState,
    /// The best weights, after the first look at the held-out pairs.
    pub best: Option<BestWeights>,
}
