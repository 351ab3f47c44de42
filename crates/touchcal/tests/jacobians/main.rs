//! Derivatives against central differences.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

mod encoder_terms;
mod kinematics;
mod peg_in_hole;
