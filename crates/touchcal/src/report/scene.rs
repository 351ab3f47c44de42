//! The arm, the parts and the tool's positions, for the three-dimensional view.

use nalgebra::{Point3, Translation3, Vector3};
use serde::Serialize;

use crate::contact::ContactLog;
use crate::estimate::{Estimate, Problem};
use crate::manifold::Shape;
use crate::parameter::ParameterId;
use crate::robot::{JointKind, Kinematics, Robot};
use crate::se3::{self, Pose, Twist};

/// The page's data of the view. Poses are `x, y, z, qx, qy, qz, qw`, lengths in m.
#[derive(Serialize)]
pub(super) struct Scene<'a> {
    nominal: Arm<'a>,
    calibrated: Arm<'a>,
    /// None of a fixture of unknown place.
    fixtures: Vec<Option<Part>>,
    tools: Vec<ShapeEntry>,
    /// Joint positions (rad, m) of each contact drawn.
    q: Vec<Vec<f32>>,
    /// Tool positions at each contact drawn, in base (m), by the nominal and the calibrated arm.
    before: Vec<[f32; 3]>,
    after: Vec<[f32; 3]>,
}

#[derive(Serialize)]
struct Arm<'a> {
    joints: Vec<JointEntry<'a>>,
    tip_from_tool: [f64; 7],
}

#[derive(Serialize)]
struct JointEntry<'a> {
    name: &'a str,
    kind: &'static str,
    parent_from_joint: [f64; 7],
    axis: [f64; 3],
}

/// A fixture at its estimated pose.
#[derive(Serialize)]
struct Part {
    base_from_fixture: [f64; 7],
    shape: ShapeEntry,
}

#[derive(Clone, Serialize, PartialEq)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum ShapeEntry {
    Point,
    Ball { radius: f64 },
    Prism { outline: Vec<[f64; 2]>, from: f64, to: f64 },
    Plane,
}

impl From<&Shape> for ShapeEntry {
    fn from(shape: &Shape) -> Self {
        match shape {
            Shape::Point => ShapeEntry::Point,
            Shape::Ball { radius } => ShapeEntry::Ball { radius: *radius },
            Shape::Prism { outline, from, to } => {
                ShapeEntry::Prism { outline: outline.iter().map(|p| [p.x, p.y]).collect(), from: *from, to: *to }
            }
            Shape::Plane => ShapeEntry::Plane,
        }
    }
}

impl<'a> Scene<'a> {
    /// The view of `problem` and its result, with the contacts of indices `drawn`.
    pub fn new(problem: &'a Problem, estimate: &'a Estimate, drawn: &[usize]) -> Self {
        let nominal_tool = problem.tool.tip_from_tool;
        let tool = nominal_tool * estimate.tool_motion().unwrap_or_else(Pose::identity);
        let log = &problem.contacts;
        let after = positions(log, drawn, &Kinematics::new(&estimate.robot, &[], tool));
        let sketches: Vec<_> = problem.fixtures.iter().map(|fixture| fixture.manifold.sketch()).collect();
        let places = places(problem, estimate, drawn, &after);
        let parts = sketches.iter().zip(&places);
        let mut tools: Vec<ShapeEntry> = sketches.iter().map(|sketch| (&sketch.tool).into()).collect();
        tools.dedup();
        Scene {
            nominal: arm(&problem.robot, &nominal_tool),
            calibrated: arm(&estimate.robot, &tool),
            fixtures: parts
                .map(|(sketch, place)| {
                    let base_from_fixture = place.as_ref().map(numbers)?;
                    Some(Part { base_from_fixture, shape: (&sketch.fixture).into() })
                })
                .collect(),
            tools,
            q: drawn.iter().map(|&i| log.q(i).iter().map(|q| *q as f32).collect()).collect(),
            before: positions(log, drawn, &Kinematics::new(&problem.robot, &[], nominal_tool)),
            after,
        }
    }
}

/// Positions of an arm's tool in the contacts `drawn`, in base (m).
pub(crate) fn positions(log: &ContactLog, drawn: &[usize], kinematics: &Kinematics) -> Vec<[f32; 3]> {
    let position = |&i: &usize| {
        let place = kinematics.pose_under(log.q(i), log.load_on_joints(i, &log.load(i))).translation;
        [place.x as f32, place.y as f32, place.z as f32]
    };
    drawn.iter().map(position).collect()
}

/// Estimated pose of each fixture in base; one without a nominal pose is where the calibrated tool
/// is closest to its targets, or at the mean tool position of its contacts, and without contacts,
/// such as one whose contacts are held out, anywhere: `None`.
pub(crate) fn places(problem: &Problem, estimate: &Estimate, drawn: &[usize], after: &[[f32; 3]]) -> Vec<Option<Pose>> {
    let Problem { fixtures, contacts, .. } = problem;
    let mut twists = vec![Twist::zeros(); fixtures.len()];
    for entry in &estimate.parameters {
        if let ParameterId::Fixture(f, k) = entry.parameter.id {
            twists[f][k] = entry.value;
        }
    }
    let mut touched = vec![(Vec::new(), Vec::new()); fixtures.len()];
    for (&i, place) in drawn.iter().zip(after) {
        let f = contacts.fixture(i);
        touched[f].0.push(Vector3::from(place.map(f64::from)));
        let at_target = fixtures[f].manifold.tool_at_target().zip(contacts.target(i));
        touched[f].1.extend(at_target.map(|(tool, target)| (target * Point3::from(tool)).coords));
    }
    let each = fixtures.iter().zip(twists).zip(touched).map(|((fixture, twist), (tools, targets))| {
        let mean = || Pose::from(Translation3::from(tools.iter().sum::<Vector3<f64>>() / tools.len() as f64));
        let found = fixture.base_from_fixture.map(|place| place * se3::exp(&twist));
        found.or_else(|| match fixture.manifold.tool_at_target() {
            Some(_) if targets.len() > 2 => se3::alignment(&tools, &targets),
            Some(_) => None,
            None => (!tools.is_empty()).then(mean),
        })
    });
    each.collect()
}

fn arm<'a>(robot: &'a Robot, tip_from_tool: &Pose) -> Arm<'a> {
    let joints = robot.joints().iter().map(|joint| JointEntry {
        name: &joint.name,
        kind: match joint.kind {
            JointKind::Fixed => "fixed",
            JointKind::Prismatic => "slides",
            JointKind::Revolute | JointKind::Continuous => "turns",
        },
        parent_from_joint: numbers(&joint.parent_from_joint),
        axis: [joint.axis.x, joint.axis.y, joint.axis.z],
    });
    Arm { joints: joints.collect(), tip_from_tool: numbers(tip_from_tool) }
}

fn numbers(pose: &Pose) -> [f64; 7] {
    let (place, turn) = (&pose.translation, pose.rotation.coords);
    [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w]
}
