//! The arithmetic of training, on the processor or elsewhere.

use std::fmt::Debug;

use rayon::prelude::*;

use super::device::DeviceError;
use super::network::{Back, Tape};
use super::pair_set::Batch;
use super::training::Checkpoint;

/// Weights and gradients' means that move. They may be held elsewhere than in the checkpoint until
/// they are read back.
pub(super) trait Engine: Debug + Send {
    /// One step of Adam at this rate; the loss before it.
    fn step(&mut self, state: &mut Checkpoint, batch: &Batch<'_>, rate: f64) -> Result<f64, DeviceError>;

    /// The loss, without a step.
    fn loss(&mut self, state: &Checkpoint, batch: &Batch<'_>) -> Result<f64, DeviceError>;

    /// Brings `state` up to date: the weights, the means, the number of steps.
    fn read(&mut self, state: &mut Checkpoint) -> Result<(), DeviceError>;
}

/// On the processor: what moves is the checkpoint itself.
#[derive(Debug, Default)]
pub(super) struct Cpu {
    tapes: Vec<Tape>,
}

impl Engine for Cpu {
    fn step(&mut self, state: &mut Checkpoint, batch: &Batch<'_>, rate: f64) -> Result<f64, DeviceError> {
        let Checkpoint { network, adam, .. } = state;
        let loss = batch.loss(network, &mut self.tapes);
        self.tapes.par_iter_mut().for_each(|tape| network.run_back(&tape.values, &mut tape.deltas, Back::ToWeights));
        adam.step(network, &self.tapes, rate);
        Ok(loss)
    }

    fn loss(&mut self, state: &Checkpoint, batch: &Batch<'_>) -> Result<f64, DeviceError> {
        Ok(batch.loss(&state.network, &mut self.tapes))
    }

    fn read(&mut self, _: &mut Checkpoint) -> Result<(), DeviceError> {
        Ok(())
    }
}
