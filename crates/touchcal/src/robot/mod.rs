//! The arm: a serial chain of joints, and its kinematics with derivatives by joint positions and by
//! the parameters that may be wrong.

pub mod builtin;
mod calibrated;
mod chain;
mod deflection;
mod denavit_hartenberg;
mod encoder_term;
mod gravity_torque;
mod joint_correction;
mod joint_load;
mod joint_stage;
mod kinematic_parameter;
mod kinematics;
mod rest;
mod segments;

pub use calibrated::{calibrated, split_offsets};
pub use chain::{GRAVITY, Inertia, Joint, JointKind, Limits, Robot, RobotError};
pub use deflection::{BACKLASH_TORQUE, play_slope};
pub use denavit_hartenberg::{DenavitHartenberg, DhLink, NEARLY_PARALLEL, denavit_hartenberg};
pub use encoder_term::{EncoderTerm, encoder_error, measured_position, subtract_encoder_errors};
pub use joint_correction::{JointCorrection, LoadedLink};
pub use joint_load::JointLoad;
pub use kinematic_parameter::KinematicParameter;
pub use kinematics::{Kinematics, KinematicsScratch};
pub use segments::{Segment, segments};
