//! Folders of the MUKCa layout.

use std::path::Path;

use tempfile::TempDir;
use touchcal::estimate::PlacePrior;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::urdf::{self, Ends};
use touchcal::io::{IoError, Loaded};

const ROW: &str = "0,0,0,-1,0,1,0\n";

fn folder(files: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files {
        let path = folder.path().join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, ROW).unwrap();
    }
    folder
}

fn read(folder: &Path, options: &MukcaOptions) -> Result<Loaded, IoError> {
    mukca::read(folder, urdf::read_builtin("panda", Ends::default()).unwrap(), options)
}

fn names(loaded: &Loaded) -> Vec<&str> {
    loaded.problem.fixtures.iter().map(|fixture| fixture.name.as_str()).collect()
}

#[track_caller]
fn refused(result: Result<Loaded, IoError>, parts: &[&str]) {
    let message = result.unwrap_err().to_string();
    for part in parts {
        assert!(message.contains(part), "expected `{part}` in: {message}");
    }
}

const FILES: [&str; 8] = [
    "right/hole_1.csv",
    "right/hole_0.csv",
    "left/hole_10.csv",
    "left/hole_2.csv",
    "left/hole_9.csv",
    "left/hole_02.csv",
    "notes/readme.csv",
    "stray.csv",
];

#[test]
fn placements_and_holes_are_sorted_and_joined() {
    let folder = folder(&FILES);
    let loaded = read(folder.path(), &MukcaOptions::default()).unwrap();
    assert_eq!(names(&loaded), ["left/2", "left/9", "left/10", "right/0", "right/1"]);
    let between: Vec<_> = loaded.problem.distances.iter().map(|distance| distance.between).collect();
    assert_eq!(between, [(1, 2), (3, 4)]);
    assert_eq!(loaded.problem.distances[0].distance, 0.05);
    assert_eq!(loaded.problem.tool.prior, PlacePrior::Gaussian { sigma: 2e-3, sigma_angle: 0.0 });
    assert!(loaded.problem.joint_drift && loaded.problem.noise.is_estimated);
    assert_eq!(loaded.problem.fixtures[3].placement, "right");
    assert!(loaded.problem.fixtures.iter().all(|f| f.prior == PlacePrior::Flat && f.base_from_fixture.is_none()));
    assert_eq!((loaded.problem.parameters.len(), loaded.problem.contacts.len(), loaded.inputs.len()), (42, 5, 6));
    assert_eq!(mukca::placement_names(folder.path()).unwrap(), ["left", "right"]);
}

#[test]
fn placements_can_be_chosen() {
    let folder = folder(&FILES);
    let only = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let options = MukcaOptions { only: only(&["right"]), ..MukcaOptions::default() };
    assert_eq!(names(&read(folder.path(), &options).unwrap()), ["right/0", "right/1"]);
    let options = MukcaOptions { except: only(&["right"]), ..MukcaOptions::default() };
    assert_eq!(names(&read(folder.path(), &options).unwrap()).len(), 3);
    let options = MukcaOptions { only: only(&["rigth"]), ..MukcaOptions::default() };
    refused(read(folder.path(), &options), &["a placement (`left` or `right`)", "did you mean `right`?"]);
    let options = MukcaOptions { except: only(&["left", "right"]), ..MukcaOptions::default() };
    refused(read(folder.path(), &options), &["at least one placement"]);
}

#[test]
fn what_is_no_such_folder_is_refused() {
    let empty = folder(&["notes/readme.csv"]);
    refused(read(empty.path(), &MukcaOptions::default()), &["subfolders with files hole_0.csv"]);
    refused(read(Path::new("/nonexistent"), &MukcaOptions::default()), &["/nonexistent: could not list the folder"]);
    let folder = folder(&FILES);
    std::fs::write(folder.path().join("left/hole_9.csv"), "0,0,0\n").unwrap();
    refused(
        read(folder.path(), &MukcaOptions::default()),
        &["left/hole_9.csv:1", "7 columns", "panda_joint1", "found 3"],
    );
    let options = MukcaOptions { spacing: f64::NAN, ..MukcaOptions::default() };
    refused(read(folder.path(), &options), &["spacing", "a positive length", "NaN"]);
}
