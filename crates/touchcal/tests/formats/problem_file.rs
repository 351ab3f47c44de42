//! Problem files: everything of the schema read, everything else refused with line and column.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use tempfile::TempDir;
use touchcal::estimate::{Loss, PlacePrior, ShapeTolerance, UnseenEffects};
use touchcal::io::{Loaded, problem_file};
use touchcal::parameter::{Block, Prior};

pub(super) const FULL: &str = r#"schema = 1
[robot]
builtin = "iiwa14"
base = "base_link"

[tool]
kind = "peg"
tip_from_tool = { xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }
outline = "peg.csv"
length_mm = 40
sigma_mm = 0.1
sigma_deg = 0.5

[[fixture]]
name = "hole"
kind = "hole"
base_from_fixture = { xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }
outline_offset_mm = 0.5
depth_mm = 30

[[fixture]]
name = "table"
kind = "plane"
base_from_fixture = { xyz_mm = [0, 0, 10] }

[[distance]]
between = ["hole", "table"]
mm = 50
sigma_mm = 0.1

[[contacts]]
file = "log.csv"
fixture = "hole"
force_threshold_n = 3.0
release_n = 2
debounce = 1

[[contacts]]
file = "deg.csv"
fixture = "table"
unit = "deg"
columns = { q1 = "axis1" }

[noise]
encoder_deg = 0.002
contact_mm = 0.02

[estimate]
parameters = ["strain", "joint_offset", "joint_origin"]
loss = "huber"
loss_scale = 2
freeze = ["joint_origin.joint_a1", "joint_offset.joint_a7"]
prior = { strain = 0.01, joint_offset_deg = 5.0, joint_origin_mm = 2 }
method = "levenberg_marquardt"
unseen_effects = "ignore"
"#;

pub(super) const BALL: &str = r#"
[robot]
builtin = "panda"
[tool]
kind = "ball"
radius_mm = 10
[[fixture]]
name = "front/0"
kind = "socket"
free = true
[[fixture]]
name = "table"
kind = "plane"
base_from_fixture = { xyz_mm = [0, 0, 0] }
[[contacts]]
file = "panda.csv"
fixture = "front/0"
[estimate]
parameters = ["tool", "fixture"]
"#;

pub(super) fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("peg.csv", "x_mm,y_mm\n-10,-10\n10,-10\n10,10\n-10,10\n");
    write(
        "log.csv",
        "t,q1,q2,q3,q4,q5,q6,q7,fx,fy,fz,tx,ty,tz\n0,0,0,0,1,0,0,0,9,0,0,0,0,0\n1,0,0,0,1,0,0,0,0,0,0,0,0,0\n",
    );
    write("deg.csv", "axis1,q2,q3,q4,q5,q6,q7\n90,0,0,45,0,0,0\n");
    write("panda.csv", "0,0,0,-1,0,1,0\n");
    write("two.csv", "0,0\n1,1\n2,0\n");
    write("narrow.csv", "x_mm,y_mm\n-10.5,-9.5\n10.5,-9.5\n10.5,9.5\n-10.5,9.5\n");
    folder
}

pub(super) fn read_in(folder: &Path, text: &str) -> Result<Loaded, String> {
    problem_file::read(text, "problem.toml", folder).map_err(|error| error.to_string())
}

pub(super) fn read(text: &str) -> Result<Loaded, String> {
    read_in(folder().path(), text)
}

#[track_caller]
pub(super) fn refused(from: &str, to: &str, parts: &[&str]) {
    let text = if FULL.contains(from) { FULL } else { BALL };
    assert!(text.contains(from), "{from}");
    let message = read(&text.replacen(from, to, 1)).expect_err(to);
    for part in parts {
        assert!(message.contains(part), "expected `{part}` in: {message}");
    }
}

#[test]
fn a_full_problem_is_read() {
    let folder = folder();
    let path = folder.path().join("problem.toml");
    std::fs::write(&path, FULL).unwrap();
    let Loaded { problem, urdf, inputs, .. } = problem_file::read_file(&path).unwrap();
    assert!(urdf.contains("joint_a1"));
    let files: Vec<&str> = inputs.iter().map(|input| input.path.rsplit('/').next().unwrap()).collect();
    assert_eq!(files, ["problem.toml", "builtin:iiwa14", "peg.csv", "log.csv", "deg.csv"]);
    assert!(inputs.iter().all(|input| input.sha256.len() == 64));
    assert_eq!((problem.robot.base(), problem.robot.tip()), ("base_link", "flange"));

    assert_eq!(problem.tool.tip_from_tool.translation.vector, Vector3::new(0.0, 0.0, 0.15));
    let half_turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI);
    assert!(problem.tool.tip_from_tool.rotation.angle_to(&half_turn) < 1e-7);
    assert_eq!(problem.tool.prior, PlacePrior::Gaussian { sigma: 1e-4, sigma_angle: 0.5_f64.to_radians() });

    let [hole, table] = problem.fixtures.as_slice() else { panic!() };
    assert_eq!((hole.name.as_str(), hole.manifold.name()), ("hole", "peg in hole"));
    assert_eq!((hole.prior, hole.tolerance), (PlacePrior::DEFAULT_FIXTURE, ShapeTolerance::DEFAULT));
    assert_eq!((table.manifold.name(), table.tolerance), ("tool on plane", ShapeTolerance::EXACT));
    let place = hole.base_from_fixture.unwrap();
    assert!((place.translation.vector - Vector3::new(0.6, 0.1, 0.15)).norm() < 1e-15);
    assert!((place.rotation.euler_angles().2.to_degrees() - 20.0).abs() < 1e-12);

    assert_eq!(problem.distances[0].between, (0, 1));
    assert!((problem.distances[0].distance - 0.05).abs() < 1e-15 && (problem.distances[0].sigma - 1e-4).abs() < 1e-15);
    assert_eq!((problem.contacts.len(), problem.contacts.rows_read()), (2, 3));
    assert_eq!((problem.contacts.fixture(0), problem.contacts.fixture(1)), (0, 1));
    assert_eq!(problem.contacts.q(1)[0], std::f64::consts::FRAC_PI_2);
    assert!((problem.noise.encoder - 0.002_f64.to_radians()).abs() < 1e-18);
    assert!((problem.noise.contact - 2e-5).abs() < 1e-18);
    assert_eq!((problem.loss, problem.options.unseen_effects), (Loss::Huber(2.0), UnseenEffects::Ignore));

    let count = |block| problem.parameters.iter().filter(|parameter| parameter.id.block() == block).count();
    assert_eq!([count(Block::Strain), count(Block::JointOffset), count(Block::JointOrigin)], [1, 6, 36]);
    let prior = |name: &str| problem.parameters.iter().find(|p| p.name == name).unwrap().prior_sigma();
    assert_eq!(prior("strain"), Some(0.01));
    assert_eq!(prior("joint_offset.joint_a1"), Some(5.0_f64.to_radians()));
    // What the file does not say keeps its default: 0.1° about other axes than the joint's own.
    assert_eq!(prior("joint_origin.joint_a2.x"), Some(0.002));
    assert_eq!(prior("joint_origin.joint_a2.rx"), Some(0.1_f64.to_radians()));
}

/// The full problem with other tables of logs.
fn with_contacts(tables: &str) -> String {
    let (before, rest) = FULL.split_once("[[contacts]]").unwrap();
    let (_, after) = rest.split_once("[noise]").unwrap();
    format!("{before}{tables}\n[noise]{after}")
}

/// `[log]` says how logs are read, and names none.
#[test]
fn a_problem_without_logs_says_where_they_belong() {
    for log in ["", "[log]\nunit = \"rad\"\n"] {
        let message = read(&with_contacts(log)).unwrap_err();
        let expected = "expected at least one [[contacts]] table, with the `file` of a log and its `fixture` ([log] says only how logs are read), found none";
        assert!(message.ends_with(expected), "{message}");
    }
}

/// Equal notes of several logs are one note.
#[test]
fn equal_notes_of_several_logs_are_merged() {
    let folder = folder();
    let log = std::fs::read_to_string(folder.path().join("log.csv")).unwrap();
    let notes = |files: &[&str]| {
        let tables = files.iter().map(|file| {
            std::fs::write(folder.path().join(file), &log).unwrap();
            format!("[[contacts]]\nfile = \"{file}\"\nfixture = \"hole\"\n")
        });
        let loaded = read_in(folder.path(), &with_contacts(&tables.collect::<String>())).unwrap();
        let notes = loaded.problem.contacts.notes().iter().filter(|note| note.contains("but no threshold"));
        notes.cloned().collect::<Vec<String>>()
    };
    let file = |name: &str| folder.path().join(name).display().to_string();
    let words = ": there are forces, but no threshold";
    assert!(notes(&["a.csv"])[0].starts_with(&format!("{}{words}", file("a.csv"))));
    assert!(notes(&["a.csv", "b.csv"])[0].starts_with(&format!("{} and another log{words}", file("a.csv"))));
    let merged = notes(&["a.csv", "b.csv", "c.csv"]);
    assert_eq!(merged.len(), 1, "{merged:?}");
    assert!(merged[0].starts_with(&format!("{} and 2 other logs{words}", file("a.csv"))), "{merged:?}");
}

#[test]
fn defaults_are_filled_in() {
    let problem = read(BALL).unwrap().problem;
    assert_eq!((problem.tool.prior, problem.fixtures[1].prior), (PlacePrior::Flat, PlacePrior::Flat));
    assert_eq!(problem.fixtures[0].base_from_fixture, None);
    assert_eq!(problem.noise.encoder, problem_file::DEFAULT_ENCODER);
    assert_eq!(problem.noise.contact, problem_file::DEFAULT_CONTACT);
    assert_eq!((problem.loss, problem.parameters.len()), (Loss::GemanMcClure(3.0), 0));
    assert!(problem.options.unseen_effects == UnseenEffects::Widen && problem.allows_for_unseen_effects());
    refused(
        "unseen_effects = \"ignore\"",
        "unseen_effects = \"wide\"",
        &["unknown variant `wide`", "`widen` or `ignore`"],
    );
}

/// A log may be of a built-in arm other than the one that is named.
#[test]
fn built_in_arms_are_known() {
    let problem = read(FULL).expect("a problem").problem;
    let names: Vec<&str> = problem.other_arms.iter().map(|arm| arm.name()).collect();
    assert_eq!(names, ["iiwa14", "panda"]);
}

#[test]
fn compliance_needs_gravity() {
    let bending = FULL.replacen("\"joint_origin\"]", "\"joint_origin\", \"joint_compliance\"]", 1);
    let hanging = bending.replacen("base = \"base_link\"", "base = \"base_link\"\ngravity = [0, 1.5, 9.7]", 1);
    let problem = read(&hanging).unwrap().problem;
    assert_eq!(*problem.robot.gravity(), Vector3::new(0.0, 1.5, 9.7));
    assert_eq!(*read(&bending).unwrap().problem.robot.gravity(), Vector3::new(0.0, 0.0, -9.81));
    let found: Vec<_> = problem.parameters.iter().filter(|p| p.id.block() == Block::JointCompliance).collect();
    assert_eq!((found.len(), found[0].name.as_str()), (7, "joint_compliance.joint_a1"));
    assert!(found.iter().all(|p| p.prior_sigma() == Some(1e-4)
        && matches!(p.prior, Prior::VarianceComponent { .. })
        && p.unit.symbol() == "rad/(N m)"));
    let known = bending.replacen("joint_origin_mm = 2", "joint_compliance_rad_per_nm = 2e-5", 1);
    let problem = read(&known).unwrap().problem;
    let fixed = problem.parameters.iter().find(|p| p.name == "joint_compliance.joint_a3").unwrap();
    assert_eq!(fixed.prior, Prior::Gaussian { sigma: 2e-5 });

    let orbit = hanging.replacen("[0, 1.5, 9.7]", "[0, 0, 0]", 1);
    let message = read(&orbit).unwrap_err();
    for part in
        ["problem.toml:50:", "estimate, parameters", "gravity or a load", "\"joint_compliance\" with `gravity` of 0"]
    {
        assert!(message.contains(part), "expected `{part}` in: {message}");
    }
    assert!(read(&orbit.replacen(", \"joint_compliance\"", "", 1)).is_ok());
    let loaded = "debounce = 1\nload_on = \"fixture\"\nload_frame = \"base\"";
    let problem = read(&orbit.replacen("debounce = 1", loaded, 1)).unwrap().problem;
    assert!(problem.contacts.has_loads());
    refused(
        "debounce = 1",
        "debounce = 1\nload_frame = \"base\"",
        &["problem.toml:", "contacts, load_frame", "`load_on`"],
    );
    refused("debounce = 1", "debounce = 1\nload_on = \"tip\"", &["problem.toml:", "tool", "fixture"]);
    let lagging = format!("{loaded}\nload_lag_rows = 1.5");
    assert!(read(&orbit.replacen("debounce = 1", &lagging, 1)).is_ok());
    refused(
        "debounce = 1",
        "debounce = 1\nload_lag_rows = 1",
        &["problem.toml:", "contacts, load_lag_rows", "`load_on`"],
    );
    refused(
        "debounce = 1",
        "debounce = 1\nload_on = \"tool\"\nload_lag_rows = -1",
        &["problem.toml:", "contacts, load_lag_rows", "at least 0"],
    );
    refused(
        "base = \"base_link\"",
        "gravity = [0, 0, nan]",
        &["problem.toml:4:11", "robot, gravity", "numbers within", "NaN"],
    );
    refused("base = \"base_link\"", "gravity = [0, -9.81]", &["problem.toml:4:11"]);
}

pub(super) const POSES: &str = "x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n0,0,-0.01,1,0,0,0\n0,0,-0.02,1,0,0,0\n";

#[test]
fn a_hole_may_be_known_by_samples() {
    let folder = folder();
    std::fs::write(folder.path().join("poses.csv"), POSES).unwrap();
    std::fs::write(folder.path().join("one.csv"), "x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n").unwrap();
    std::fs::write(folder.path().join("m.safetensors"), POSES).unwrap();
    let with = |lines: &str| read_in(folder.path(), &FULL.replace("depth_mm = 30", &format!("depth_mm = 30\n{lines}")));
    let named = |lines: &str| with(lines).unwrap().problem.fixtures[0].manifold.name();
    assert_eq!(named("manifold = \"exact\""), "peg in hole");
    assert_eq!(named("manifold = \"nearest\"\nsamples = \"poses.csv\""), "nearest sample");
    assert_eq!(
        named("manifold = \"nearest\"\nsamples = \"poses.csv\"\nneighbours = 2\nmm_per_deg = 2"),
        "nearest samples"
    );
    let loaded = with("manifold = \"nearest\"\nsamples = \"poses.csv\"").unwrap();
    assert!(loaded.inputs.iter().any(|input| input.path.ends_with("poses.csv")));
    // Neither outline nor depth matters to samples.
    let bare = FULL.replace("outline = \"peg.csv\"\n", "").replace("outline_offset_mm = 0.5\n", "");
    let bare = bare[..bare.find("[[fixture]]\nname = \"table\"").unwrap()].to_owned()
        + "[[contacts]]\nfile = \"log.csv\"\nfixture = \"hole\"\n[estimate]\nparameters = [\"strain\"]\n";
    let nearest = bare.replace("depth_mm = 30", "manifold = \"nearest\"\nsamples = \"poses.csv\"");
    assert!(read_in(folder.path(), &nearest).is_ok());
    let message = read_in(folder.path(), &bare).unwrap_err();
    assert!(message.contains("`outline` or `builtin` of the peg, found none"), "{message}");

    for (lines, parts) in [
        ("manifold = \"nearst\"", &["problem.toml:20:", "did you mean `nearest`?"][..]),
        ("manifold = \"nearest\"", &["fixture `hole`", "`samples`", "found none"]),
        ("manifold = \"nearest\"\nsample = \"poses.csv\"", &["did you mean `samples`?"]),
        (
            "manifold = \"nearest\"\nsamples = \"pose.csv\"",
            &["problem.toml:21:11", "\"pose.csv\", which does not exist"],
        ),
        ("manifold = \"nearest\"\nsamples = \"peg.csv\"", &["peg.csv:1", "x,y,z,qw,qx,qy,qz"]),
        ("manifold = \"nearest\"\nsamples = \"one.csv\"", &["one.csv", "at least two different poses, found 1 in 1"]),
        ("manifold = \"nearest\"\nsamples = \"m.safetensors\"", &["m.safetensors", "a whole safetensors file"]),
        (
            "manifold = \"nearest\"\nsamples = \"poses.csv\"\nneighbours = 0",
            &["neighbours", "a whole number from 1 to 1000"],
        ),
        ("manifold = \"nearest\"\nsamples = \"poses.csv\"\nneighbours = 1.5", &["found 1.5"]),
        ("manifold = \"nearest\"\nsamples = \"poses.csv\"\nmm_per_deg = 0", &["mm_per_deg", "a positive number"]),
        ("samples = \"poses.csv\"", &["`manifold = \"nearest\"`", "`samples` without it"]),
        ("manifold = \"learned\"", &["fixture `hole`", "`weights`", "found none"]),
        ("manifold = \"learned\"\nweights = \"m.safetensors\"", &["m.safetensors", "a whole safetensors file"]),
        (
            "manifold = \"learned\"\nweights = \"w\"\nmm_per_deg = 2",
            &["`manifold = \"nearest\"`", "`mm_per_deg` without it"],
        ),
        ("weights = \"w.safetensors\"", &["problem.toml:20:11", "`manifold = \"learned\"`", "`weights` without it"]),
        ("manifold = \"exact\"\nneighbours = 3", &["problem.toml:21:14", "`neighbours` without it"]),
    ] {
        let message = with(lines).unwrap_err();
        assert!(parts.iter().all(|part| message.contains(part)), "expected {parts:?} in: {message}");
    }
    let plane = FULL.replace("kind = \"plane\"", "kind = \"plane\"\nmanifold = \"exact\"");
    assert!(read_in(folder.path(), &plane).unwrap_err().contains("what belongs to a plane, found `manifold`"));
}

#[test]
fn a_drawing_is_the_outline_that_its_vertices_are() {
    let folder = folder();
    let svg = "<svg viewBox='0 0 9 9'><polygon id='peg' points='-10,10 10,10 10,-10 -10,-10'/><circle r='9'/></svg>";
    std::fs::write(folder.path().join("peg.csv"), "-10,-10\n10,-10\n10,10\n-10,10\n").unwrap();
    std::fs::write(folder.path().join("peg.svg"), svg).unwrap();
    let drawn = "outline = \"peg.svg\"\noutline_name = \"peg\"\noutline_unit = \"mm\"";
    let sketch = |text: &str| read_in(folder.path(), text).unwrap().problem.fixtures[0].manifold.sketch();
    assert_eq!(sketch(&FULL.replace("outline = \"peg.csv\"", drawn)), sketch(FULL));
    let alone = FULL.replace("outline = \"peg.csv\"", "builtin = \"extrusion25\"\noutline_name = \"peg\"");
    let message = read_in(folder.path(), &alone).unwrap_err();
    assert!(message.contains("problem.toml:10:16, tool: expected `outline`"), "{message}");
}

proptest! {
    #[test]
    fn any_text_is_answered(text in "\\PC{0,200}") {
        let _ = problem_file::read(&text, "x", Path::new("/nonexistent"));
    }

    #[test]
    fn mutated_problems_are_answered(at in 0..FULL.len(), cut in 0..30usize, with in "[\\[\\]={}\"', a-z0-9.\\-\\n_]{0,6}") {
        let mut text = FULL.to_owned();
        text.replace_range(at..(at + cut).min(FULL.len()), &with);
        let _ = problem_file::read(&text, "x", Path::new("/nonexistent"));
        let _ = read(&text);
    }
}
