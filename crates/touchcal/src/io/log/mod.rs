//! Logs of joint positions.

pub mod contact_csv;
pub mod contact_log;
