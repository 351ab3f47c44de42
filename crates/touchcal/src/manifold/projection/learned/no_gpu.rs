//! In place of `gpu` in a build without GPUs.

use super::checkpoint::Checkpoint;
use super::device::{Device, DeviceError};
use super::engine::Engine;

pub(super) fn probe(device: Device) -> Result<(), DeviceError> {
    Err(DeviceError::NotBuilt { device })
}

pub(super) fn engine(device: Device, _: &Checkpoint) -> Result<Box<dyn Engine>, DeviceError> {
    Err(DeviceError::NotBuilt { device })
}
