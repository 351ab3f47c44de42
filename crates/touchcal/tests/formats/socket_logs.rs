//! Logs of a ball in sockets by their names.

use std::path::{Path, PathBuf};

use tempfile::TempDir;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::socket_logs::{self, SocketLog};

fn folder(files: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files {
        let path = folder.path().join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, "0,0,0,-1,0,1,0\n").unwrap();
    }
    folder
}

/// Names of the sockets of these files in a folder.
#[track_caller]
fn sockets(files: &[&str]) -> Vec<String> {
    let folder = folder(files);
    socket_logs::find(&[folder.path().to_owned()]).unwrap().into_iter().map(|log| log.socket).collect()
}

fn named(folder: &Path, names: &[&str]) -> Result<Vec<SocketLog>, String> {
    let in_folder = |name: &&str| match name.split_once('=') {
        Some((socket, file)) => PathBuf::from(format!("{socket}={}", folder.join(file).display())),
        None => folder.join(name),
    };
    let names: Vec<PathBuf> = names.iter().map(in_folder).collect();
    socket_logs::find(&names).map_err(|error| error.to_string())
}

#[test]
fn each_naming_is_understood() {
    assert_eq!(sockets(&["b/hole_1.csv", "b/hole_0.csv", "a/hole_10.csv", "stray.csv"]), ["a/10", "b/0", "b/1"]);
    assert_eq!(
        sockets(&["front_1.csv", "front_0.csv.gz", "left-2.parquet", "back3.mcap"]),
        ["back/3", "front/0", "front/1", "left/2"]
    );
    assert_eq!(
        sockets(&["front/0.csv", "front/socket_01.txt", "left/upper.log"]),
        ["front/0", "front/1", "left/upper"]
    );
    assert_eq!(sockets(&["block_a.csv", "block_b.csv", "README.md", "robot.urdf"]), ["block_a", "block_b"]);
    assert_eq!(sockets(&["1.csv", "2.csv"]), ["1", "2"]);
    // The folder of a bag is one log.
    assert_eq!(sockets(&["front_0/metadata.yaml", "front_0/front_0_0.mcap"]), ["front/0"]);
}

#[test]
fn a_log_can_be_named_with_its_socket() {
    let folder = folder(&["a.csv", "b.dat", "front_2.csv"]);
    let logs = named(folder.path(), &["front/1=b.dat", "front/0=a.csv", "front_2.csv"]).unwrap();
    let names: Vec<&str> = logs.iter().map(|log| log.socket.as_str()).collect();
    assert_eq!(names, ["front/0", "front/1", "front/2"]);
    assert_eq!(logs[1].path, folder.path().join("b.dat"));
    let pairs: Vec<_> = mukca::neighbours(&logs).map(|pair| pair.map(|log| log.socket.as_str())).collect();
    assert_eq!(pairs, [["front/0", "front/1"], ["front/1", "front/2"]]);
}

#[test]
fn what_is_no_log_gets_the_namings() {
    let folder = folder(&["README.md", "a.csv", "front_1.csv", "front/1.csv"]);
    let refused = |names: &[&str]| named(folder.path(), names).unwrap_err();
    let namings = "logs/front_0.csv or logs/front/0.csv of socket 0 at placement `front`";
    for names in [["README.md"], ["missing"], ["=a.csv"], ["a//b=a.csv"]] {
        let message = refused(&names);
        assert!(message.contains(namings) && message.contains("front/0=logs/a.csv"), "{names:?}: {message}");
    }
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    assert!(refused(&["empty"]).contains(namings));
    assert!(refused(&["front/0=b.csv"]).contains("which does not exist"));
    let twice = refused(&[""]);
    assert!(twice.contains("one log of each socket") && twice.contains("front_1.csv"), "{twice}");
}

/// The problem of logs that are named otherwise is that of the same logs in the layout of MUKCa.
#[test]
fn the_problem_is_that_of_the_sockets() {
    let text = |files: &[&str]| {
        let folder = folder(files);
        std::fs::write(folder.path().join("arm.urdf"), "").unwrap();
        let logs = socket_logs::find(&[folder.path().to_owned()]).unwrap();
        let urdf = folder.path().join("arm.urdf");
        let text = mukca::problem_text(folder.path(), &logs, (&urdf, None), &MukcaOptions::default()).unwrap();
        let is_path = |line: &&str| line.starts_with("file = ");
        text.lines().filter(|line| !is_path(line)).map(str::to_owned).collect::<Vec<_>>()
    };
    let (flat, layout) = (text(&["front_0.csv", "front_1.csv"]), text(&["front/hole_0.csv", "front/hole_1.csv"]));
    assert_eq!(flat, layout);
    assert!(flat.iter().any(|line| line == "between = [\"front/0\", \"front/1\"]"), "{flat:?}");
}
