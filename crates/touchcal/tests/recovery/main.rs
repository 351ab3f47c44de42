//! What an estimate recovers from logs of which the truth is known, and what it refuses.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

#[path = "../support/mod.rs"]
mod support;

mod ball_in_sockets;
mod custom_manifold;
mod declarations;
mod few_contacts;
mod friction;
mod gradient_descent;
mod gross_rows;
mod joint_backlash;
mod joint_compliance;
mod joint_torques;
mod load;
mod meshes;
mod mistaken_declarations;
mod nearly_exact_distances;
mod not_identifiable;
mod not_usable;
mod recorded_logs;
mod round_parts;
mod selection;
mod square_parts;
mod targets;
mod worn_edges;
