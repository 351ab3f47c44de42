//! Calibrations with meshes: what they find is what outlines of the same parts find, from the same
//! contacts.

use std::sync::Arc;

use crate::support::parts::{Mesh, block, block_around, lofted, obj, peg, rounded, solid, stl};
use crate::support::{data, mujoco_trial, simulated, timed};
use nalgebra::{Point2, Point3};
use touchcal::estimate::{Estimate, Loss, Method, Noise, Problem};
use touchcal::experiment::{Search, Trial};
use touchcal::geometry::{MeshPair, Parts, Polygon, PrismPair};
use touchcal::io::urdf::{self, Ends};
use touchcal::io::{mesh, problem_file};
use touchcal::manifold::{ContactManifold, PegInHole, peg_in_hole};
use touchcal::parameter::ParameterId;
use touchcal::sim::Preset;

/// Largest difference of a parameter, in standard deviations.
fn apart(a: &Estimate, b: &Estimate) -> f64 {
    let pairs = a.parameters.iter().zip(&b.parameters);
    pairs.filter_map(|(a, b)| Some((a.value - b.value).abs() / a.sigma?.max(b.sigma?))).fold(0.0, f64::max)
}

/// The problem of a MuJoCo trial's contacts with the parts, which are straight, as STL files.
fn with_files(trial: &str, peg: &Mesh, hole: &Mesh) -> Result<Problem, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("peg.stl"), stl(peg)).unwrap();
    std::fs::write(folder.path().join("hole.stl"), stl(hole)).unwrap();
    let log = data().join("mujoco_iiwa14").join(trial).join("contact.csv.gz");
    let text = format!(
        r#"
[robot]
builtin = "iiwa14"
[tool]
kind = "peg"
tip_from_tool = {{ xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }}
mesh = "peg.stl"
exact = true
[[fixture]]
name = "hole"
kind = "hole"
base_from_fixture = {{ xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }}
mesh = "hole.stl"
mesh_unit = "mm"
depth_mm = 30
exact = true
[[contacts]]
file = {:?}
fixture = "hole"
[noise]
encoder_deg = 0.002
contact_mm = 0.02
encoder_trend_deg = 0
[estimate]
parameters = ["strain", "joint_offset"]
"#,
        log.display().to_string()
    );
    let loaded = problem_file::read(&text, "problem.toml", folder.path()).map_err(|error| error.to_string())?;
    assert_eq!(loaded.inputs.len(), 4, "{:?}", loaded.inputs);
    assert_eq!(loaded.problem.fixtures[0].manifold.name(), "peg in hole");
    Ok(loaded.problem)
}

#[test]
fn meshes_that_lie_otherwise_in_their_frames_are_refused() {
    let outline = Polygon::extrusion25();
    let (peg, hole) = (peg(&outline, 0.04), block(&outline.offset_mitred(0.5e-3).unwrap(), 0.03));
    let moved = |(vertices, triangles): &Mesh, z: f64| -> Mesh {
        (vertices.iter().map(|p| Point3::new(p.x, p.y, p.z + z)).collect(), triangles.clone())
    };
    // With its rim where its bottom should be; a peg below its tip.
    for (peg, hole) in [(peg.clone(), moved(&hole, 0.04)), (moved(&peg, -0.04), hole)] {
        let refused = with_files("extrusion/rich/trial_00", &peg, &hole).unwrap_err();
        assert!(
            refused.contains("a hole that the peg fits into") && refused.contains("where the peg's axis lies"),
            "{refused}"
        );
    }
}

#[test]
fn a_problem_with_stl_files_finds_what_its_outlines_find() {
    const TRIAL: &str = "extrusion/rich/trial_00";
    let (outlines, _) = mujoco_trial(TRIAL);
    let slot = Polygon::extrusion25();
    let (peg, hole) = (peg(&slot, 0.04), block(&slot.offset_mitred(0.5e-3).unwrap(), 0.03));
    assert!(peg.1.len() >= 1000, "{}", peg.1.len());
    let files = with_files(TRIAL, &peg, &hole).unwrap();
    let mut meshes = files.clone();
    meshes.fixtures[0].manifold = Arc::new(PegInHole::with_depth(MeshPair::new(solid(&peg), solid(&hole)), 0.03));
    let [(with_outlines, straight_s), (with_files, files_s), (with_meshes, mesh_s)] =
        [&outlines, &files, &meshes].map(timed);
    let (of_files, of_meshes) = (apart(&with_outlines, &with_files), apart(&with_outlines, &with_meshes));
    println!(
        "T-slot, {} contacts | {straight_s:.2} s as outlines; {of_files:.2e} sigma apart, {files_s:.2} s as straight meshes; {of_meshes:.2e} sigma apart, {mesh_s:.2} s as any meshes",
        outlines.contacts.len()
    );
    assert!(of_files < 1e-3, "{of_files}");
    assert!(of_meshes < 0.05, "{of_meshes}");
}

/// A T-slot and its hole with their corners rounded by so much (m), each corner by seven points: a
/// thousand triangles in earnest.
fn rounded_parts(peg_radius: f64, hole_radius: f64) -> PrismPair {
    let slot = Polygon::extrusion25();
    let hole = slot.offset_mitred(0.5e-3).unwrap();
    PrismPair::new(rounded(&slot, peg_radius, 7), 0.04, rounded(&hole, hole_radius, 7), 0.03).unwrap()
}

#[test]
fn rounded_meshes_find_what_rounded_outlines_find() {
    let outlines = rounded_parts(0.4e-3, 0.4e-3);
    let peg_mesh = lofted(&[(outlines.peg(), 0.0), (outlines.peg(), 0.04)]);
    assert!(peg_mesh.1.len() >= 1000, "{}", peg_mesh.1.len());
    // OBJ has all digits: where corners are round, a nanometre moves the end of a search.
    let read = |mesh: &Mesh| mesh::read(obj(mesh).as_bytes(), "part.obj", 1e-3).unwrap();
    let hole_mesh = block_around(outlines.hole(), 0.03, 0.04);
    let meshes = peg_in_hole(MeshPair::new(read(&peg_mesh), read(&hole_mesh)), 0.03).unwrap();
    assert_eq!(meshes.name(), "peg in hole");
    let (trial, search) = simulated(&outlines, 1);
    let problem = |manifold: Box<dyn ContactManifold>| trial.problem(manifold, search);

    let (with_outlines, straight_s) = timed(&problem(Box::new(PegInHole::new(outlines))));
    let (with_meshes, mesh_s) = timed(&problem(meshes));
    let apart = apart(&with_outlines, &with_meshes);
    println!(
        "rounded T-slot, {} contacts | {straight_s:.2} s as outlines; {apart:.2e} sigma apart, {mesh_s:.2} s as straight meshes",
        trial.contacts.len()
    );
    assert!(apart < 1e-6, "{apart}");
}

/// Where corners are rounded alike, a contact with both sides of one also touches all directions
/// between them. While these counted as walls of their own, five of fifteen such searches ended
/// with every contact rejected. Where a corner of the hole has the peg's radius and the clearance,
/// it is a curved wall: while its facets counted as walls of their own, noise came out 1.5 times as
/// large as declared. The largest of 48 errors exceeds 3.5 standard deviations by chance once in 45
/// times.
#[test]
#[ignore = "long form: scripts/test long"]
fn rounded_corners_leave_estimates_right() {
    for (peg_radius, hole_radius, seed) in [
        (0.4e-3, 0.4e-3, 2),
        (0.4e-3, 0.9e-3, 1),
        (0.1e-3, 0.1e-3, 2),
        (0.9e-3, 0.9e-3, 2),
        (0.9e-3, 0.9e-3, 3),
        (0.1e-3, 0.6e-3, 1),
    ] {
        let parts = rounded_parts(peg_radius, hole_radius);
        let (trial, search) = simulated(&parts, seed);
        let (estimate, seconds) = timed(&trial.problem(Box::new(PegInHole::new(parts)), search));
        let errors = errors(&trial, &estimate);
        let worst = worst(&errors);
        let strain = 1e4 * errors[0].0.abs();
        println!(
            "radii {peg_radius} {hole_radius} m, seed {seed}: {worst:.2} sigma, strain off by {strain:.2}e-4, noise {:.2}, {seconds:.2} s",
            estimate.noise_factor
        );
        assert!(worst < 3.5 && strain < 2.0, "{peg_radius} {hole_radius} {seed}: {worst} sigma, {strain}e-4");
        assert!(estimate.noise_factor < 1.1, "{peg_radius} {hole_radius} {seed}: {}", estimate.noise_factor);
    }
}

/// Of many walls near, the least gap hardly scatters: noise learned from least gaps alone was seven
/// times too small, so that hardly a wall was in reach, and errors were seven standard deviations.
#[test]
fn noise_is_learned_where_corners_are_rounded() {
    let bar = |half_length: f64, half_width: f64, radius: f64| {
        let corner = |x: f64, y: f64| Point2::new(x * half_length, y * half_width);
        rounded(
            &Polygon::new(vec![corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)]).unwrap(),
            radius,
            7,
        )
    };
    let parts = PrismPair::new(bar(15e-3, 10e-3, 2e-3), 0.04, bar(15.5e-3, 10.5e-3, 2.5e-3), 0.03).unwrap();
    for seed in [1, 2] {
        let mut scenario =
            Preset::Paper.scenario(urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot).unwrap();
        scenario.touches[0].parts = Parts::PegInHole(Box::new(parts.clone()));
        let trial = Trial::simulated(&scenario, seed).unwrap();
        // As where the problem file says nothing: 0.005 deg, of which the arm has 0.002, and 0.05
        // mm, of which there are 0.005.
        let noise = Noise { encoder: 8.7e-5, contact: 50e-6, is_estimated: true };
        let search = Search { method: Method::LevenbergMarquardt, noise, loss: Loss::GemanMcClure(3.0) };
        let (estimate, _) = timed(&trial.problem(Box::new(PegInHole::new(parts.clone())), search));
        let worst = worst(&errors(&trial, &estimate));
        println!("noise learned, seed {seed}: {worst:.2} sigma, {:?}", estimate.warnings);
        assert!(worst < 3.5 && estimate.warnings.is_empty(), "{seed}: {worst} sigma, {:?}", estimate.warnings);
    }
}

/// Error and standard deviation of all that was not right.
fn errors(trial: &Trial, estimate: &Estimate) -> Vec<(f64, f64)> {
    let error = |(column, truth): &(ParameterId, f64)| {
        let found = estimate.parameters.iter().find(|p| p.parameter.id == *column).expect("estimated");
        (found.value - truth, found.sigma.expect("a parameter that contacts determine"))
    };
    trial.truth.iter().map(error).collect()
}

/// The largest error over its standard deviation.
fn worst(errors: &[(f64, f64)]) -> f64 {
    errors.iter().fold(0.0, |worst, (error, sigma)| worst.max((error / sigma).abs()))
}
