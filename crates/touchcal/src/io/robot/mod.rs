//! Files that describe an arm.

pub mod urdf;
