//! Projection by a network that learned it from pairs (Negi, Manyar & Gupta 2025, arXiv
//! 2506.17458).
//!
//! Results are the same bits for every number of threads on one kind of processor; between kinds,
//! products of matrices may be summed in another order.

mod accuracy;
mod adam;
mod checkpoint;
mod cpu;
mod device;
mod engine;
mod engine_of;
#[cfg(any(feature = "cuda", feature = "wgpu"))]
mod gpu;
mod learned_projection;
mod network;
#[cfg(not(any(feature = "cuda", feature = "wgpu")))]
mod no_gpu;
mod pair_set;
mod scaling;
mod training;

pub use accuracy::{Accuracy, PoseDistance, Spread, accuracy};
pub use adam::AdamState;
pub use checkpoint::{BestWeights, Checkpoint, TrainingOptions};
pub use device::{Device, DeviceError};
pub use engine_of::probe;
pub use learned_projection::LearnedProjection;
pub use network::{Layer, Network, NetworkError};
pub use pair_set::TrainingSource;
pub use scaling::{Output, Scaling};
pub use training::{Ending, Observer, Progress, Training, TrainingError};

#[cfg(test)]
mod tests;
