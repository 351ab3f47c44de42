//! Contact manifolds that are known by poses on them: projection onto recorded samples, or by a
//! network that learned it.

pub mod coordinates;
mod coverage;
#[cfg(feature = "learned")]
pub mod learned;
mod nearest;
mod projected;
mod samples;
mod training_pairs;
mod tree;

pub use coverage::{Coverage, Quantiles};
pub use nearest::{NearestSample, Neighbour};
pub use projected::{Projected, Projection};
pub use samples::{PoseSamples, SamplesError};
pub use training_pairs::TrainingPairs;
