//! A serial chain from base to tip, as data.

use nalgebra::{Unit as UnitVector, Vector3};
use serde::{Deserialize, Serialize};

use crate::se3::Pose;

/// How a joint moves, and the unit of its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointKind {
    /// Does not move and has no position.
    Fixed,
    /// Rotates about its axis (rad), between limits if any are declared.
    Revolute,
    /// Rotates about its axis without limits (rad).
    Continuous,
    /// Translates along its axis (m).
    Prismatic,
}

/// Limits of a joint's position: rad, or m for a prismatic joint. [`Robot::new`] does not check
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Least position (rad, or m for a prismatic joint); at most `upper`.
    pub lower: f64,
    /// Greatest position (rad, or m for a prismatic joint); at least `lower`.
    pub upper: f64,
}

/// Mass of a link and the position of its centre of mass. [`Robot::new`] does not check them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inertia {
    /// Mass (kg, not negative).
    pub mass: f64,
    /// Centre of mass (m) in the frame of the joint that carries the link, which moves with the
    /// joint.
    pub center: Vector3<f64>,
}

/// A joint and the link that it carries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Name of the joint, unique in the chain.
    pub name: String,
    /// Name of the link that the joint carries.
    pub child_link: String,
    /// How the joint moves; [`JointKind::Fixed`] if it does not.
    pub kind: JointKind,
    /// Joint origin: pose of the joint's frame, at position zero, in the frame of the link before
    /// it (m).
    pub parent_from_joint: Pose,
    /// Unit vector along the axis of motion, in the joint's frame; without meaning for a fixed
    /// joint.
    pub axis: UnitVector<Vector3<f64>>,
    /// Limits of the position (rad, or m for a prismatic joint); `None` where none are declared.
    pub limits: Option<Limits>,
    /// Compliance about the axis, on the far side of the encoder (rad/(N m)); 0 for a stiff joint,
    /// without effect for fixed and prismatic ones.
    pub compliance: f64,
    /// Half of the play of the joint, on the far side of the encoder (rad, or m for a prismatic
    /// joint): the joint rests at the side to which its torque pushes it; 0 without play, without
    /// effect for a fixed one.
    pub backlash: f64,
    /// Mass of the link that the joint carries, and its centre; `None` where it is not known.
    pub inertia: Option<Inertia>,
}

/// Why joints do not form a valid [`Robot`]; the first reason in the order of the joints.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RobotError {
    /// No joint of the chain moves.
    #[error("expected at least one moving joint between base `{base}` and tip `{tip}`, found none")]
    NoMovingJoint {
        /// Name of the base link.
        base: String,
        /// Name of the tip link.
        tip: String,
    },
    /// Two joints have the same name, fixed ones included.
    #[error("expected distinct joint names, found `{name}` twice")]
    RepeatedName {
        /// The repeated joint name.
        name: String,
    },
    /// A joint's origin, axis, compliance or backlash is NaN or infinite.
    #[error("joint `{name}`: expected a finite origin, axis, compliance and backlash, found NaN or infinity")]
    NotFinite {
        /// Name of the joint.
        name: String,
    },
}

/// Acceleration of gravity `(x, y, z)` (m/s²) in the base frame of an arm that stands upright on
/// Earth, z up: 9.81 m/s² downwards.
pub const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A serial chain of joints from a base link to a tip link. Immutable: calibration returns a new
/// one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    name: String,
    base: String,
    joints: Vec<Joint>,
    gravity: Vector3<f64>,
    has_measured_torques: bool,
}

impl Robot {
    /// A chain from link `base` through `joints`, base first; the last joint's child is the tip. It
    /// stands upright in [`GRAVITY`]. Names of links, limits and inertias are not checked.
    ///
    /// # Errors
    /// [`RobotError::NoMovingJoint`] if no joint moves (or there are none),
    /// [`RobotError::RepeatedName`] if a joint name repeats, [`RobotError::NotFinite`] if an
    /// origin, axis, compliance or backlash is not finite.
    pub fn new(name: impl Into<String>, base: impl Into<String>, joints: Vec<Joint>) -> Result<Self, RobotError> {
        let (name, base) = (name.into(), base.into());
        let robot = Robot { name, base, joints, gravity: GRAVITY.into(), has_measured_torques: false };
        if robot.moving().next().is_none() {
            return Err(RobotError::NoMovingJoint { base: robot.base.clone(), tip: robot.tip().to_owned() });
        }
        for (i, joint) in robot.joints.iter().enumerate() {
            if robot.joints[..i].iter().any(|earlier| earlier.name == joint.name) {
                return Err(RobotError::RepeatedName { name: joint.name.clone() });
            }
            let origin = &joint.parent_from_joint;
            let finite = origin.translation.vector.iter().all(|v| v.is_finite())
                && origin.rotation.coords.iter().all(|v| v.is_finite())
                && joint.axis.iter().all(|v| v.is_finite())
                && joint.compliance.is_finite()
                && joint.backlash.is_finite();
            if !finite {
                return Err(RobotError::NotFinite { name: joint.name.clone() });
            }
        }
        Ok(robot)
    }

    /// Name of the robot, as in its description.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Name of the base link.
    pub fn base(&self) -> &str {
        &self.base
    }

    /// Name of the tip link: the last joint's child.
    pub fn tip(&self) -> &str {
        self.joints.last().map_or(&self.base, |joint| &joint.child_link)
    }

    /// All joints from base to tip, fixed ones too; at least one.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The joints that move, from base to tip: joint positions (rad, or m for a prismatic joint)
    /// have this order and length everywhere.
    pub fn moving(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|joint| joint.kind != JointKind::Fixed)
    }

    /// Number of joints that move, at least 1: the length of every list of joint positions.
    pub fn dof(&self) -> usize {
        self.moving().count()
    }

    /// The same chain in another gravity: `gravity` is the acceleration (m/s²) in the base frame,
    /// [`GRAVITY`] before; finite, which is not checked.
    pub fn with_gravity(mut self, gravity: Vector3<f64>) -> Robot {
        self.gravity = gravity;
        self
    }

    /// Acceleration of gravity (m/s²) in the base frame.
    pub fn gravity(&self) -> &Vector3<f64> {
        &self.gravity
    }

    /// The same chain, whose joints deflect by measured torques alone
    /// ([`JointLoad::Torques`](super::JointLoad::Torques)): where none are given they bear no
    /// gravity, whatever the masses of the links.
    pub fn with_measured_torques(mut self) -> Robot {
        self.has_measured_torques = true;
        self
    }

    /// Whether joints deflect by measured torques alone: compliances belong to these.
    pub fn has_measured_torques(&self) -> bool {
        self.has_measured_torques
    }

    /// Whether any joint has a compliance or a backlash other than 0: poses then depend on gravity
    /// and load.
    pub fn is_compliant(&self) -> bool {
        self.joints.iter().any(|joint| joint.compliance != 0.0 || joint.backlash != 0.0)
    }

    /// Whether every moving joint carries links of a mass above 0 before the next moving one.
    /// Otherwise other masses stand in, see
    /// [`joint_compliance`](crate::parameter::joint_compliance).
    pub fn has_masses(&self) -> bool {
        let mut carried: Vec<f64> = Vec::new();
        for joint in &self.joints {
            if joint.kind != JointKind::Fixed {
                carried.push(0.0);
            }
            if let (Some(mass), Some(inertia)) = (carried.last_mut(), joint.inertia) {
                *mass += inertia.mass;
            }
        }
        carried.iter().all(|mass| *mass > 0.0)
    }

    /// The chain with its tip frame moved: the last joint's origin followed by `tip_from_moved_tip`
    /// (m), the pose of the new tip frame in the former. `None` if that joint moves: its origin
    /// then lies before its motion, not at the tip.
    pub fn with_tip_moved(&self, tip_from_moved_tip: &Pose) -> Option<Robot> {
        let mut robot = self.clone();
        let last = robot.joints.last_mut().filter(|joint| joint.kind == JointKind::Fixed)?;
        last.parent_from_joint *= *tip_from_moved_tip;
        Some(robot)
    }

    /// All joints from base to tip, to be changed.
    pub(super) fn joints_mut(&mut self) -> &mut [Joint] {
        &mut self.joints
    }
}
