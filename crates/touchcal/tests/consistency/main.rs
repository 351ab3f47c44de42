//! Whether reported uncertainties are those of the errors, over many trials.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

#[path = "../support/mod.rs"]
mod support;

mod acceptance;
mod campaign;
mod coverage;
mod depth;
mod encoder_drift;
mod evaluation;
mod falsified;
mod freed_effects;
mod nees;
mod prior_tests;
mod simulator;
mod wrench;
