//! Calibrate a robot arm by touch.

pub mod contact;
pub mod estimate;
pub mod geometry;
pub mod io;
pub mod manifold;
pub mod robot;
pub mod se3;
pub mod sim;
