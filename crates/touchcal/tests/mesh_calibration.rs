//! Calibrations with meshes: what they find is what outlines of the same parts find, from the same contacts.

// Helpers of tests fail by panicking too; the exception in clippy.toml covers only the tests themselves.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

mod common;
#[path = "common/parts.rs"]
mod parts;

use common::{data, mujoco_trial, solve};
use parts::{block, peg, stl};
use touchcal::estimate::{Estimate, Problem};
use touchcal::geometry::profile::Profile;
use touchcal::io::problem_file;

/// Largest difference of a parameter, in standard deviations.
fn apart(a: &Estimate, b: &Estimate) -> f64 {
    let pairs = a.parameters.iter().zip(&b.parameters);
    pairs.filter_map(|(a, b)| Some((a.value - b.value).abs() / a.sigma?.max(b.sigma?))).fold(0.0, f64::max)
}

fn timed(problem: &Problem) -> (Estimate, f64) {
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let start = std::time::Instant::now();
    let estimate = one_core.install(|| solve(problem));
    (estimate, start.elapsed().as_secs_f64())
}

#[test]
fn a_problem_with_stl_files_finds_what_its_outlines_find() {
    let (outlines, _) = mujoco_trial("extrusion/rich/trial_00");
    let folder = tempfile::tempdir().unwrap();
    let slot = Profile::extrusion25();
    let peg = peg(&slot, 0.04);
    assert!(peg.1.len() >= 1000, "{}", peg.1.len());
    std::fs::write(folder.path().join("peg.stl"), stl(&peg)).unwrap();
    std::fs::write(folder.path().join("hole.stl"), stl(&block(&slot.offset_mitred(0.5e-3).unwrap(), 0.03))).unwrap();
    let log = data().join("mujoco_iiwa14/extrusion/rich/trial_00/contact.csv.gz");
    let text = format!(
        r#"
[robot]
builtin = "iiwa14"
[tool]
kind = "peg"
tip_from_tool = {{ xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }}
mesh = "peg.stl"
[[fixture]]
name = "hole"
kind = "hole"
base_from_fixture = {{ xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }}
mesh = "hole.stl"
mesh_unit = "mm"
depth_mm = 30
[[contacts]]
file = {:?}
fixture = "hole"
[noise]
encoder_deg = 0.002
contact_mm = 0.02
[estimate]
parameters = ["strain", "joint_offset"]
"#,
        log.display().to_string()
    );
    let meshes = problem_file::read(&text, "problem.toml", folder.path()).unwrap();
    assert_eq!(meshes.inputs.len(), 4, "{:?}", meshes.inputs);
    let ((with_outlines, straight_s), (with_meshes, mesh_s)) = (timed(&outlines), timed(&meshes.problem));
    let apart = apart(&with_outlines, &with_meshes);
    println!(
        "T-slot as mesh, {} contacts | {apart:.2e} sigma apart, {mesh_s:.2} s, outlines {straight_s:.2} s",
        outlines.contacts.len()
    );
    assert!(apart < 0.05, "{apart}");
}
