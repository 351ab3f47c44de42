//! What gravity and a load at the tip do to the joints of an arm.
//!
//! The torque about turning joint `i`, with axis `aᵢ` through `pᵢ`, is `τᵢ = aᵢ · (Σₖ (cₖ − pᵢ) × mₖ g + (t − pᵢ) × f + m)`: the sum over the masses `mₖ` at `cₖ` that
//! the joint carries, minus the derivative of their potential energy `−Σ mₖ g·cₖ` with respect to the joint's angle; and what a force `f` and a moment `m` about the tip's origin `t` add.

use nalgebra::Vector3;

use super::chain::{JointKind, Robot};
use super::stage::{Frame, Stage};
use crate::se3::{Pose, Wrench};

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
    fn seen_from_base(&self, at: &Frame) -> Masses {
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
    pub fn of(robot: &Robot) -> Gravity {
        Gravity { acceleration: *robot.gravity(), masses: weighed(robot).unwrap_or_else(|| stand_in(robot.dof())) }
    }
}

impl Robot {
    /// Whether every moving joint carries a link of known mass before the next one. Otherwise others stand in, see [`joint_compliance`](super::joint_compliance).
    pub fn has_masses(&self) -> bool {
        weighed(self).is_some()
    }
}

/// Masses by the links' inertias; none if a moving joint carries nothing with a mass before the next one.
fn weighed(robot: &Robot) -> Option<Vec<Masses>> {
    let mut masses: Vec<Masses> = Vec::new();
    let mut moved_from_link = Pose::identity();
    for joint in robot.joints() {
        if joint.kind == JointKind::Fixed {
            moved_from_link *= joint.parent_from_joint;
        } else {
            moved_from_link = Pose::identity();
            masses.push(Masses::NONE);
        }
        // Links before the first moving joint hang on nothing that bends.
        if let (Some(carried), Some(inertia)) = (masses.last_mut(), joint.inertia) {
            let center = moved_from_link * nalgebra::Point3::from(inertia.center);
            carried.add(&Masses { mass: inertia.mass, moment: center.coords * inertia.mass });
        }
    }
    let complete = masses.iter().all(|carried| carried.mass > 0.0);
    masses.push(Masses::NONE);
    complete.then_some(masses)
}

/// A kilogram in the middle of each moving link, between its joint's origin and the next, and one at the tip.
///
/// Half of each at either end has the same first moment: what lies in a joint's own origin has no lever about it.
fn stand_in(dof: usize) -> Vec<Masses> {
    let mut masses = vec![Masses::at_origin(1.0); dof];
    masses.push(Masses::at_origin(1.5));
    masses
}

/// A walk along the arm, not bent, that knows what the joints ahead still carry.
pub(super) struct Torques<'a> {
    gravity: &'a Gravity,
    frame: Frame,
    carried: Masses,
    /// Force (N) at the tip in base, and its moment (N m) about the base's origin.
    force: Vector3<f64>,
    moment: Vector3<f64>,
    joint: usize,
}

impl<'a> Torques<'a> {
    /// Begins at the base, with everything carried at joint positions `q`, and `load` about the tip's origin, in its frame.
    pub fn new(gravity: &'a Gravity, load: &Wrench, (stages, tip): (&[Stage], &Stage), q: &[f64]) -> Self {
        let mut frame = Frame::base();
        let mut carried = Masses::NONE;
        for ((stage, &q), masses) in stages.iter().zip(q).zip(&gravity.masses) {
            frame.enter(stage);
            frame.pass(stage, q - stage.offset);
            carried.add(&masses.seen_from_base(&frame));
        }
        frame.enter(tip);
        if let Some(masses) = gravity.masses.last() {
            carried.add(&masses.seen_from_base(&frame));
        }
        let [x, y, z, about_x, about_y, about_z] = *load;
        let force = frame.rotation * Vector3::new(x, y, z);
        let moment = frame.rotation * Vector3::new(about_x, about_y, about_z) + frame.position.cross(&force);
        Torques { gravity, frame: Frame::base(), carried, force, moment, joint: 0 }
    }

    /// The torque (N m) about the next joint, which moves by `motion`; 0 for one that slides.
    pub fn next(&mut self, stage: &Stage, motion: f64) -> f64 {
        self.frame.enter(stage);
        let lever = self.carried.moment - self.frame.position * self.carried.mass;
        let of_load = self.moment - self.frame.position.cross(&self.force);
        let torque = (self.frame.rotation * stage.axis).dot(&(lever.cross(&self.gravity.acceleration) + of_load));
        self.frame.pass(stage, motion);
        if let Some(masses) = self.gravity.masses.get(self.joint) {
            self.carried.remove(&masses.seen_from_base(&self.frame));
        }
        self.joint += 1;
        if stage.prismatic { 0.0 } else { torque }
    }
}
