//! What a problem is read from, together.

use super::bytes::Input;
use crate::estimate::Problem;

/// A problem, and what is needed to write its result.
#[derive(Debug)]
pub struct Loaded {
    /// The problem.
    pub problem: Problem,
    /// Text of the robot's URDF, to be rewritten with [`super::urdf::rewrite`].
    pub urdf: String,
    /// Every file that was read, in that order.
    pub inputs: Vec<Input>,
}
