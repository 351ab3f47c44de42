//! Joint torques of gravity and of a load at the tip.
//!
//! The torque about revolute joint `i`, with axis `aᵢ` through `pᵢ`, is
//! `τᵢ = aᵢ · (Σₖ (cₖ − pᵢ) × mₖ g + (t − pᵢ) × f + m)`: the sum over the masses `mₖ` at `cₖ` that
//! the joint carries, minus the derivative of their potential energy `−Σ mₖ g·cₖ` with respect to
//! the joint's angle; and what a force `f` and a moment `m` about the tip's origin `t` add.

use nalgebra::Vector3;

use super::chain::{JointKind, Robot};
use super::joint_stage::{JointStage, LinkPose};
use crate::se3::{self, Pose, Twist, Wrench};

/// Masses in one frame: their sum (kg) and their first moment about the frame's origin (kg m).
#[derive(Clone, Copy, Debug)]
struct Masses {
    mass: f64,
    moment: Vector3<f64>,
}

impl Masses {
    const NONE: Masses = Masses { mass: 0.0, moment: Vector3::new(0.0, 0.0, 0.0) };

    fn at_origin(mass: f64) -> Masses {
        Masses { mass, ..Masses::NONE }
    }

    /// Masses in frame `at`, seen from base.
    fn seen_from_base(&self, at: &LinkPose) -> Masses {
        Masses { mass: self.mass, moment: at.rotation * self.moment + at.position * self.mass }
    }

    fn add(&mut self, other: &Masses) {
        self.mass += other.mass;
        self.moment += other.moment;
    }

    fn remove(&mut self, other: &Masses) {
        self.mass -= other.mass;
        self.moment -= other.moment;
    }
}

/// Gravity and the masses of an arm.
#[derive(Clone, Debug)]
pub(super) struct Gravity {
    /// Acceleration in base (m/s²).
    acceleration: Vector3<f64>,
    /// In the frame of each moving link, the tip's last.
    masses: Vec<Masses>,
}

impl Gravity {
    /// Gravity and the link masses of `robot`; default masses where not every moving joint carries
    /// one.
    pub fn of(robot: &Robot) -> Gravity {
        let masses = if robot.has_masses() { link_masses(robot) } else { default_masses(robot.dof()) };
        Gravity { acceleration: *robot.gravity(), masses }
    }
}

/// Masses by the links' inertias.
fn link_masses(robot: &Robot) -> Vec<Masses> {
    let mut masses: Vec<Masses> = Vec::new();
    let mut moved_from_link = Pose::identity();
    for joint in robot.joints() {
        if joint.kind == JointKind::Fixed {
            moved_from_link *= joint.parent_from_joint;
        } else {
            moved_from_link = Pose::identity();
            masses.push(Masses::NONE);
        }
        // Links before the first moving joint load no joint.
        if let (Some(carried), Some(inertia)) = (masses.last_mut(), joint.inertia) {
            let center = moved_from_link * nalgebra::Point3::from(inertia.center);
            carried.add(&Masses { mass: inertia.mass, moment: center.coords * inertia.mass });
        }
    }
    masses.push(Masses::NONE);
    masses
}

/// A kilogram in the middle of each moving link, between its joint's origin and the next, and one
/// at the tip.
///
/// Half of each at either end has the same first moment: a mass in a joint's own origin has no
/// lever arm about it.
fn default_masses(dof: usize) -> Vec<Masses> {
    let mut masses = vec![Masses::at_origin(1.0); dof];
    masses.push(Masses::at_origin(1.5));
    masses
}

/// Derivatives of the joints' torques (N m) by the load `[f; τ]` about the tip's origin, in its
/// frame, at joint positions `q` (rad, m): `visit(i, row)` for every joint but prismatic ones, with
/// `row · load` the load's part of the torque.
///
/// The power of the load is the same in joints and at the tip, so that the row is the twist of the
/// undeflected tip, in its frame, by the joint's motion.
pub(super) fn torques_by_load(
    (stages, tip): (&[JointStage], &JointStage),
    q: &[f64],
    mut visit: impl FnMut(usize, &Twist),
) {
    let mut end = LinkPose::base();
    for (stage, &q) in stages.iter().zip(q) {
        end.advance_to_joint(stage);
        end.advance_through_joint(stage, q - stage.offset);
    }
    end.advance_to_joint(tip);
    let into_tip = end.rotation.transpose();
    let mut frame = LinkPose::base();
    for (i, (stage, &q)) in stages.iter().zip(q).enumerate() {
        frame.advance_to_joint(stage);
        if !stage.prismatic {
            let axis = frame.rotation * stage.axis;
            visit(i, &se3::twist(&(into_tip * axis.cross(&(end.position - frame.position))), &(into_tip * axis)));
        }
        frame.advance_through_joint(stage, q - stage.offset);
    }
}

/// The torque recursion along the undeflected arm, from base to tip.
pub(super) struct TorqueRecursion<'a> {
    gravity: &'a Gravity,
    frame: LinkPose,
    /// What the joints from here on carry.
    carried: Masses,
    /// Force (N) at the tip in base, and its moment (N m) about the base's origin.
    force: Vector3<f64>,
    moment: Vector3<f64>,
    joint: usize,
}

impl<'a> TorqueRecursion<'a> {
    /// Starts at the base, with all masses at joint positions `q` (rad, m), and `load` (N, N m)
    /// about the tip's origin, in its frame.
    pub fn new(gravity: &'a Gravity, load: &Wrench, (stages, tip): (&[JointStage], &JointStage), q: &[f64]) -> Self {
        let mut frame = LinkPose::base();
        let mut carried = Masses::NONE;
        for ((stage, &q), masses) in stages.iter().zip(q).zip(&gravity.masses) {
            frame.advance_to_joint(stage);
            frame.advance_through_joint(stage, q - stage.offset);
            carried.add(&masses.seen_from_base(&frame));
        }
        frame.advance_to_joint(tip);
        if let Some(masses) = gravity.masses.last() {
            carried.add(&masses.seen_from_base(&frame));
        }
        let [x, y, z, about_x, about_y, about_z] = *load;
        let force = frame.rotation * Vector3::new(x, y, z);
        let moment = frame.rotation * Vector3::new(about_x, about_y, about_z) + frame.position.cross(&force);
        TorqueRecursion { gravity, frame: LinkPose::base(), carried, force, moment, joint: 0 }
    }

    /// Torque (N m) about the next joint, which moves by `motion`; 0 for a prismatic one.
    pub fn next(&mut self, stage: &JointStage, motion: f64) -> f64 {
        self.frame.advance_to_joint(stage);
        let lever = self.carried.moment - self.frame.position * self.carried.mass;
        let of_load = self.moment - self.frame.position.cross(&self.force);
        let torque = (self.frame.rotation * stage.axis).dot(&(lever.cross(&self.gravity.acceleration) + of_load));
        self.frame.advance_through_joint(stage, motion);
        if let Some(masses) = self.gravity.masses.get(self.joint) {
            self.carried.remove(&masses.seen_from_base(&self.frame));
        }
        self.joint += 1;
        if stage.prismatic { 0.0 } else { torque }
    }
}
