//! Campaigns of simulated calibrations, and trials with known truth.

#[cfg(feature = "parquet")]
pub mod campaign_folder;
#[cfg(feature = "parquet")]
pub mod campaign_parquet;
#[cfg(feature = "parquet")]
pub mod falsified_parquet;
pub mod trial_folder;
