//! `touchcal new`: what it writes is a problem that works once the robot and the logs are there,
//! and nothing is overwritten.

use std::path::Path;

use super::{json, stderr, stdout, touchcal};

const PLANES: &str = "contacts = 100
[errors]
joint_offset_deg = 0.3
[tool]
kind = \"ball\"
radius_mm = 10
tip_from_tool = { xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }
sigma_mm = 0.5
[[fixture]]
name = \"table\"
kind = \"plane\"
base_from_fixture = { xyz_mm = [500, 0, 100] }
sigma_mm = 1
postures_deg = [[0, 40, 0, -90, 0, 50, 0]]
[[fixture]]
name = \"back\"
kind = \"plane\"
base_from_fixture = { xyz_mm = [750, 0, 300], rpy_deg = [0, -90, 0] }
sigma_mm = 1
postures_deg = [[0, 60, 0, -90, 0, -60, 0]]
[[fixture]]
name = \"side\"
kind = \"plane\"
base_from_fixture = { xyz_mm = [500, 350, 300], rpy_deg = [90, 0, 0] }
sigma_mm = 1
postures_deg = [[0, 40, 0, -90, 90, 90, 0]]
[exploration]
radius_mm = 40
tilt_deg = 25
press_mm = 5
swing_deg = 15
";

/// A new problem with logs of a simulated arm whose nominal URDF is the built-in one's.
pub(super) fn filled_in(kind: &str, simulation: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("planes.toml"), PLANES).unwrap();
    touchcal(folder.path(), &["new", kind]).success();
    touchcal(folder.path(), &[&["simulate", "--out", "sim"], simulation].concat()).success();
    let (_, urdf) = touchcal::robot::builtin::ALL.iter().find(|(name, _)| *name == "iiwa14").unwrap();
    std::fs::write(folder.path().join(kind).join("robot.urdf"), urdf).unwrap();
    for file in std::fs::read_dir(folder.path().join("sim")).unwrap() {
        let file = file.unwrap();
        if file.path().extension().is_some_and(|extension| extension == "csv") {
            std::fs::copy(file.path(), folder.path().join(kind).join(file.file_name())).unwrap();
        }
    }
    folder
}

/// Reads it, untouched, and calibrates to the truth of the simulation.
#[track_caller]
fn works(kind: &str, simulation: &[&str], contacts: u64) {
    let folder = filled_in(kind, simulation);
    let problem = format!("{kind}/problem.toml");
    let inspected: serde_json::Value =
        serde_json::from_str(&stdout(&touchcal(folder.path(), &["inspect", &problem, "--json"]).success())).unwrap();
    assert_eq!(inspected["contacts"], contacts);
    touchcal(folder.path(), &["calibrate", &problem, "--out", "out"]).success();
    let truth = json(&folder.path().join("sim/truth.json"));
    let estimate = json(&folder.path().join("out/estimate.json"));
    let mut compared = 0;
    for parameter in estimate["parameters"].as_array().unwrap() {
        let name = parameter["name"].as_str().unwrap();
        let arm = name.starts_with("joint_");
        if let (true, Some(truth), Some(sigma)) = (arm, truth["parameters"][name].as_f64(), parameter["sigma"].as_f64())
        {
            let error = parameter["value"].as_f64().unwrap() - truth;
            assert!(error.abs() < 5.0 * sigma, "{name}: {error} ± {sigma}");
            compared += 1;
        }
    }
    assert!(compared >= 6, "{compared}");
}

#[test]
fn a_new_peg_in_hole_works() {
    works("peg-in-hole", &["--preset", "workcell", "--contacts", "600"], 600);
}

#[test]
fn new_sockets_work() {
    // Of 180 contacts, at 12 the tool has jammed where it was: the template takes them once.
    works("sockets", &["--preset", "mukca"], 168);
}

/// A ball that the URDF does not have is told where it was found, in words for a problem file.
#[test]
fn the_place_of_the_tool_can_be_copied_from_the_warning() {
    let folder = filled_in("sockets", &["--preset", "mukca"]);
    let at = |name: &str| folder.path().join(name);
    let said = stdout(&touchcal(folder.path(), &["calibrate", "sockets/problem.toml", "--out", "out"]).success());
    let place = said.split("-> it is ").nth(1).unwrap().lines().next().unwrap();
    let problem = std::fs::read_to_string(at("sockets/problem.toml")).unwrap();
    let declared = problem.replace("tip_from_tool = { xyz_mm = [0, 0, 150] }", place);
    assert_ne!(declared, problem);
    std::fs::write(at("sockets/there.toml"), declared).unwrap();
    let rms = |args: &[&str]| {
        let args = [&["evaluate", "--urdf", "out/calibrated.urdf", "--json"], args].concat();
        let scored: serde_json::Value =
            serde_json::from_str(&stdout(&touchcal(folder.path(), &args).success())).unwrap();
        scored["rms_mm"].as_f64().unwrap()
    };
    let told = rms(&["sockets/there.toml"]);
    let found = rms(&["sockets/problem.toml", "--estimate", "out/estimate.json"]);
    assert!((told - found).abs() < 2e-4, "{told} {found}: rounded to 0.0001 mm");
    assert!(rms(&["sockets/problem.toml"]) > found + 0.01);
}

#[test]
fn new_planes_work() {
    works("planes", &["planes.toml"], 300);
}

#[test]
fn before_the_robot_is_there_the_first_gap_is_named() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["new", "sockets", "--out", "mine"]).success();
    let done = touchcal(folder.path(), &["inspect", "mine/problem.toml"]).code(1);
    assert!(
        stderr(&done).contains("robot, urdf: expected a file, found \"robot.urdf\", which does not exist"),
        "{}",
        stderr(&done)
    );
}

#[test]
fn nothing_is_overwritten() {
    for taken in ["problem.toml", "README.md"] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(taken), "mine").unwrap();
        let done = touchcal(folder.path(), &["new", "planes", "--out", "."]).code(1);
        assert!(stderr(&done).contains(&format!("{taken} exists already")), "{}", stderr(&done));
        assert_eq!(std::fs::read_to_string(folder.path().join(taken)).unwrap(), "mine");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

/// A second `new` names the problem file that exists; a folder in place of a problem file names the
/// problem file in it.
#[test]
fn the_problem_is_what_is_named() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["new", "sockets"]).success();
    let again = stderr(&touchcal(folder.path(), &["new", "sockets"]).code(1));
    assert!(again.contains("sockets/problem.toml exists already"), "{again}");
    let folded = stderr(&touchcal(folder.path(), &["inspect", "sockets"]).code(1));
    let expected =
        "touchcal: error: sockets: expected a problem file, found a folder; did you mean `sockets/problem.toml`?\n";
    assert_eq!(folded, expected);
}

/// How logs are read stands in one place, which holds for all of them.
#[test]
fn what_holds_for_all_logs_is_written_once() {
    for kind in ["sockets", "peg-in-hole", "planes"] {
        let folder = tempfile::tempdir().unwrap();
        touchcal(folder.path(), &["new", kind]).success();
        let text = std::fs::read_to_string(folder.path().join(kind).join("problem.toml")).unwrap();
        // As a line, or one to be filled in.
        let count = |key: &str| text.lines().filter(|line| line.trim_start_matches("# ").starts_with(key)).count();
        for key in ["[log]", "unit = ", "columns = ", "force_threshold_n = "] {
            assert_eq!(count(key), 1, "{kind}: {key}");
        }
        assert!(count("apart_deg = ") <= 1, "{kind}");
    }
}

/// The logs of a simulation, whose names are not those of a folder for each placement, with a name
/// for each and by their own names.
#[test]
fn logs_of_any_names_make_a_problem() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["simulate", "--preset", "mukca", "--out", "sim"]).success();
    let (_, urdf) = touchcal::robot::builtin::ALL.iter().find(|(name, _)| *name == "iiwa14").unwrap();
    std::fs::write(folder.path().join("arm.urdf"), urdf).unwrap();
    let new = |from: &[&str], out: &str| {
        let args = [&["new", "sockets", "--urdf", "arm.urdf", "--out", out], from].concat();
        stdout(&touchcal(folder.path(), &args).success())
    };
    let fixtures = |out: &str| {
        let done = touchcal(folder.path(), &["inspect", &format!("{out}/problem.toml"), "--json"]);
        let inspected: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
        inspected["contacts_per_fixture"].as_object().unwrap().keys().cloned().collect::<Vec<_>>()
    };
    let said = new(&["--from", "sim"], "own");
    assert!(said.contains("50 mm of neighbours, by their numbers: front/0 – front/1, left/0 – left/1"), "{said}");
    assert_eq!(fixtures("own"), ["front/0", "front/1", "left/0", "left/1", "right/0", "right/1"]);
    let said = new(&["--from", "a=sim/front_0.csv", "--from", "b=sim/left_1.csv"], "named");
    assert!(said.contains("none, because no two logs are of sockets N and N + 1"), "{said}");
    assert_eq!(fixtures("named"), ["a", "b"]);
    let tool = |out: &str| {
        let text = std::fs::read_to_string(folder.path().join(out).join("problem.toml")).unwrap();
        text.lines().find(|line| line.starts_with("tip_from_tool = ")).unwrap().to_owned()
    };
    new(&["--from", "sim", "--ball-mm", "1.5", "-2", "120"], "flange");
    assert!(tool("flange").starts_with("tip_from_tool = { xyz_mm = [1.5, -2, 120] }"), "{}", tool("flange"));
    assert!(tool("own").starts_with("tip_from_tool = { xyz_mm = [0, 0, 0] }"), "{}", tool("own"));
    let args = ["new", "sockets", "--urdf", "arm.urdf", "--from", "arm.urdf", "--out", "none"];
    let refused = stderr(&touchcal(folder.path(), &args).code(1));
    assert!(refused.contains("logs/front_0.csv") && refused.contains("front/0=logs/a.csv"), "{refused}");
}

#[test]
fn an_unknown_kind_gets_a_suggestion() {
    let folder = tempfile::tempdir().unwrap();
    let done = touchcal(folder.path(), &["new", "socket"]).code(2);
    assert!(stderr(&done).contains("a similar value exists: 'sockets'"), "{}", stderr(&done));
    assert!(!Path::new("socket").exists());
}

/// A text among the logs is not read as one in silence, nor is a log left out in silence.
#[test]
fn texts_and_files_that_are_left_out_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let (_, urdf) = touchcal::robot::builtin::ALL.iter().find(|(name, _)| *name == "iiwa14").unwrap();
    std::fs::write(folder.path().join("arm.urdf"), urdf).unwrap();
    let write = |names: &[&str]| {
        for name in names {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "0,0,0,-1,0,1,0\n").unwrap();
        }
    };
    write(&["any/front_0.csv", "any/front_1.csv", "any/notes.txt", "any/README.md"]);
    write(&["holes/front/hole_0.csv", "holes/front/hole_1.csv", "holes/front/spare.txt", "holes/left.csv"]);
    let notes = |from: &str| {
        let args = ["new", "sockets", "--from", from, "--urdf", "arm.urdf", "--out"];
        stderr(&touchcal(folder.path(), &[&args[..], &[&format!("{from}_problem")]].concat()).success())
    };
    let said = notes("any");
    let note = "note: any/notes.txt: taken as the log of socket `notes`; if it is no log, move it elsewhere\n";
    assert!(said.ends_with(note) && said.matches("note: ").count() == 1, "{said}");
    let said = notes("holes");
    for file in ["holes/front/spare.txt", "holes/left.csv"] {
        let note =
            format!("note: {file}: not taken, since other logs are PLACEMENT/hole_N.csv; with its name: SOCKET=FILE\n");
        assert!(said.contains(&note), "{said}");
    }
    assert_eq!(said.matches("note: ").count(), 2, "{said}");
}
