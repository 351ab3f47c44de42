//! What a wrench in a log says of the load under which joints give way.

use nalgebra::Vector3;

use crate::contact::ContactLog;
use crate::robot::{Kinematics, Robot};
use crate::se3::{Pose, Wrench};

/// Whose wrench it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadOn {
    /// What the fixture exerts on the tool.
    Tool,
    /// What the tool exerts on the fixture.
    Fixture,
}

/// The frame along whose axes it is given; it is about the tip's origin in either.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoadFrame {
    /// The arm's tip link.
    #[default]
    Tip,
    /// The arm's base link.
    Base,
}

/// How a log's wrench is to be understood as a load. The tool's weight must not be in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Load {
    /// Whose it is.
    pub on: LoadOn,
    /// Along which axes.
    pub frame: LoadFrame,
}

impl Load {
    /// Makes loads on the tool along the tip's axes of the wrenches of all contacts from number
    /// `first` on. The nominal arm says how the tip is turned: what its errors of some degrees
    /// change in a torque is far less than the torque.
    pub(super) fn apply(self, robot: &Robot, log: &mut ContactLog, first: usize) {
        let kinematics = Kinematics::new(robot, &[], Pose::identity());
        let sign = if self.on == LoadOn::Tool { 1.0 } else { -1.0 };
        log.change_loads(first, |q, [fx, fy, fz, tx, ty, tz]| {
            let (mut force, mut torque) = (sign * Vector3::new(fx, fy, fz), sign * Vector3::new(tx, ty, tz));
            if self.frame == LoadFrame::Base {
                let tip_from_base = kinematics.pose(q).rotation.inverse();
                (force, torque) = (tip_from_base * force, tip_from_base * torque);
            }
            let load: Wrench = [force.x, force.y, force.z, torque.x, torque.y, torque.z];
            load
        });
    }
}
