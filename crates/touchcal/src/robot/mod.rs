//! The arm: a serial chain of joints, the parameters that may be wrong in it, and its kinematics with their derivatives.

pub mod builtin;
mod chain;
mod gravity;
mod kinematics;
mod offsets;
mod parameters;
mod segments;
mod stage;

pub use chain::{GRAVITY, Inertia, Joint, JointKind, Limits, Robot, RobotError};
pub use kinematics::{Kinematics, Scratch};
pub use parameters::{
    Block, Column, Learned, Parameter, Unit, joint_compliance, joint_drift, joint_offset, joint_origin, segment_strain,
    strain,
};
pub use segments::{Segment, segments};
