//! Shapes and exact signed distances between them.
//!
//! [`profile`] holds the outlines, [`extrusion`] the gap between a straight peg and a straight hole.

pub mod extrusion;
pub mod profile;

mod blend;
mod edges;
mod nearness;
mod outlines;
mod scan;
mod silhouette;
