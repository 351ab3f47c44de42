//! Contact manifolds as poses, samples or networks.

#[cfg(feature = "learned")]
pub mod checkpoint_file;
pub mod manifold_file;
#[cfg(feature = "learned")]
mod network_entry;
#[cfg(feature = "learned")]
mod network_tensors;
#[cfg(feature = "learned")]
pub mod onnx;
pub mod pose_file;
#[cfg(feature = "parquet")]
mod pose_parquet;
mod pose_row;
mod tensor_file;
#[cfg(feature = "learned")]
pub mod weights_file;
