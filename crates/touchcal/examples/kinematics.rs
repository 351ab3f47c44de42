//! Poses and Jacobians of an arm with wrong parameters, for comparison with other programs.
//!
//! `cargo run -p touchcal --example kinematics -- arm.urdf ROWS SEED`: prints the parameters'
//! names, their values (compliances 0, the others drawn within their plausible size), and a row for
//! each of ROWS joint positions drawn within half a turn or metre: the positions, the tool's pose
//! in base x,y,z (m), qw,qx,qy,qz, and the twists (of the tool, in its frame: m, then rad) by each
//! joint and by each parameter.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "an example ends by panicking"
)]

use std::path::Path;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{Block, Parameter, ParameterId};
use touchcal::robot::{self, KinematicParameter, Kinematics};
use touchcal::se3::Pose;

fn line(numbers: impl Iterator<Item = f64>) -> String {
    numbers.map(|number| format!("{number:.17e}")).collect::<Vec<_>>().join(",")
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, rows, seed] = arguments.as_slice() else { panic!("expected arm.urdf ROWS SEED") };
    let arm = urdf::read_file(Path::new(path), Ends::default()).unwrap().robot;
    let mut parameters = vec![touchcal::parameter::strain()];
    parameters.extend(touchcal::parameter::segment_strain(&arm));
    parameters.extend(touchcal::parameter::joint_offset(&arm));
    parameters.extend(touchcal::parameter::joint_origin(&arm));
    parameters.extend(touchcal::parameter::joint_compliance(&arm));
    parameters.extend((0..6).map(|k| Parameter::twist("tool", ParameterId::tool(k), k)));
    let columns: Vec<KinematicParameter> = parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect();

    let mut random = StdRng::seed_from_u64(seed.parse().expect("a seed"));
    let mut draw = |size: f64| size * random.random_range(-1.0..=1.0);
    let value = |parameter: &Parameter| match parameter.id.block() {
        Block::JointCompliance => 0.0,
        _ => draw(parameter.scale),
    };
    let theta: Vec<f64> = parameters.iter().map(value).collect();
    println!("{}", parameters.iter().map(|parameter| parameter.name.as_str()).collect::<Vec<_>>().join(","));
    println!("{}", line(theta.iter().copied()));

    let mut kinematics = Kinematics::new(&arm, &columns, Pose::identity());
    kinematics.set(&theta);
    let mut scratch = kinematics.scratch();
    for _ in 0..rows.parse().expect("a number of rows") {
        let reach = |joint: &robot::Joint| match joint.kind {
            robot::JointKind::Prismatic => draw(1.0),
            _ => draw(std::f64::consts::PI),
        };
        let q: Vec<f64> = arm.moving().map(reach).collect();
        let pose = kinematics.pose_and_jacobian(&q, &mut scratch);
        let place = pose.translation.vector;
        let turn = pose.rotation;
        let pose = [place.x, place.y, place.z, turn.w, turn.i, turn.j, turn.k];
        let twists = scratch.joints.iter().chain(&scratch.parameters).flat_map(|twist| twist.iter().copied());
        println!("{}", line(q.iter().copied().chain(pose).chain(twists)));
    }
}
