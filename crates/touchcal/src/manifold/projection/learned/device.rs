//! Devices that training can run on.

use std::fmt;

/// Device that training runs on; the processor by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Device {
    /// The processor, always available.
    #[default]
    Cpu,
    /// The first NVIDIA GPU, through CUDA; with the cargo feature `cuda`.
    Cuda,
    /// The default adapter of wgpu, through Vulkan, Metal or DirectX 12; with the cargo feature
    /// `wgpu`.
    Wgpu,
}

/// Why a device cannot be used, as [`probe`](super::probe) or a training on it finds.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// The device needs the cargo feature of its name, which this build lacks.
    #[error("this build has no {device}: build with --features {feature}", feature = .device.name())]
    NotBuilt {
        /// Device that was asked for.
        device: Device,
    },
    /// The machine lacks the device, or a driver or library that the device needs.
    #[error("{device} does not work here; it needs {needed}", needed = .device.needed())]
    Unusable {
        /// Device that was asked for.
        device: Device,
    },
    /// The device reported an error during computation.
    #[error("{device} failed: {message}")]
    Failed {
        /// Device that failed.
        device: Device,
        /// Error message of the device's driver or library.
        message: String,
    },
}

impl Device {
    /// All devices, whether or not this build and this machine have them; the processor first.
    pub const ALL: [Device; 3] = [Device::Cpu, Device::Cuda, Device::Wgpu];

    /// Name of the device in lower case ("cpu", "cuda", "wgpu"), which is also that of its cargo
    /// feature; the processor needs none.
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
