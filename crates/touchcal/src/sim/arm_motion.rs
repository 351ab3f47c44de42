//! The motion of a simulated arm from row to row.

use std::f64::consts::TAU;

use super::inverse_kinematics::Follower;
use crate::robot::{JointKind, Kinematics, Robot};
use crate::se3::{Pose, Wrench};

/// An arm that follows poses, row by row.
pub(super) struct ArmMotion<'a> {
    follower: Follower<'a>,
    turns: WholeTurns,
    /// Positions (rad or m) of the last row; empty before the first.
    last: Vec<f64>,
}

impl<'a> ArmMotion<'a> {
    /// Of an arm with these kinematics, and the limits of `robot`.
    pub fn new(kinematics: &'a Kinematics, robot: &Robot) -> Self {
        ArmMotion { follower: Follower::new(kinematics), turns: WholeTurns::of(robot), last: Vec::new() }
    }

    /// Moves `joints` to where the arm reaches the pose under a load, as
    /// [`follow`](super::follow) does, and those that turn further than once by whole turns within
    /// their limits to where they are nearest to the row before, or to `posture` in the first row.
    /// False if the pose is not reached.
    pub fn reach(&mut self, target: (&Pose, &Wrench), joints: &mut [f64], posture: &[f64]) -> bool {
        let mut towards = posture.to_vec();
        self.turns.bring(&mut towards, joints);
        if !self.follower.follow(target, joints, &towards) {
            // A far jump: there may be a way from the posture itself.
            joints.copy_from_slice(posture);
            if !self.follower.follow(target, joints, posture) {
                return false;
            }
        }
        self.turns.bring(joints, if self.last.is_empty() { posture } else { &self.last });
        self.last.clear();
        self.last.extend_from_slice(joints);
        true
    }
}

/// Which joints reach the same pose at several positions, whole turns apart.
pub(super) struct WholeTurns {
    /// Limits (rad) of each moving joint, infinite without any; `None` for a joint within one turn.
    limits: Vec<Option<[f64; 2]>>,
}

impl WholeTurns {
    /// The joints of `robot`.
    pub fn of(robot: &Robot) -> Self {
        let limits = robot.moving().map(|joint| match (joint.kind, &joint.limits) {
            (JointKind::Fixed | JointKind::Prismatic, _) => None,
            (JointKind::Continuous, _) | (JointKind::Revolute, None) => Some([f64::NEG_INFINITY, f64::INFINITY]),
            (JointKind::Revolute, Some(limits)) => Some([limits.lower, limits.upper]),
        });
        WholeTurns { limits: limits.map(|limits| limits.filter(|[lower, upper]| upper - lower > TAU)).collect() }
    }

    /// Moves positions `q` (rad or m) that are more than half a turn from `near` by whole turns to
    /// where they are nearest to it within the limits; one that is within them at no turn stays.
    pub fn bring(&self, q: &mut [f64], near: &[f64]) {
        for ((q, near), limits) in q.iter_mut().zip(near).zip(&self.limits) {
            let Some([lower, upper]) = limits else { continue };
            let nearest = ((near - *q) / TAU).round();
            if nearest == 0.0 {
                continue;
            }
            let distance = |position: &f64| (position - near).abs();
            let turned = [nearest - 1.0, nearest, nearest + 1.0].map(|turns| *q + turns * TAU);
            let within = turned.into_iter().filter(|position| (*lower..=*upper).contains(position));
            *q = within.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(*q);
        }
    }
}
