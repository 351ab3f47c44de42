//! A calibrated chain from parameter estimates, and its split into encoder offsets and the rest.

use nalgebra::{UnitQuaternion, Vector3};

use super::chain::{Joint, JointKind, Robot};
use super::kinematic_parameter::KinematicParameter;
use super::segments::segment_of_each_joint;
use crate::se3::{self, Pose, Twist};

/// The nominal chain with parameter values applied: compliances and backlashes added to the
/// joints', strains, offsets and twists folded into the joint origins. `theta` (SI) has one value
/// for each of `parameters`, in their order; surplus values are ignored, missing ones count as 0.
/// Values of a parameter that is listed twice are added.
///
/// An encoder offset folds exactly: `Rot(axis, q − b) = Rot(axis, −b) · Rot(axis, q)`. Parameters
/// of the tool, and of joints and segments that the arm does not have, are left out.
pub fn calibrated(robot: &Robot, parameters: &[KinematicParameter], theta: &[f64]) -> Robot {
    let segment_of = segment_of_each_joint(robot);
    let sum = |is_wanted: &dyn Fn(KinematicParameter) -> bool| -> f64 {
        parameters.iter().zip(theta).filter(|(parameter, _)| is_wanted(**parameter)).map(|(_, value)| *value).sum()
    };
    let mut calibrated = robot.clone();
    let mut moving = 0;
    for (joint, segment) in calibrated.joints_mut().iter_mut().zip(segment_of) {
        let strain = sum(&|parameter| match parameter {
            KinematicParameter::Strain => true,
            KinematicParameter::SegmentStrain(k) => segment == Some(k),
            _ => false,
        });
        joint.parent_from_joint.translation.vector *= 1.0 + strain;
        if joint.kind == JointKind::Fixed {
            continue;
        }
        let twist = Twist::from_fn(|k, _| sum(&|parameter| parameter == KinematicParameter::JointOrigin(moving, k)));
        let offset = sum(&|parameter| parameter == KinematicParameter::JointOffset(moving));
        joint.parent_from_joint = joint.parent_from_joint * se3::exp(&twist) * offset_motion(joint, offset);
        joint.compliance += sum(&|parameter| parameter == KinematicParameter::JointCompliance(moving));
        joint.backlash += sum(&|parameter| parameter == KinematicParameter::JointBacklash(moving));
        moving += 1;
    }
    calibrated
}

/// Splits a calibrated chain into a chain and encoder offsets `b` of the moving joints (rad, or m
/// for a prismatic joint; base first), for a driver that subtracts them: the calibrated chain at
/// positions `q` has the pose of the returned one at `q − b`. `None` if the `nominal` chain has
/// joints, fixed ones too, of other names, kinds or number.
///
/// The origin of a revolute joint differs from the nominal one by a rotation
/// `swing · Rot(axis, −b)`, the swing's axis orthogonal to the joint's; for a prismatic joint `−b`
/// is the component of the translation along its axis. Offsets are so recovered exactly, `b`
/// between −π and π, from whatever block they were estimated in.
pub fn split_offsets(calibrated: &Robot, nominal: &Robot) -> Option<(Robot, Vec<f64>)> {
    let same = |(a, b): (&Joint, &Joint)| (&a.name, a.kind) == (&b.name, b.kind);
    let joints = calibrated.joints().len();
    if joints != nominal.joints().len() || !calibrated.joints().iter().zip(nominal.joints()).all(same) {
        return None;
    }
    let mut robot = calibrated.clone();
    let mut offsets = Vec::with_capacity(calibrated.dof());
    for (joint, nominal) in robot.joints_mut().iter_mut().zip(nominal.joints()) {
        if joint.kind != JointKind::Fixed {
            let offset = -along_axis(joint, &nominal.parent_from_joint.inv_mul(&joint.parent_from_joint));
            joint.parent_from_joint *= offset_motion(joint, -offset);
            offsets.push(offset);
        }
    }
    Some((robot, offsets))
}

/// The motion of a joint by `−offset`, which precedes its own.
fn offset_motion(joint: &Joint, offset: f64) -> Pose {
    if joint.kind == JointKind::Prismatic {
        Pose::translation(-offset * joint.axis.x, -offset * joint.axis.y, -offset * joint.axis.z)
    } else {
        Pose::from_parts(Vector3::zeros().into(), UnitQuaternion::from_axis_angle(&joint.axis, -offset))
    }
}

/// Component of a motion along the joint's axis: m, or rad between −π and π.
fn along_axis(joint: &Joint, motion: &Pose) -> f64 {
    match joint.kind {
        JointKind::Prismatic => motion.translation.vector.dot(&joint.axis),
        _ => {
            let (sine, cosine) = (motion.rotation.imag().dot(&joint.axis), motion.rotation.w);
            2.0 * (sine * cosine.signum()).atan2(cosine.abs())
        }
    }
}
