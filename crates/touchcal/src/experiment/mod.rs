//! Calibrations of which the truth is known: simulated or recorded trials, and how far an estimate
//! is from what was true.

mod campaign;
mod posed;
mod summary;
mod touching;
mod transfer;
mod trial;

pub use campaign::{CampaignRow, LEVELS, campaign_trial};
pub use posed::problem;
pub(crate) use posed::{LOSS_SCALE, blocks, distances, noise};
pub use summary::CampaignSummary;
pub use touching::manifold_of;
pub use transfer::{ToolError, random_positions, tool_error};
pub use trial::{Search, Trial, TrialError};
