//! Arguments of `select`.

use super::help::{OUTPUT, examples};
use super::problem::Source;

/// Arguments of `select`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("Which parameters to estimate", "touchcal select sim/problem.toml"),
]))]
pub struct SelectArgs {
    /// The problem.
    #[command(flatten)]
    pub source: Source,
    /// Print JSON instead of tables
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}
