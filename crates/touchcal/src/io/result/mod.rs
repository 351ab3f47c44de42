//! Results of a calibration.

pub mod calibration_changes;
pub mod calibration_folder;
#[cfg(feature = "mcap")]
pub mod calibration_mcap;
pub mod correction_file;
pub mod dh_file;
mod estimate_check_entries;
mod estimate_entries;
pub mod estimate_file;
mod estimate_robot_entry;
mod estimate_schema_1;
mod estimate_tool_entries;
pub mod export;
pub mod export_text;
pub mod offsets_yaml;
pub mod saved_calibration;
pub mod ur_kinematics;
