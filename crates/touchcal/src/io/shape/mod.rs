//! Files that describe the shapes of parts.

pub mod mesh;
pub mod outline;
