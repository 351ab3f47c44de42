//! How errors of the load change deflections of joints.

use crate::parameter::ParameterId;
use crate::robot::{KinematicParameter, KinematicsScratch, play_slope};
use crate::se3::Twist;

/// The joint that a compliance or a backlash deflects, and the derivative of the deflection by that
/// parameter (SI) and by the load (N, N m); `None` of other parameters.
pub(super) fn deflection_by_load(kinematics: &KinematicsScratch, id: ParameterId) -> Option<(usize, Twist)> {
    match id {
        ParameterId::Kinematic(KinematicParameter::JointCompliance(joint)) => {
            Some((joint, kinematics.torque_by_load(joint)))
        }
        ParameterId::Kinematic(KinematicParameter::JointBacklash(joint)) => {
            Some((joint, kinematics.torque_by_load(joint) * play_slope(kinematics.torques[joint])))
        }
        _ => None,
    }
}
