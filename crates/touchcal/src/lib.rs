//! Calibrate a robot arm by touch.
#![forbid(unsafe_code)]

pub mod geometry;
pub mod manifold;
pub mod robot;
pub mod se3;
