//! A calibration as MCAP, read by the crates `mcap` and `cdr-encoding`, and as a log by touchcal
//! itself: the frames are the calibrated arm's.

use byteorder::LittleEndian;
use mcap::MessageStream;
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use touchcal::contact::ContactLog;
use touchcal::estimate::{Estimate, Problem};
use touchcal::io::calibration_mcap;
use touchcal::io::contact_log::{self, Options};
use touchcal::robot::Kinematics;
use touchcal::se3::Pose;

use crate::support::{mujoco_trial, solve};

#[derive(Deserialize)]
struct Transform {
    _stamp: (i32, u32),
    parent: String,
    child: String,
    translation: [f64; 3],
    rotation: [f64; 4],
}

impl Transform {
    fn pose(&self) -> Pose {
        let ([x, y, z], [i, j, k, w]) = (self.translation, self.rotation);
        Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)))
    }
}

#[derive(Deserialize)]
struct Cloud {
    _header: ((i32, u32), String),
    _size: (u32, u32),
    _fields: Vec<(String, u32, u8, u32)>,
    _bigendian: bool,
    _steps: (u32, u32),
    data: Vec<u8>,
}

fn calibrated() -> (Problem, Estimate, Vec<u8>) {
    let (mut problem, _) = mujoco_trial("extrusion/paper/trial_00");
    problem.contacts = problem.contacts.filtered(|i| i % 10 == 0);
    let estimate = solve(&problem);
    let bytes = calibration_mcap::to_bytes(&problem, &estimate).unwrap();
    (problem, estimate, bytes)
}

/// All messages of a topic.
fn messages<T: DeserializeOwned>(bytes: &[u8], topic: &str) -> Vec<T> {
    let all = MessageStream::new(bytes).unwrap().map(Result::unwrap);
    let data = all.filter(|message| message.channel.topic == topic).map(|message| message.data.into_owned());
    data.map(|data| cdr_encoding::from_bytes::<T, LittleEndian>(&data[4..]).unwrap().0).collect()
}

#[test]
fn frames_chain_to_where_the_calibrated_tool_was() {
    let (problem, estimate, bytes) = calibrated();
    let log = &problem.contacts;
    let tool = problem.tool.tip_from_tool * estimate.tool_motion().unwrap_or_else(Pose::identity);
    let arm = Kinematics::new(&estimate.robot, &[], tool);
    let moments: Vec<Vec<Transform>> = messages(&bytes, "/tf");
    assert_eq!(moments.len(), log.len());
    for (i, transforms) in moments.iter().enumerate() {
        let mut tip = Pose::identity();
        let mut link = estimate.robot.base();
        while link != estimate.robot.tip() {
            let next = transforms
                .iter()
                .find(|transform| transform.parent == link && !transform.child.starts_with("touchcal/"));
            let next = next.unwrap();
            tip *= next.pose();
            link = &next.child;
        }
        let frame = |name: &str| transforms.iter().find(|transform| transform.child == name).unwrap().pose();
        let (tool_now, hole) = (arm.pose(log.q(i)), problem.fixtures[0].base_from_fixture.unwrap());
        for (expected, found) in
            [(tool_now, tip * tool), (tool_now, frame("touchcal/tool")), (hole, frame("touchcal/hole"))]
        {
            let off = expected.inverse() * found;
            assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle() < 1e-7, "{i}: {off}");
        }
    }
    for (topic, kinematics) in [
        ("/contacts/calibrated", &arm),
        ("/contacts/nominal", &Kinematics::new(&problem.robot, &[], problem.tool.tip_from_tool)),
    ] {
        let points = &messages::<Cloud>(&bytes, topic)[0].data;
        assert_eq!(points.len(), 12 * log.len());
        for (i, point) in points.chunks(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).enumerate() {
            let expected = kinematics.pose(log.q(i / 3)).translation.vector[i % 3];
            assert!((f64::from(point) - expected).abs() < 1e-6);
        }
    }
}

#[test]
fn touchcal_reads_the_joint_positions_back() {
    let (problem, _, bytes) = calibrated();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("calibration.mcap");
    std::fs::write(&path, bytes).unwrap();
    let mut log = ContactLog::new(7);
    contact_log::read_file(&path, &problem.robot, &Options::default(), &mut log).unwrap();
    assert_eq!(log.len(), problem.contacts.len());
    assert!((0..log.len()).all(|i| log.q(i) == problem.contacts.q(i)));
}
