//! A measured wrench as the load under which joints deflect.

use nalgebra::Vector3;

use super::log::ContactLog;
use crate::robot::{Kinematics, Robot};
use crate::se3::{Pose, Wrench};

/// The body on which a measured wrench acts: determines its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadOn {
    /// The tool: the wrench is the one that the fixture exerts on the tool.
    Tool,
    /// The fixture: the wrench is the one that the tool exerts on the fixture.
    Fixture,
}

/// Whose torques those of a log are: determines their sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TorqueOf {
    /// Of the load: what gravity and contact exert about a joint on all that it carries.
    Load,
    /// Of the motor: what the joint exerts, at rest the negative of the load's.
    Motor,
}

impl TorqueOf {
    /// The torques of the load.
    pub(super) fn of_load(self, measured: &[f64]) -> Vec<f64> {
        let sign = if self == TorqueOf::Load { 1.0 } else { -1.0 };
        measured.iter().map(|torque| sign * torque).collect()
    }
}

/// The frame in whose axes a wrench is expressed; its reference point is the tip's origin in
/// either.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoadFrame {
    /// The frame of the arm's tip link.
    #[default]
    Tip,
    /// The frame of the arm's base link.
    Base,
}

/// How the measured wrench `[f; τ]` (N, N m) of a log is a load on the arm. The wrench must not
/// contain the tool's weight, and its reference point is the tip's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// The body on which the wrench acts, which determines its sign.
    pub on: LoadOn,
    /// The frame in whose axes the wrench is expressed.
    pub frame: LoadFrame,
    /// Lag `λ` (rows of the log, ≥ 0) of the measured wrench behind the joint positions; 0 for
    /// none. A low-pass filter of the first order with the time constant `T` has one of `1 /
    /// (exp(Δt/T) − 1)`, where rows are `Δt` apart. Not checked; rows must be evenly spaced, and
    /// those without contact must be there.
    pub lag: f64,
}

impl Load {
    /// The wrench in a row without its lag, from the measured ones there and in the row `before`:
    /// measured + λ (measured − before), the inverse of the filter.
    pub(crate) fn without_lag(self, measured: Wrench, before: Option<Wrench>) -> Wrench {
        let before = before.unwrap_or(measured);
        std::array::from_fn(|k| measured[k] + self.lag * (measured[k] - before[k]))
    }

    /// Converts the wrenches of all contacts from number `first` on to loads on the tool in the tip
    /// frame. The tip's orientation is that of the nominal arm: its errors of some degrees change a
    /// torque by far less than the torque.
    pub(super) fn apply(self, robot: &Robot, log: &mut ContactLog, first: usize) {
        if first < log.len() {
            log.set_load_lag(log.source(first).file, self.lag);
        }
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
