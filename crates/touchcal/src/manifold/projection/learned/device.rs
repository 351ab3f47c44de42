//! What training runs on.

use std::fmt;

/// What training runs on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Device {
    /// The processor, by this crate's own engine.
    #[default]
    Cpu,
    /// The first NVIDIA GPU, through CUDA; with the cargo feature `cuda`.
    Cuda,
    /// The fastest GPU there is, through Vulkan, Metal or DirectX 12; with the cargo feature
    /// `wgpu`.
    Wgpu,
}

/// Why a device cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// Its cargo feature is off.
    #[error("this build has no {device}: build with --features {feature}", feature = .device.name())]
    NotBuilt {
        /// The device.
        device: Device,
    },
    /// This machine lacks it, or something that it needs.
    #[error("{device} does not work here; it needs {needed}", needed = .device.needed())]
    Unusable {
        /// The device.
        device: Device,
    },
    /// It fails at its work.
    #[error("{device} failed: {message}")]
    Failed {
        /// The device.
        device: Device,
        /// What it says.
        message: String,
    },
}

impl Device {
    /// All there are.
    pub const ALL: [Device; 3] = [Device::Cpu, Device::Cuda, Device::Wgpu];

    /// What it is called, as is the cargo feature it needs.
    pub fn name(self) -> &'static str {
        match self {
            Device::Cpu => "cpu",
            Device::Cuda => "cuda",
            Device::Wgpu => "wgpu",
        }
    }

    fn needed(self) -> &'static str {
        match self {
            Device::Cpu => "nothing",
            Device::Cuda => {
                "an NVIDIA GPU, its driver, and CUDA's run-time compiler with its headers (CUDA_PATH, or /usr/local/cuda)"
            }
            Device::Wgpu => "a driver for Vulkan, Metal or DirectX 12",
        }
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Device::Cpu => "CPU",
            Device::Cuda => "CUDA",
            Device::Wgpu => "wgpu",
        })
    }
}
