//! `touchcal experiment`: methods compared on trials with truth.

mod approach;
#[cfg(feature = "parquet")]
mod campaign;
#[cfg(feature = "parquet")]
mod falsified;
#[cfg_attr(not(feature = "parquet"), allow(dead_code, reason = "marks of campaigns"))]
mod figure;
mod paper;
mod row;
mod saved;
mod table1;
#[cfg(feature = "parquet")]
mod threads;

use crate::args::ExperimentArgs;
use crate::failure::{Failure, Outcome};

/// Runs the experiment asked for.
pub fn run(args: &ExperimentArgs) -> Result<Outcome, Failure> {
    crate::progress::defer_interrupts();
    match args {
        ExperimentArgs::Paper(args) => paper::run(args),
        ExperimentArgs::Table1(args) => table1::run(args),
        #[cfg(feature = "parquet")]
        ExperimentArgs::Campaign(args) => campaign::run(args),
        #[cfg(feature = "parquet")]
        ExperimentArgs::Merge(args) => campaign::merge::run(args),
        #[cfg(feature = "parquet")]
        ExperimentArgs::Falsified(args) => falsified::run(args),
    }
}
