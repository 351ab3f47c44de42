//! The chain as stages, one for each moving joint with the fixed joints before it, and the
//! recursion of link poses along them.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::chain::{Joint, JointKind, Robot};
use super::deflection::Deflection;
use super::segments::segment_of_each_joint;
use crate::se3::{self, Pose, Twist};

/// One moving joint with the fixed joints before it, the current parameters applied.
#[derive(Clone, Debug)]
pub(super) struct JointStage {
    /// Merged origin without parameters (m).
    pub nominal: Pose,
    /// Merged origin, strained and twisted.
    origin_rotation: Matrix3<f64>,
    origin_translation: Vector3<f64>,
    /// Unit vector of the axis, in the joint's frame.
    pub axis: Vector3<f64>,
    /// Whether the joint translates.
    pub prismatic: bool,
    /// Encoder offset (rad or m).
    pub offset: f64,
    /// What deflects the joint, without parameters.
    pub nominal_deflection: Deflection,
    /// What deflects the joint.
    pub deflection: Deflection,
    /// Local twist `[v; ω]` on the origin (m, rad).
    pub twist: Twist,
    /// `Jr` of that twist.
    pub right_jacobian: Matrix6<f64>,
    /// For each segment with a part here: its index and its share of the translation, in the
    /// previous stage's frame.
    pub shares: Vec<(usize, Vector3<f64>)>,
}

impl JointStage {
    /// The stage of `joint`, whose origin together with the fixed ones before it is `nominal`.
    pub fn moving(nominal: Pose, joint: &Joint, shares: Vec<(usize, Vector3<f64>)>) -> JointStage {
        let prismatic = joint.kind == JointKind::Prismatic;
        let compliance = if prismatic { 0.0 } else { joint.compliance };
        let deflection = Deflection { compliance, backlash: joint.backlash };
        JointStage {
            axis: joint.axis.into_inner(),
            prismatic,
            nominal_deflection: deflection,
            deflection,
            ..JointStage::tip(nominal, shares)
        }
    }

    /// What follows the last moving joint.
    pub fn tip(nominal: Pose, shares: Vec<(usize, Vector3<f64>)>) -> JointStage {
        JointStage {
            origin_rotation: *nominal.rotation.to_rotation_matrix().matrix(),
            origin_translation: nominal.translation.vector,
            nominal,
            axis: Vector3::z(),
            prismatic: false,
            offset: 0.0,
            nominal_deflection: Deflection::NONE,
            deflection: Deflection::NONE,
            twist: Twist::zeros(),
            right_jacobian: Matrix6::identity(),
            shares,
        }
    }

    /// Updates the origin for the common `strain` (1), the strain of each segment (1; missing ones
    /// 0) and the stage's twist.
    pub fn update_origin(&mut self, strain: f64, segment_strain: &[f64]) {
        let mut origin = self.nominal;
        origin.translation.vector *= 1.0 + strain;
        for (segment, share) in &self.shares {
            origin.translation.vector += share * segment_strain.get(*segment).copied().unwrap_or(0.0);
        }
        let origin = origin * se3::exp(&self.twist);
        self.origin_rotation = *origin.rotation.to_rotation_matrix().matrix();
        self.origin_translation = origin.translation.vector;
        self.right_jacobian = se3::right_jacobian(&self.twist);
    }
}

/// The stages of the moving joints of `robot`, base first, and that of its tip; all parameters are
/// at zero.
pub(super) fn stages(robot: &Robot) -> (Vec<JointStage>, JointStage) {
    let segment_of = segment_of_each_joint(robot);
    let mut stages = Vec::with_capacity(robot.dof());
    let mut origin = Pose::identity();
    let mut shares: Vec<(usize, Vector3<f64>)> = Vec::new();
    for (index, joint) in robot.joints().iter().enumerate() {
        if let Some(segment) = segment_of[index] {
            shares.push((segment, origin.rotation * joint.parent_from_joint.translation.vector));
        }
        origin *= joint.parent_from_joint;
        if joint.kind != JointKind::Fixed {
            stages.push(JointStage::moving(origin, joint, std::mem::take(&mut shares)));
            origin = Pose::identity();
        }
    }
    (stages, JointStage::tip(origin, shares))
}

/// Pose of a frame along the chain in base.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkPose {
    /// Rotation of the frame in base.
    pub rotation: Matrix3<f64>,
    /// Origin of the frame in base (m).
    pub position: Vector3<f64>,
}

impl LinkPose {
    /// The base frame.
    pub fn base() -> LinkPose {
        LinkPose { rotation: Matrix3::identity(), position: Vector3::zeros() }
    }

    /// Advances from the previous link's frame to the stage's joint frame before its motion.
    #[inline]
    pub fn advance_to_joint(&mut self, stage: &JointStage) {
        self.position += self.rotation * stage.origin_translation;
        self.rotation *= stage.origin_rotation;
    }

    /// Advances through the joint's motion (rad or m) to the frame of the link that it moves.
    #[inline]
    pub fn advance_through_joint(&mut self, stage: &JointStage, motion: f64) {
        if stage.prismatic {
            self.position += self.rotation * stage.axis * motion;
        } else {
            self.rotation *= rotation_about(&stage.axis, motion);
        }
    }
}

/// Rodrigues' formula for a unit axis.
#[inline]
fn rotation_about(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (sin, cos) = angle.sin_cos();
    let t = 1.0 - cos;
    let (x, y, z) = (axis.x, axis.y, axis.z);
    Matrix3::new(
        t * x * x + cos,
        t * x * y - sin * z,
        t * x * z + sin * y,
        t * x * y + sin * z,
        t * y * y + cos,
        t * y * z - sin * x,
        t * x * z - sin * y,
        t * y * z + sin * x,
        t * z * z + cos,
    )
}
