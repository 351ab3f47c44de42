//! The arm: a serial chain of joints, and its kinematics with derivatives by joint positions and by
//! the parameters that may be wrong.

pub mod builtin;
mod calibrated;
mod chain;
mod denavit_hartenberg;
mod gravity_torque;
mod joint_stage;
mod kinematic_parameter;
mod kinematics;
mod segments;

pub use calibrated::{calibrated, split_offsets};
pub use chain::{GRAVITY, Inertia, Joint, JointKind, Limits, Robot, RobotError};
pub use denavit_hartenberg::{DenavitHartenberg, DhLink, NEARLY_PARALLEL, denavit_hartenberg};
pub use kinematic_parameter::KinematicParameter;
pub use kinematics::{Kinematics, KinematicsScratch};
pub use segments::{Segment, segments};
