//! Arguments of `compare`.

use std::path::PathBuf;

use super::help::examples;

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("What changed between two calibrations", "touchcal compare january march"),
    ("Every parameter, as JSON", "touchcal compare january march --all --json"),
]))]
pub struct CompareArgs {
    /// Folder of the earlier calibration, or its estimate.json
    #[arg(value_name = "EARLIER")]
    pub earlier: PathBuf,
    /// Folder of the later calibration, or its estimate.json
    #[arg(value_name = "LATER")]
    pub later: PathBuf,
    /// Print every parameter
    #[arg(long)]
    pub all: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
