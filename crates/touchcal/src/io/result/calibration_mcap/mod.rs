//! A calibration as MCAP (cargo feature `mcap`), which Foxglove and Rerun open: ROS 2 messages in
//! CDR.
//!
//! | topic | type | what |
//! |---|---|---|
//! | `/tf` | `tf2_msgs/msg/TFMessage` | the calibrated arm's links, the tool `touchcal/tool` and the fixtures `touchcal/NAME`, one contact after another |
//! | `/joint_states` | `sensor_msgs/msg/JointState` | measured joint positions of these contacts |
//! | `/contacts/nominal`, `/contacts/calibrated` | `sensor_msgs/msg/PointCloud2` | where either arm puts the tool in them |
//! | `/parts` | `visualization_msgs/msg/MarkerArray` | outlines of fixtures and tool |
//!
//! Contacts are as many as the report draws; the log has no times, so they are 10 ms apart.

mod ros;

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use nalgebra::{Point2, Translation3, UnitQuaternion};

use self::ros::{Drawn, Header, JointState, Marker, MarkerArray, Message, PointCloud2, TfMessage, TransformStamped};
use crate::estimate::{Estimate, Problem};
use crate::io::base::error::{IoError, Place};
use crate::manifold::Shape;
use crate::report::{self, MOST_DRAWN};
use crate::robot::{Joint, JointKind, Kinematics, Robot};
use crate::se3::Pose;

/// Time between contacts (ns).
const STEP: u64 = 10_000_000;
/// The tool's frame.
const TOOL: &str = "touchcal/tool";
/// Diameter of a point and width of a line (m).
const POINT: f64 = 0.004;
const LINE: f64 = 0.0005;
/// Half the side of the piece of a plane that is drawn (m).
const PLANE: f64 = 0.1;
const OF_FIXTURE: [f32; 4] = [0.9, 0.6, 0.1, 1.0];
const OF_TOOL: [f32; 4] = [0.2, 0.5, 0.9, 1.0];

/// The bytes of the MCAP file of a calibration: topics and types as the module lists them, in the
/// frame of the arm's base link unless a message names another (m, rad). Contacts are every n-th of
/// the log, so that they are at most [`MOST_DRAWN`].
///
/// # Errors
/// [`IoError::Syntax`] if the mcap crate cannot write them.
pub fn to_bytes(problem: &Problem, estimate: &Estimate) -> Result<Vec<u8>, IoError> {
    write(problem, estimate).map_err(|error| IoError::syntax(Place::file("MCAP"), error.to_string()))
}

fn write(problem: &Problem, estimate: &Estimate) -> Result<Vec<u8>, McapError> {
    let log = &problem.contacts;
    let drawn: Vec<usize> = (0..log.len()).step_by(log.len().div_ceil(MOST_DRAWN).max(1)).collect();
    let nominal_tool = problem.tool.tip_from_tool;
    let tool = nominal_tool * estimate.tool_motion().unwrap_or_else(Pose::identity);
    let calibrated = Kinematics::new(&estimate.robot, &[], tool);
    let before = report::positions(log, &drawn, &Kinematics::new(&problem.robot, &[], nominal_tool));
    let after = report::positions(log, &drawn, &calibrated);
    let places = report::places(problem, estimate, &drawn, &after);

    let mut bag = Bag::new()?;
    let base = estimate.robot.base();
    bag.add("/parts", STEP, &MarkerArray { markers: markers(problem) })?;
    bag.add("/contacts/nominal", STEP, &PointCloud2::new(Header::new(STEP, base), &before))?;
    bag.add("/contacts/calibrated", STEP, &PointCloud2::new(Header::new(STEP, base), &after))?;
    let names: Vec<String> = estimate.robot.moving().map(|joint| joint.name.clone()).collect();
    for (&contact, k) in drawn.iter().zip(1..) {
        let (time, q) = (k * STEP, log.q(contact));
        let mut transforms = links(&estimate.robot, q, time);
        transforms.push(TransformStamped::new(
            time,
            base,
            TOOL,
            &calibrated.pose_under(q, log.load_on_joints(contact, &log.load(contact))),
        ));
        for (fixture, place) in problem.fixtures.iter().zip(&places) {
            let transform = |place| TransformStamped::new(time, base, &frame(&fixture.name), place);
            transforms.extend(place.as_ref().map(transform));
        }
        bag.add("/tf", time, &TfMessage { transforms })?;
        let (name, position) = (names.clone(), q.to_vec());
        let state = JointState { header: Header::new(time, ""), name, position, velocity: vec![], effort: vec![] };
        bag.add("/joint_states", time, &state)?;
    }
    bag.finish()
}

fn frame(fixture: &str) -> String {
    format!("touchcal/{fixture}")
}

/// Each link in the frame of the one that carries it, at measured joint positions `q`.
fn links(robot: &Robot, q: &[f64], time: u64) -> Vec<TransformStamped> {
    let mut positions = q.iter();
    let mut parent = robot.base();
    let mut transforms = Vec::with_capacity(robot.joints().len() + 1);
    for joint in robot.joints() {
        let position = if joint.kind == JointKind::Fixed { 0.0 } else { positions.next().copied().unwrap_or(0.0) };
        let pose = joint.parent_from_joint * motion(joint, position);
        transforms.push(TransformStamped::new(time, parent, &joint.child_link, &pose));
        parent = &joint.child_link;
    }
    transforms
}

fn motion(joint: &Joint, position: f64) -> Pose {
    match joint.kind {
        JointKind::Fixed => Pose::identity(),
        JointKind::Prismatic => Translation3::from(joint.axis.into_inner() * position).into(),
        JointKind::Revolute | JointKind::Continuous => {
            Pose::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&joint.axis, position))
        }
    }
}

/// Fixtures and the tool, each in its frame.
fn markers(problem: &Problem) -> Vec<Marker> {
    let marker = |frame: &str, shape: &Shape, color| {
        let (drawn, points) = match shape {
            Shape::Point => (Drawn::Ball(POINT), vec![]),
            Shape::Ball { radius } => (Drawn::Ball(2.0 * radius), vec![]),
            Shape::Prism { outline, from, to } => (Drawn::Lines(LINE), prism(outline, *from, *to)),
            Shape::Plane => {
                let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
                (Drawn::Lines(LINE), prism(&corners.map(|(x, y)| Point2::new(PLANE * x, PLANE * y)), 0.0, 0.0))
            }
        };
        Marker::new(Header::new(STEP, frame), frame, drawn, points, color)
    };
    let fixtures = problem.fixtures.iter();
    let mut markers: Vec<Marker> =
        fixtures.map(|fixture| marker(&frame(&fixture.name), &fixture.manifold.sketch().fixture, OF_FIXTURE)).collect();
    if let Some(fixture) = problem.fixtures.first() {
        markers.push(marker(TOOL, &fixture.manifold.sketch().tool, OF_TOOL));
    }
    markers
}

/// The edges of a straight piece, each as two points.
fn prism(outline: &[Point2<f64>], from: f64, to: f64) -> Vec<[f64; 3]> {
    let next = outline.iter().cycle().skip(1);
    outline
        .iter()
        .zip(next)
        .flat_map(|(a, b)| {
            [[a.x, a.y, from], [b.x, b.y, from], [a.x, a.y, to], [b.x, b.y, to], [a.x, a.y, from], [a.x, a.y, to]]
        })
        .collect()
}

/// An MCAP file in the making.
struct Bag {
    writer: Writer<Cursor<Vec<u8>>>,
    /// By topic, channel and number of messages.
    channels: BTreeMap<&'static str, (u16, u32)>,
}

impl Bag {
    fn new() -> Result<Bag, McapError> {
        let options = WriteOptions::new().profile("ros2").library(concat!("touchcal ", env!("CARGO_PKG_VERSION")));
        Ok(Bag { writer: options.create(Cursor::new(Vec::new()))?, channels: BTreeMap::new() })
    }

    fn add<M: Message>(&mut self, topic: &'static str, time: u64, message: &M) -> Result<(), McapError> {
        let (channel_id, sequence) = match self.channels.get(topic) {
            Some(known) => *known,
            None => {
                let schema = self.writer.add_schema(M::NAME, "ros2msg", M::DEFINITION.as_bytes())?;
                (self.writer.add_channel(schema, topic, "cdr", &BTreeMap::new())?, 0)
            }
        };
        self.channels.insert(topic, (channel_id, sequence + 1));
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        let data = message.to_cdr().map_err(|error| std::io::Error::other(error.to_string()))?;
        self.writer.write_to_known_channel(&header, &data)
    }

    fn finish(mut self) -> Result<Vec<u8>, McapError> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().into_inner())
    }
}
