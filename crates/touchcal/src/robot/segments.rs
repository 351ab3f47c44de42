//! Runs of joint origins whose lengths can be strained independently.

use nalgebra::Vector3;

use super::chain::{JointKind, Robot};
use crate::se3::Pose;

/// Directions closer than this (sine of the angle between them) count as parallel: 0.06°, below
/// what a link's drawing holds.
const PARALLEL: f64 = 1e-3;
/// A translation shorter than this (m) is no length to strain.
const SHORTEST: f64 = 1e-6;

/// A run of joint origins whose translations lie on one line in every configuration, so that the
/// data determine only the sum of their lengths.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Names of the joints at whose origins the run begins and ends, `joint_a1..joint_a2`; one name
    /// for a run of one origin.
    pub name: String,
    /// Length of the run, the distance from its begin to its end (m) in the nominal chain.
    pub length: f64,
    /// Indices into [`Robot::joints`] of the joints whose origins form the run, ascending; at least
    /// one.
    pub joints: Vec<usize>,
}

/// The segments of a chain, base first; empty for a chain without lengths. Segment `k` here is that
/// of [`KinematicParameter::SegmentStrain`](super::KinematicParameter::SegmentStrain).
///
/// Translations merge across a joint exactly when both lie along its axis (an iiwa's 0.1575 +
/// 0.2025 m), within 1e-3 rad, or when no joint moves between them; never across a prismatic joint.
/// Joint origins with a translation of at most 1e-6 m belong to no segment.
pub fn segments(robot: &Robot) -> Vec<Segment> {
    let mut found: Vec<Segment> = Vec::new();
    // The open segment's vector in the current frame, while nothing has yet turned it away from
    // what follows.
    let mut open: Option<Vector3<f64>> = None;
    for (index, joint) in robot.joints().iter().enumerate() {
        let Pose { translation, rotation } = joint.parent_from_joint;
        let step = translation.vector;
        if step.norm() > SHORTEST {
            // Between fixed joints everything is one rigid body, whatever the directions.
            let rigid = index > 0 && robot.joints()[index - 1].kind == JointKind::Fixed && open.is_some();
            let run = open.filter(|run| rigid || parallel(run, &step));
            open = match (run, found.last_mut()) {
                (Some(run), Some(last)) => {
                    let sum = run + step;
                    last.length = sum.norm();
                    last.name = format!("{}..{}", first_name(robot, last), joint.name);
                    last.joints.push(index);
                    Some(sum)
                }
                _ => {
                    found.push(Segment { name: joint.name.clone(), length: step.norm(), joints: vec![index] });
                    Some(step)
                }
            };
        }
        open = open.map(|run| rotation.inverse() * run).filter(|run| match joint.kind {
            JointKind::Fixed => true,
            JointKind::Revolute | JointKind::Continuous => parallel(run, &joint.axis),
            JointKind::Prismatic => false,
        });
    }
    found
}

fn first_name<'r>(robot: &'r Robot, segment: &Segment) -> &'r str {
    segment.joints.first().map_or("", |&first| &robot.joints()[first].name)
}

fn parallel(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    a.cross(b).norm() <= PARALLEL * a.norm() * b.norm()
}

/// The segment that each joint's origin belongs to, indices as in [`segments`]; none for origins
/// without a translation.
pub(super) fn segment_of_each_joint(robot: &Robot) -> Vec<Option<usize>> {
    let mut of = vec![None; robot.joints().len()];
    for (k, segment) in segments(robot).iter().enumerate() {
        for &joint in &segment.joints {
            of[joint] = Some(k);
        }
    }
    of
}
