//! Shapes and exact signed distances between them.
//!
//! [`profile`] holds the outlines, [`extrusion`] the gap between a straight peg and a straight
//! hole; [`solid`] holds bodies of any shape as triangles, [`solids`] the gap between two of them.
//! Bodies that are straight are told from others
//! ([`PegAndHole::of_straight`](extrusion::PegAndHole::of_straight)).

pub mod extrusion;
pub mod nearby;
pub mod profile;
pub mod round;
pub mod solid;
pub mod solids;

mod beside;
mod blend;
mod boxes;
mod edges;
mod facets;
mod lines;
mod nearness;
mod outlines;
mod placed;
mod polygons;
mod scan;
mod silhouette;
mod straight;
