//! Campaigns of simulated calibrations, and trials with known truth.

#[cfg(feature = "parquet")]
pub mod campaign_folder;
#[cfg(feature = "parquet")]
pub mod campaign_parquet;
pub mod trial_folder;
