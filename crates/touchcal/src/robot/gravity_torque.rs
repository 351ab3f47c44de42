//! Joint torques of gravity and of a load at the tip.
//!
//! The torque about revolute joint `i`, with axis `aᵢ` through `pᵢ`, is
//! `τᵢ = aᵢ · (Σₖ (cₖ − pᵢ) × mₖ g + (t − pᵢ) × f + m)`: the sum over the masses `mₖ` at `cₖ` that
//! the joint carries, minus the derivative of their potential energy `−Σ mₖ g·cₖ` with respect to
//! the joint's angle; and what a force `f` and a moment `m` about the tip's origin `t` add. Where
//! torques are measured, these are taken instead, whatever the posture. The force along a prismatic
//! joint is `aᵢ · (Σₖ mₖ g + f)`.

use nalgebra::Vector3;

use super::chain::{JointKind, Robot};
use super::joint_load::JointLoad;
use super::joint_stage::{JointStage, LinkPose};
use crate::se3::{self, Pose, Twist};

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
    /// one, and none of an arm whose torques are measured.
    pub fn of(robot: &Robot) -> Gravity {
        if robot.has_measured_torques() {
            return Gravity { acceleration: Vector3::zeros(), masses: vec![Masses::NONE; robot.dof() + 1] };
        }
        let masses = if robot.has_masses() { link_masses(robot) } else { default_masses(robot.dof()) };
        Gravity { acceleration: *robot.gravity(), masses }
    }

    /// Mass (kg) and its centre (m) in the frame of each moving link, the tip's last; the centre of
    /// no mass is zero.
    pub fn masses(&self) -> impl Iterator<Item = (f64, Vector3<f64>)> {
        let center = |masses: &Masses| if masses.mass > 0.0 { masses.moment / masses.mass } else { Vector3::zeros() };
        self.masses.iter().map(move |masses| (masses.mass, center(masses)))
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

/// Torques of gravity and of a load at one posture, in base, or measured ones.
#[derive(Clone, Debug)]
pub(super) struct JointTorques {
    joints: Vec<LoadedJoint>,
    /// Pose of the tip.
    tip: LinkPose,
    /// Masses at the tip, about the base's origin.
    tip_masses: Masses,
    gravity: Vector3<f64>,
    /// Force (N) at the tip's origin, and moment (N m) about it.
    force: Vector3<f64>,
    moment: Vector3<f64>,
    /// Measured torques of the joints (N m, N), if the load is these.
    measured: Option<Vec<f64>>,
}

/// A joint, and what it carries.
#[derive(Clone, Copy, Debug)]
struct LoadedJoint {
    axis: Vector3<f64>,
    position: Vector3<f64>,
    prismatic: bool,
    /// Masses of the links from here on, about the base's origin.
    carried: Masses,
}

impl LoadedJoint {
    /// First moment of what the joint carries about its own origin (kg m).
    fn lever(&self) -> Vector3<f64> {
        self.carried.moment - self.position * self.carried.mass
    }

    /// Velocity of a point that the joint carries, for a unit of the joint's motion.
    fn velocity(&self, point: &Vector3<f64>) -> Vector3<f64> {
        if self.prismatic { self.axis } else { self.axis.cross(&(point - self.position)) }
    }
}

impl JointTorques {
    /// Of an arm with so many moving joints; without meaning before [`JointTorques::update`].
    pub fn new(dof: usize) -> Self {
        let zero = Vector3::zeros();
        let joint = LoadedJoint { axis: zero, position: zero, prismatic: false, carried: Masses::NONE };
        JointTorques {
            joints: vec![joint; dof],
            tip: LinkPose::base(),
            tip_masses: Masses::NONE,
            gravity: zero,
            force: zero,
            moment: zero,
            measured: None,
        }
    }

    /// Moves the arm to joint positions (rad, m; encoder offsets taken off) under `load`.
    pub fn update(
        &mut self,
        gravity: &Gravity,
        load: JointLoad<'_>,
        (stages, tip): (&[JointStage], &JointStage),
        positions: &[f64],
    ) {
        let load = match load {
            JointLoad::OnTip(load) => load,
            JointLoad::Torques(torques) => {
                let measured = self.measured.get_or_insert_default();
                measured.clear();
                measured.extend_from_slice(torques);
                measured.resize(self.joints.len(), 0.0);
                return;
            }
        };
        self.measured = None;
        let mut frame = LinkPose::base();
        for (((joint, stage), &position), masses) in
            self.joints.iter_mut().zip(stages).zip(positions).zip(&gravity.masses)
        {
            frame.advance_to_joint(stage);
            joint.axis = frame.rotation * stage.axis;
            joint.position = frame.position;
            joint.prismatic = stage.prismatic;
            frame.advance_through_joint(stage, position);
            joint.carried = masses.seen_from_base(&frame);
        }
        frame.advance_to_joint(tip);
        self.tip_masses = gravity.masses.last().map_or(Masses::NONE, |masses| masses.seen_from_base(&frame));
        let mut carried = self.tip_masses;
        for joint in self.joints.iter_mut().rev() {
            carried.add(&joint.carried);
            joint.carried = carried;
        }
        let [x, y, z, about_x, about_y, about_z] = *load;
        self.gravity = gravity.acceleration;
        self.force = frame.rotation * Vector3::new(x, y, z);
        self.moment = frame.rotation * Vector3::new(about_x, about_y, about_z);
        self.tip = frame;
    }

    /// Torque (N m) about joint `i`; of a prismatic one the force (N) along it.
    pub fn torque(&self, i: usize) -> f64 {
        let joint = &self.joints[i];
        if let Some(measured) = &self.measured {
            return measured[i];
        }
        if joint.prismatic {
            return joint.axis.dot(&(self.gravity * joint.carried.mass + self.force));
        }
        let of_load = (self.tip.position - joint.position).cross(&self.force) + self.moment;
        joint.axis.dot(&(joint.lever().cross(&self.gravity) + of_load))
    }

    /// Derivative of the torque about joint `i` by the position of joint `j` (N m per rad or m),
    /// the load being fixed to the tip.
    pub fn slope(&self, i: usize, j: usize) -> f64 {
        let (axis, zero) = (self.joints[j].axis, Vector3::zeros());
        let (velocity, rotation) = if self.joints[j].prismatic { (axis, zero) } else { (zero, axis) };
        self.slope_by_origin(i, j, &velocity, &rotation)
    }

    /// Derivative of the torque about joint `i` (N m) by a motion of the origin of joint `j` and of
    /// all that follows, the tip for `j` beyond the joints: the origin's `velocity` (m) and the
    /// `rotation` (rad) about it. The load is fixed to the tip; a measured torque stays as it is.
    pub fn slope_by_origin(&self, i: usize, j: usize, velocity: &Vector3<f64>, rotation: &Vector3<f64>) -> f64 {
        let joint = &self.joints[i];
        if self.measured.is_some() {
            return 0.0;
        }
        // Masses and load turn with the joint, the direction of gravity does not.
        let turned_gravity = rotation.cross(&self.gravity);
        match (j <= i, joint.prismatic) {
            (true, true) => return -joint.axis.dot(&turned_gravity) * joint.carried.mass,
            (true, false) => return -joint.axis.dot(&joint.lever().cross(&turned_gravity)),
            (false, true) => return joint.axis.dot(&rotation.cross(&self.force)),
            (false, false) => {}
        }
        let (position, carried) = match self.joints.get(j) {
            Some(mover) => (mover.position, mover.carried),
            None => (self.tip.position, self.tip_masses),
        };
        let moved_masses = velocity * carried.mass + rotation.cross(&(carried.moment - position * carried.mass));
        let tip_velocity = velocity + rotation.cross(&(self.tip.position - position));
        let change = moved_masses.cross(&self.gravity)
            + tip_velocity.cross(&self.force)
            + (self.tip.position - joint.position).cross(&rotation.cross(&self.force))
            + rotation.cross(&self.moment);
        joint.axis.dot(&change)
    }

    /// Derivative of the torque about joint `i` by the load (m; 1), zero of a measured torque.
    ///
    /// The power of the load is the same in joints and at the tip, so that this derivative is the
    /// twist of the tip, in the tip's frame, by the joint's motion.
    pub fn by_load(&self, i: usize) -> Twist {
        let joint = &self.joints[i];
        if self.measured.is_some() {
            return Twist::zeros();
        }
        let into_tip = self.tip.rotation.transpose();
        let rotation = if joint.prismatic { Vector3::zeros() } else { into_tip * joint.axis };
        se3::twist(&(into_tip * joint.velocity(&self.tip.position)), &rotation)
    }
}
