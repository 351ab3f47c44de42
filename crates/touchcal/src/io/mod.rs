//! Files: bytes in, types out, and back. Nothing is computed here.
//!
//! | module | reads | into |
//! |---|---|---|
//! | [`urdf`] | a robot description | [`Robot`](crate::robot::Robot), and writes a calibrated one back into the text, or as a macro of xacro |
//! | [`contact_log`] | joint logs: [`contact_csv`], Parquet, ROS 2 bags | [`ContactLog`](crate::contact::ContactLog) |
//! | [`problem_file`] | `problem.toml` and what it refers to | [`Problem`](crate::estimate::Problem) |
//! | [`outline`] | outlines as CSV, SVG or DXF | [`Polygon`](crate::geometry::Polygon) |
//! | [`mesh`] | bodies as STL or OBJ | [`TriangleMesh`](crate::geometry::TriangleMesh) |
//! | [`scenario_file`] | `scenario.toml` | [`Scenario`](crate::sim::Scenario), and writes it with the problem that it poses |
//! | [`truth_file`] | `truth.json` of a simulation | true errors of arm and tool |
//! | [`mukca`] | a folder of ball-in-socket logs | [`Problem`](crate::estimate::Problem) |
//! | [`socket_logs`] | names of ball-in-socket logs | [`SocketLog`](socket_logs::SocketLog)s |
//! | [`trial_folder`] | trials with truth | [`Trial`](crate::experiment::Trial)s |
//! | [`pose_file`] | poses of a tool in contact | [`PoseSamples`](crate::manifold::PoseSamples) |
//! | [`manifold_file`] | `manifold.safetensors` | [`ManifoldFile`](manifold_file::ManifoldFile), and writes it |
//! | [`calibration_folder`] | | writes what a calibration leaves: `calibrated.urdf`, `estimate.json`, `report.html` |
//! | [`SavedCalibration`] | `estimate.json` and `calibrated.urdf` of a folder | itself, and [`CalibrationChanges`] between two |
//! | `calibration_mcap` | | writes a calibration for Foxglove and Rerun (cargo feature `mcap`) |
//! | `campaign_folder`, `campaign_parquet` | parts of a campaign (feature `parquet`) | [`CampaignRow`](crate::experiment::CampaignRow)s, and writes them |
//! | `falsified_parquet` | | writes trials with false declarations (feature `parquet`) |
//! | [`estimate_file`] | `estimate.json` | [`EstimateFile`](estimate_file::EstimateFile), and writes it |
//! | [`weights_file`], [`checkpoint_file`] | a network, trained or in training | [`WeightsFile`](weights_file::WeightsFile), [`CheckpointFile`](checkpoint_file::CheckpointFile), and writes them |
//! | [`onnx`] | | writes a network for others |
//! | [`offsets_yaml`] | | writes encoder offsets for a driver |
//! | [`ur_kinematics`] | | writes joint origins for the driver of Universal Robots |
//! | [`dh_file`] | | writes Denavit–Hartenberg parameters |
//! | [`atomic`] | | writes a file whole or not at all |
//! | [`result_folder`] | | writes files that are one result |
//!
//! Every failure is an [`IoError`] that names the file, the line or field, what was expected and
//! what was found. Input is bounded: each format refuses files larger than a documented size, and
//! gzipped ones are bounded by what they unpack to.

mod base;
mod campaign;
mod log;
mod manifold;
mod problem;
mod result;
mod robot;
mod scenario;
mod shape;

pub use base::atomic;
pub use base::bytes::Input;
pub use base::error::{IoError, Place};
pub use base::result_folder;
pub use base::suggest::{did_you_mean, list};
pub use campaign::trial_folder;
#[cfg(feature = "parquet")]
pub use campaign::{campaign_folder, campaign_parquet, falsified_parquet};
pub use log::{contact_csv, contact_log};
#[cfg(feature = "learned")]
pub use manifold::{checkpoint_file, onnx, weights_file};
pub use manifold::{manifold_file, pose_file};
pub use problem::loaded::Loaded;
pub use problem::{mukca, problem_file, socket_logs};
pub use result::calibration_changes::CalibrationChanges;
#[cfg(feature = "mcap")]
pub use result::calibration_mcap;
pub use result::export::Export;
pub use result::export_text::ExportText;
pub use result::saved_calibration::SavedCalibration;
pub use result::{calibration_folder, correction_file, dh_file, estimate_file, offsets_yaml, ur_kinematics};
pub use robot::urdf;
pub use scenario::{scenario_file, truth_file};
pub use shape::{mesh, outline};
