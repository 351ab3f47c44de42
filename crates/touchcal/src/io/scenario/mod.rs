//! Scenarios of the simulator, and the problems that they pose.

pub mod scenario_file;
pub mod truth_file;
