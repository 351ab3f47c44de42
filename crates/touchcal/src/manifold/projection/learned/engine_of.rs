//! The engine of a device.

use super::checkpoint::Checkpoint;
use super::cpu::Cpu;
use super::device::{Device, DeviceError};
use super::engine::Engine;
#[cfg(any(feature = "cuda", feature = "wgpu"))]
use super::gpu;
#[cfg(not(any(feature = "cuda", feature = "wgpu")))]
use super::no_gpu as gpu;

/// Checks that this build and this machine have a device, by adding two numbers on it.
///
/// # Errors
/// [`DeviceError::NotBuilt`] without the device's cargo feature, [`DeviceError::Unusable`] without
/// device, driver or library, [`DeviceError::Failed`] if the device reports an error or a wrong
/// sum. None for [`Device::Cpu`].
pub fn probe(device: Device) -> Result<(), DeviceError> {
    if device == Device::Cpu { Ok(()) } else { gpu::probe(device) }
}

/// Arithmetic on a device, beginning with the weights and means of `state`.
pub(super) fn engine_of(device: Device, state: &Checkpoint) -> Result<Box<dyn Engine>, DeviceError> {
    if device == Device::Cpu { Ok(Box::new(Cpu::default())) } else { gpu::engine(device, state) }
}
