//! Calibration problems.

pub(super) mod loaded;
pub mod mukca;
pub mod problem_file;
pub mod socket_logs;
