//! How long the parts of a calibration take, on one core. `cargo bench -p touchcal --bench speed`
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, reason = "a bench ends by panicking")]

#[path = "../tests/support/mod.rs"]
mod support;

use std::hint::black_box;
use std::sync::Arc;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main};
use support::parts::{block, peg, solid};
use support::{data, mujoco_trial, solve};
use touchcal::estimate::Problem;
use touchcal::geometry::{GapQuery, MeshPair, Polygon, PrismPair};
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::urdf::{self, Ends};
use touchcal::manifold::PegInHole;
use touchcal::parameter::{Parameter, joint_compliance, joint_offset, strain};
use touchcal::robot::{KinematicParameter, Kinematics};
use touchcal::se3::Pose;

fn kinematics(criterion: &mut Criterion) {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot;
    let parameters: Vec<Parameter> = std::iter::once(strain()).chain(joint_offset(&robot)).collect();
    let columns: Vec<KinematicParameter> = parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect();
    let kinematics = Kinematics::new(&robot, &columns, Pose::translation(0.0, 0.0, 0.15));
    let mut scratch = kinematics.scratch();
    let q = [0.1, 0.7, 0.3, -1.6, -0.2, 0.9, 0.05];
    criterion.bench_function("forward kinematics", |b| b.iter(|| kinematics.pose(black_box(&q))));
    criterion.bench_function("forward kinematics and Jacobian, 7 joints, 8 parameters", |b| {
        b.iter(|| kinematics.pose_and_jacobian(black_box(&q), &mut scratch))
    });
    let parameters = [parameters, joint_compliance(&robot)].concat();
    let columns: Vec<KinematicParameter> = parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect();
    let bending = Kinematics::new(&robot, &columns, Pose::translation(0.0, 0.0, 0.15));
    let mut scratch = bending.scratch();
    criterion.bench_function("forward kinematics and Jacobian of an arm that bends, 15 parameters", |b| {
        b.iter(|| bending.pose_and_jacobian(black_box(&q), &mut scratch))
    });
}

fn gap(criterion: &mut Criterion) {
    let peg = Polygon::extrusion25();
    let hole = peg.offset_mitred(0.5e-3).unwrap();
    let parts = PrismPair::new(peg, 0.04, hole, 0.03).unwrap();
    let pose = Pose::new(nalgebra::Vector3::new(0.3e-3, -0.2e-3, -0.014), nalgebra::Vector3::new(0.005, -0.004, 0.006));
    criterion.bench_function("gap of a T-slot peg", |b| b.iter(|| parts.gap(black_box(&pose))));
    criterion.bench_function("blended gap of a T-slot peg", |b| b.iter(|| parts.blended_gap(black_box(&pose), 25e-6)));
}

/// Solves on one thread, as the figures are meant.
fn on_one_core(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, problem: &Problem) {
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    group.bench_function(name, |b| b.iter(|| one_core.install(|| solve(black_box(problem)))));
}

fn calibration(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("calibration on one core");
    group.sample_size(10);
    for trial in ["extrusion/paper/trial_00", "extrusion/rich/trial_00", "square/paper/trial_00"] {
        on_one_core(&mut group, &format!("{trial}, 3000 contacts"), &mujoco_trial(trial).0);
    }
    let (mut meshes, _) = mujoco_trial("extrusion/paper/trial_00");
    let outline = Polygon::extrusion25();
    let hole = solid(&block(&outline.offset_mitred(0.5e-3).unwrap(), 0.03));
    let peg = solid(&peg(&outline, 0.04));
    let name = format!("extrusion/paper/trial_00, peg as {} triangles", peg.triangle_count());
    meshes.fixtures[0].manifold = Arc::new(PegInHole::with_depth(MeshPair::new(peg, hole), 0.03));
    on_one_core(&mut group, &name, &meshes);
    let folder = data().join("mukca");
    let urdf = urdf::read_file(&folder.join("panda.urdf"), Ends::default()).unwrap();
    let panda = mukca::read(&folder.join("panda_3"), urdf, &MukcaOptions::default()).unwrap();
    on_one_core(&mut group, "panda_3, six placements of two sockets", &panda.problem);
    group.finish();
}

criterion_group!(benches, kinematics, gap, calibration);
criterion_main!(benches);
