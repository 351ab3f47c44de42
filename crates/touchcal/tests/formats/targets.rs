//! Logs whose rows have targets.

use std::path::Path;

use nalgebra::Vector3;
use touchcal::io::problem_file;

use crate::support::refused;

fn read(fixture: &str, contacts: &str, log: &str) -> Result<touchcal::estimate::Problem, String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.csv"), log).expect("a log");
    let text = format!(
        "[robot]\nbuiltin = \"panda\"\n[tool]\nkind = \"ball\"\nradius_mm = 2\n\
         [[fixture]]\nname = \"part\"\nkind = \"target\"\nfree = true\n{fixture}\n\
         [[contacts]]\nfile = \"log.csv\"\nfixture = \"part\"\n{contacts}\n[estimate]\nparameters = [\"joint_offset\"]\n"
    );
    problem_file::read(&text, "problem.toml", Path::new(folder.path()))
        .map(|loaded| loaded.problem)
        .map_err(|error| error.to_string())
}

const JOINTS: &str = "q1,q2,q3,q4,q5,q6,q7";
const Q: &str = "0,0.1,0.2,-1.3,0.4,1.5,0.6";

#[test]
fn places_are_in_millimetres_or_metres() {
    let in_mm = read("", "", &format!("{JOINTS},x_mm,y_mm,z_mm\n{Q},100,-20,3\n")).unwrap();
    let in_m = read("", "", &format!("x_m,y_m,{JOINTS},z_m\n0.1,-0.02,{Q},0.003\n")).unwrap();
    let renamed = "columns = { x_mm = \"X\", y_mm = \"Y\", z_mm = \"Z\" }";
    let renamed = read("", renamed, &format!("X,Y,{JOINTS},Z\n100,-20,{Q},3\n")).unwrap();
    for problem in [in_mm, in_m, renamed] {
        let target = problem.contacts.target(0).expect("a target");
        assert!((target.translation.vector - Vector3::new(0.1, -0.02, 0.003)).norm() < 1e-15, "{target}");
        assert_eq!(target.rotation, nalgebra::UnitQuaternion::identity());
        assert!(problem.contacts.filtered(|_| true).target(0).is_some());
    }
}

#[test]
fn normals_are_z_of_targets() {
    let log = format!("{JOINTS},x_mm,y_mm,z_mm,nx,ny,nz\n{Q},100,-20,3,0,-2,0\n");
    let problem = read("along_normal = true", "", &log).unwrap();
    let target = problem.contacts.target(0).expect("a target");
    assert!((target.rotation * Vector3::z() + Vector3::y()).norm() < 1e-12, "{target}");
    let zero = log.replace("0,-2,0", "0,0,0");
    refused(read("along_normal = true", "", &zero), &["log.csv:2", "nx", "a normal that has a direction", "zeros"]);
}

#[test]
fn what_targets_lack_is_said() {
    let without = format!("{JOINTS}\n{Q}\n");
    refused(read("", "", &without), &["log.csv", "`x_mm` or `x_m`"]);
    refused(read("", "", &format!("{Q}\n")), &["log.csv", "with the columns of targets", "no header"]);
    let points = format!("{JOINTS},x_mm,y_mm,z_mm\n{Q},100,-20,3\n");
    refused(read("along_normal = true", "", &points), &["log.csv", "column `nx`"]);
    refused(read("", "", &points.replace("-20", "nan")), &["log.csv:2", "y_mm", "millimetres"]);
    refused(read("depth_mm = 3", "", &points), &["problem.toml", "what belongs to a target", "`depth_mm`"]);
    refused(
        read("", "held_out = true\n[[contacts]]\nfile = \"log.csv\"\nfixture = \"part\"", &points),
        &["held_out", "base_from_fixture"],
    );
    refused(read("", "columns = { x_cm = \"X\" }", &points), &["columns", "x_cm"]);
}
