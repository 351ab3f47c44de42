//! Laws that hold whatever the data: rigid motions, gaps of parts against independent ones, rest of
//! a simulated tool.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

#[path = "../support/mod.rs"]
mod support;

mod exploration;
mod measured_distances;
mod mesh_gap;
mod nearest_sample;
mod peg_in_hole_blend;
mod peg_in_hole_distance;
mod se3;
mod simulated_shapes;
mod simulation;
mod straight_meshes;
