//! Calibrations with known true parameters: simulated or recorded trials, and errors of their
//! estimates.

mod campaign;
pub mod falsified;
mod parameter_errors;
mod pose_errors;
mod problem;
mod summary;
mod tool_error;
mod trial;

pub use campaign::{CampaignRow, LEVELS, campaign_trial};
pub(crate) use parameter_errors::true_robot;
pub use pose_errors::{PoseErrors, RmsAndMax, pose_errors};
pub(crate) use problem::{LOSS_SCALE, blocks, distances, encoder_trend, noise, wrench};
pub use problem::{problem, uses_loads};
pub use summary::CampaignSummary;
pub use tool_error::{ToolError, random_positions, tool_error};
pub use trial::{Search, Trial, TrialError};
