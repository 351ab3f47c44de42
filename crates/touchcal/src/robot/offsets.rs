//! The part of a calibrated arm that a driver can do: offsets of its encoders.

use super::chain::{Joint, JointKind, Robot};
use super::kinematics::bias;
use crate::se3::Pose;

impl Robot {
    /// This calibrated chain without what offsets of the encoders can do, and these offsets `b` (rad or m) of the moving joints: this chain
    /// at `q` is that one at `q − b`. None if the `nominal` chain has other joints.
    ///
    /// A joint's origin differs from the nominal one by a rotation `swing · Rot(axis, −b)`, the swing's axis square to the joint's;
    /// of a prismatic joint `−b` is the part of the translation along its axis. So biases come out exactly, whatever block they were estimated in.
    pub fn without_offsets(&self, nominal: &Robot) -> Option<(Robot, Vec<f64>)> {
        let same = |(a, b): (&Joint, &Joint)| (&a.name, a.kind) == (&b.name, b.kind);
        if self.joints().len() != nominal.joints().len() || !self.joints().iter().zip(nominal.joints()).all(same) {
            return None;
        }
        let mut robot = self.clone();
        let mut offsets = Vec::with_capacity(self.dof());
        for (joint, nominal) in robot.joints_mut().iter_mut().zip(nominal.joints()) {
            if joint.kind != JointKind::Fixed {
                let offset = -along_axis(joint, &nominal.parent_from_joint.inv_mul(&joint.parent_from_joint));
                joint.parent_from_joint *= bias(joint, -offset);
                offsets.push(offset);
            }
        }
        Some((robot, offsets))
    }
}

/// How far `motion` goes the joint's way: m, or rad between −π and π.
fn along_axis(joint: &Joint, motion: &Pose) -> f64 {
    match joint.kind {
        JointKind::Prismatic => motion.translation.vector.dot(&joint.axis),
        _ => {
            let (sine, cosine) = (motion.rotation.imag().dot(&joint.axis), motion.rotation.w);
            2.0 * (sine * cosine.signum()).atan2(cosine.abs())
        }
    }
}
