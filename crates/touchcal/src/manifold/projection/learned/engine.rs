//! The arithmetic of training, on the processor or elsewhere.

use std::fmt::Debug;

use super::checkpoint::Checkpoint;
use super::device::DeviceError;
use super::pair_set::Batch;

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
