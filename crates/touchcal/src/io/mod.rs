//! Files: bytes in, types out, and back. Nothing is computed here.
//!
//! | module | reads | into |
//! |---|---|---|
//! | [`urdf`] | a robot description | [`Robot`](crate::robot::Robot), and writes a calibrated one back into the text |
//! | [`contact_log`] | joint logs: [`contact_csv`], Parquet, ROS 2 bags | [`ContactLog`](crate::contact::ContactLog) |
//! | [`problem_file`] | `problem.toml` and what it refers to | [`Problem`](crate::estimate::Problem) |
//! | [`outline`] | outlines as CSV, SVG or DXF | [`Profile`](crate::geometry::profile::Profile) |
//! | [`mesh`] | bodies as STL or OBJ | [`Solid`](crate::geometry::solid::Solid) |
//! | [`scenario_file`] | `scenario.toml` | [`Scenario`](crate::sim::Scenario), and writes it with the problem that it poses |
//! | [`mukca`] | a folder of ball-in-socket logs | [`Problem`](crate::estimate::Problem) |
//! | [`trial_folder`] | trials with truth | [`Trial`](crate::experiment::Trial)s |
//! | [`pose_file`] | poses of a tool in contact | [`PoseSamples`](crate::manifold::PoseSamples) |
//! | [`manifold_file`] | `manifold.safetensors` | [`ManifoldFile`](manifold_file::ManifoldFile), and writes it |
//! | [`calibration_folder`] | | writes what a calibration leaves: `calibrated.urdf`, `estimate.json`, `report.html` |
//! | `calibration_mcap` | | writes a calibration for Foxglove and Rerun (cargo feature `mcap`) |
//! | `campaign_folder`, `campaign_parquet` | parts of a campaign (feature `parquet`) | [`CampaignRow`](crate::experiment::CampaignRow)s, and writes them |
//! | [`estimate_file`] | `estimate.json` | [`EstimateFile`](estimate_file::EstimateFile), and writes it |
//! | [`weights_file`], [`checkpoint_file`] | a network, trained or in training | [`WeightsFile`](weights_file::WeightsFile), [`CheckpointFile`](checkpoint_file::CheckpointFile), and writes them |
//! | [`onnx`] | | writes a network for others |
//! | [`offsets_yaml`] | | writes encoder offsets for a driver |
//! | [`atomic`] | | writes a file whole or not at all |
//!
//! Every failure is an [`IoError`] that names the file, the line or field, what was expected and
//! what was found. Input is bounded: each format refuses files larger than a documented size, and
//! gzipped ones are bounded by what they unpack to.

pub mod atomic;
mod bytes;
pub mod calibration_folder;
#[cfg(feature = "mcap")]
pub mod calibration_mcap;
#[cfg(feature = "parquet")]
pub mod campaign_folder;
#[cfg(feature = "parquet")]
pub mod campaign_parquet;
pub mod checkpoint_file;
pub mod contact_csv;
pub mod contact_log;
mod error;
pub mod estimate_file;
mod loaded;
pub mod manifold_file;
pub mod mesh;
pub mod mukca;
mod network_entry;
mod network_tensors;
#[cfg(feature = "parquet")]
mod number_columns;
pub mod offsets_yaml;
pub mod onnx;
pub mod outline;
pub mod pose_file;
#[cfg(feature = "parquet")]
mod pose_parquet;
pub mod problem_file;
pub mod scenario_file;
mod suggest;
pub mod trial_folder;
pub mod urdf;
pub mod weights_file;

pub use bytes::Input;
pub use error::{IoError, Place};
pub use loaded::Loaded;
