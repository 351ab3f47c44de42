//! The arithmetic of training on the processor.

use rayon::prelude::*;

use super::checkpoint::Checkpoint;
use super::device::DeviceError;
use super::engine::Engine;
use super::network::{Back, Tape};
use super::pair_set::Batch;

/// Training on the processor: what moves is the checkpoint itself.
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
