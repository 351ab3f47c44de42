//! Files read, refused and written back.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

#[path = "../support/mod.rs"]
mod support;

#[cfg(feature = "mcap")]
mod calibration_mcap;
mod contact_csv;
#[cfg(feature = "mcap")]
mod contact_mcap;
#[cfg(feature = "parquet")]
mod contact_parquet;
mod correction_file;
mod data;
mod dh_file;
mod folders;
mod joint_torques;
mod manifold;
mod mesh;
mod mukca;
mod network;
mod outline;
#[cfg(feature = "parquet")]
mod parquet;
mod problem_file;
mod problem_file_accept;
mod problem_file_known;
mod problem_file_log;
mod problem_file_refused;
mod reference;
mod report;
mod report_held_out;
mod results;
mod ros2_control;
mod scenario_file;
mod serialized;
mod socket_logs;
mod targets;
mod ur_kinematics;
mod urdf;
mod xacro;
