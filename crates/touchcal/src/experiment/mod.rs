//! Calibrations of which the truth is known: simulated or recorded trials, and how far an estimate is from what was true.

mod paper;
mod transfer;
mod trial;

pub use paper::{PAPER_OFFSET, PAPER_STRAIN, PartsError, paper};
pub use transfer::{ToolError, random_positions, tool_error};
pub use trial::{Search, Trial, TrialError};
