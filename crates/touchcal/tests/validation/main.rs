//! Published figures and real arms.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

#[path = "../support/mod.rs"]
mod support;

mod mukca_arms;
mod training;
#[cfg(any(feature = "cuda", feature = "wgpu"))]
mod training_gpu;
mod training_pairs;
