//! Problem files: everything of the schema read, everything else refused with line and column.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use tempfile::TempDir;
use touchcal::estimate::{Loss, PlacePrior};
use touchcal::io::{Loaded, problem_file};
use touchcal::parameter::{Block, Prior};

const FULL: &str = r#"schema = 1
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
"#;

const BALL: &str = r#"
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

fn folder() -> TempDir {
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

fn read_in(folder: &Path, text: &str) -> Result<Loaded, String> {
    problem_file::read(text, "problem.toml", folder).map_err(|error| error.to_string())
}

fn read(text: &str) -> Result<Loaded, String> {
    read_in(folder().path(), text)
}

#[track_caller]
fn refused(from: &str, to: &str, parts: &[&str]) {
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
    let Loaded { problem, urdf, inputs } = problem_file::read_file(&path).unwrap();
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
    assert_eq!((hole.name.as_str(), hole.prior, hole.manifold.name()), ("hole", PlacePrior::Fixed, "peg in hole"));
    assert_eq!(table.manifold.name(), "tool on plane");
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
    assert_eq!(problem.loss, Loss::Huber(2.0));

    let count = |block| problem.parameters.iter().filter(|parameter| parameter.id.block() == block).count();
    assert_eq!([count(Block::Strain), count(Block::JointOffset), count(Block::JointOrigin)], [1, 6, 36]);
    let prior = |name: &str| problem.parameters.iter().find(|p| p.name == name).unwrap().prior_sigma();
    assert_eq!(prior("strain"), Some(0.01));
    assert_eq!(prior("joint_offset.joint_a1"), Some(5.0_f64.to_radians()));
    // What the file does not say keeps its default: 0.1° about other axes than the joint's own.
    assert_eq!(prior("joint_origin.joint_a2.x"), Some(0.002));
    assert_eq!(prior("joint_origin.joint_a2.rx"), Some(0.1_f64.to_radians()));
}

#[test]
fn defaults_are_filled_in() {
    let problem = read(BALL).unwrap().problem;
    assert_eq!((problem.tool.prior, problem.fixtures[1].prior), (PlacePrior::Flat, PlacePrior::Flat));
    assert_eq!(problem.fixtures[0].base_from_fixture, None);
    assert_eq!(problem.noise.encoder, problem_file::DEFAULT_ENCODER);
    assert_eq!(problem.noise.contact, problem_file::DEFAULT_CONTACT);
    assert_eq!((problem.loss, problem.parameters.len()), (Loss::GemanMcClure(3.0), 0));
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
    refused(
        "base = \"base_link\"",
        "gravity = [0, 0, nan]",
        &["problem.toml:4:11", "robot, gravity", "numbers within", "NaN"],
    );
    refused("base = \"base_link\"", "gravity = [0, -9.81]", &["problem.toml:4:11"]);
}

#[test]
fn unknown_keys_and_names_are_refused_with_a_suggestion() {
    refused("[[fixture]]", "[[fixtrue]]", &["problem.toml:14:", "unknown field `fixtrue`", "did you mean `fixture`?"]);
    refused("depth_mm", "dept_mm", &["problem.toml:19:1", "did you mean `depth_mm`?"]);
    refused(
        "kind = \"peg\"",
        "kind = \"pegg\"",
        &["problem.toml:7:8", "unknown variant `pegg`", "did you mean `peg`?"],
    );
    refused("loss = \"huber\"", "loss = \"hubr\"", &["did you mean `huber`?"]);
    refused(
        "fixture = \"hole\"",
        "fixture = \"hol\"",
        &["contacts, fixture", "`hole` or `table`", "did you mean `hole`?"],
    );
    refused(
        "between = [\"hole\", \"table\"]",
        "between = [\"hole\", \"tabel\"]",
        &["problem.toml:27:20", "did you mean `table`?"],
    );
    refused("\"strain\"", "\"starin\"", &["estimate, parameters", "did you mean `strain`?"]);
    refused("joint_origin.joint_a1", "joint_origin.joint_b1", &["estimate, freeze", "problem.toml:"]);
    refused(
        "builtin = \"iiwa14\"",
        "builtin = \"iiwa41\"",
        &["problem.toml:3:11, robot, builtin", "did you mean `iiwa14`?"],
    );
    refused("base = \"base_link\"", "base = \"base_lnk\"", &["did you mean `base_link`?"]);
    refused("base = \"base_link\"", "joints = [\"a\"]", &["robot, joints", "joint_a7"]);
    let method = "method = \"levenberg_marquardt\"";
    refused(method, "descent = { steps = 10 }", &["estimate, descent", "`method = \"gradient_descent\"`"]);
    let no_steps = "method = \"gradient_descent\"\ndescent = { steps = 0 }";
    refused(method, no_steps, &["estimate.descent, steps", "a whole number", "found 0"]);
    refused("levenberg_marquardt", "levenberg_marquard", &["did you mean `levenberg_marquardt`?"]);
    refused("unit = \"deg\"", "unit = \"degrees\"", &["unknown variant `degrees`", "`rad`"]);
    refused("q1 = \"axis1\"", "p1 = \"axis1\"", &["deg.csv, columns", "`p1`"]);
}

#[test]
fn malformed_text_is_refused() {
    refused("schema = 1", "schema = 2", &["problem.toml:1:10, schema", "schema 1", "found 2"]);
    refused("length_mm = 40", "length_mm = forty", &["problem.toml:10:"]);
    refused("length_mm = 40", "length_mm = \"40\"", &["problem.toml:10:13", "invalid type"]);
    refused("[[contacts]]", "[[contacts", &["problem.toml:31:"]);
    refused("xyz_mm = [600, 100, 150]", "xyz_mm = [600, 100]", &["problem.toml:17:", "invalid length 2"]);
    refused("[estimate]\n", "", &["problem.toml:", "unknown field", "`encoder_deg` or `contact_mm`"]);
    assert!(read("").unwrap_err().contains("missing field `robot`"));
    let deep = format!("a = {}", "[".repeat(100_000));
    assert!(read(&deep).unwrap_err().starts_with("problem.toml:1:"));
    let folder = folder();
    let path = folder.path().join("latin.toml");
    std::fs::write(&path, b"[robot]\nbuiltin = \"\xe9\"").unwrap();
    let message = problem_file::read_file(&path).unwrap_err().to_string();
    assert!(message.contains("latin.toml:2: expected UTF-8 text, found byte 0xe9"), "{message}");
    let message = problem_file::read_file(&folder.path().join("no.toml")).unwrap_err().to_string();
    assert!(message.contains("no.toml: could not open"), "{message}");
}

#[test]
fn numbers_out_of_range_are_refused() {
    refused("length_mm = 40", "length_mm = -1", &["problem.toml:10:13, tool, length_mm", "positive", "found -1"]);
    refused("depth_mm = 30", "depth_mm = 0", &["fixture `hole`, depth_mm", "found 0"]);
    refused("depth_mm = 30", "depth_mm = nan", &["found NaN"]);
    refused("sigma_mm = 0.1", "sigma_mm = inf", &["tool, sigma_mm", "found inf"]);
    refused("mm = 50", "mm = 1e9", &["distance, mm", "at most 1000000"]);
    refused(
        "quat_wxyz = [0, 0, 1, 0]",
        "quat_wxyz = [0, 0, 1.01, 0]",
        &["tool, tip_from_tool.quat_wxyz", "norm 1", "1.01"],
    );
    refused("quat_wxyz = [0, 0, 1, 0]", "quat_wxyz = [0, nan, 1, 0]", &["quat_wxyz", "NaN"]);
    refused(
        "quat_wxyz = [0, 0, 1, 0]",
        "quat_wxyz = [0, 0, 1, 0], rpy_deg = [0, 0, 0]",
        &["quat_wxyz or rpy_deg", "both"],
    );
    refused("xyz_mm = [600, 100, 150]", "xyz_mm = [600, inf, 150]", &["base_from_fixture.xyz_mm", "inf"]);
    refused("debounce = 1", "debounce = 0", &["contacts, debounce", "from 1"]);
    refused("release_n = 2", "release_n = 4", &["contacts, release_n", "at most force_threshold_n (3)"]);
    refused("force_threshold_n = 3.0\n", "", &["`force_threshold_n`", "without it"]);
    refused("strain = 0.01", "strain = 0", &["estimate.prior, strain"]);
    refused("encoder_deg = 0.002\ncontact_mm = 0.02", "encoder_deg = 0\ncontact_mm = 0", &["noise", "both 0"]);
    refused("loss = \"huber\"", "loss = \"squared\"", &["no scale"]);
}

#[test]
fn what_does_not_fit_together_is_refused() {
    refused("name = \"table\"", "name = \"hole\"", &["distinct names", "\"hole\" twice"]);
    refused("between = [\"hole\", \"table\"]", "between = [\"hole\", \"hole\"]", &["two fixtures"]);
    refused("\"strain\", ", "\"strain\", \"strain\", ", &["distinct blocks"]);
    refused(
        "base_from_fixture = { xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }\n",
        "",
        &["fixture `hole`", "`base_from_fixture`"],
    );
    refused("outline_offset_mm = 0.5\n", "", &["fixture `hole`", "neither"]);
    refused("outline_offset_mm = 0.5", "outline_offset_mm = 0.5\noutline = \"peg.csv\"", &["both"]);
    refused(
        "outline_offset_mm = 0.5",
        "outline = \"narrow.csv\"",
        &["fixture `hole`", "a hole that the peg fits into", "an overlap of 0.5 mm"],
    );
    refused(
        "outline_offset_mm = 0.5",
        "mesh = \"hole.stl\"",
        &["an outline of the hole, as the peg has", "a mesh of the hole alone"],
    );
    refused("outline = \"peg.csv\"", "mesh = \"peg.stl\"", &["what belongs to a peg's mesh", "`length_mm`"]);
    let no_length = "outline = \"peg.csv\"\nlength_mm = 40";
    refused(no_length, "mesh = \"peg.stl\"", &["tool, mesh", "\"peg.stl\", which does not exist"]);
    refused(no_length, "mesh = \"peg.csv\"", &["peg.csv", "a mesh as STL or OBJ, found a .csv file"]);
    refused("length_mm = 40", "length_mm = 40\nmesh_unit = \"mm\"", &["problem.toml:11:13", "`mesh_unit` without it"]);
    refused("outline = \"peg.csv\"\n", "", &["tool", "`outline` or `builtin` of the peg"]);
    refused("outline = \"peg.csv\"", "builtin = \"extrusion52\"", &["did you mean `extrusion25`?"]);
    refused("length_mm = 40\n", "", &["tool, length_mm", "the peg's length"]);
    refused("sigma_mm = 0.1", "free = true\nsigma_mm = 0.1", &["free = true or sigma_mm", "both"]);
    refused("kind = \"plane\"", "kind = \"socket\"", &["a hole or plane, which a peg can touch", "found a socket"]);
    refused("builtin = \"iiwa14\"", "builtin = \"iiwa14\"\nurdf = \"a.urdf\"", &["`urdf` or `builtin`", "both"]);
    refused(
        "builtin = \"iiwa14\"",
        "urdf = \"a.urdf\"",
        &["problem.toml:3:8, robot, urdf", "a.urdf", "does not exist"],
    );
    refused("file = \"log.csv\"", "file = \"no.csv\"", &["contacts, file", "\"no.csv\", which does not exist"]);
    refused("file = \"log.csv\"", "file = \"two.csv\"", &["two.csv:1", "`joint_a7`), or a header, found 2 columns"]);
    refused("outline = \"peg.csv\"", "outline = \"log.csv\"", &["log.csv:1", "x_mm,y_mm"]);
    refused("radius_mm = 10\n", "", &["tool, radius_mm", "which a plane needs"]);
    refused("radius_mm = 10", "radius_mm = 10\nlength_mm = 3", &["what belongs to a ball", "`length_mm`"]);
    refused(
        "kind = \"socket\"\nfree = true",
        "kind = \"hole\"\nfree = true",
        &["a socket or plane, which a ball can touch", "a hole"],
    );
    refused(
        "kind = \"socket\"\nfree = true",
        "kind = \"socket\"\nfree = true\ndepth_mm = 3",
        &["what belongs to a socket", "`depth_mm`"],
    );
    let known = BALL.replace("free = true\n", "").replace("\"fixture\"", "\"strain\"");
    assert!(read(&known).unwrap_err().contains("`base_from_fixture`, or `free = true`"));
}

const POSES: &str = "x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n0,0,-0.01,1,0,0,0\n0,0,-0.02,1,0,0,0\n";

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
fn other_kinds_of_files_are_refused() {
    let folder = folder();
    let convert = "rosbags-convert --src BAG --dst NEW --dst-storage mcap";
    for (name, content, parts) in [
        ("log.bag", &b"#ROSBAG V2.0\n"[..], ["a ROS 1 bag", convert]),
        ("log.db3", b"SQLite format 3\0rest", ["a ROS 2 bag in SQLite", convert]),
        ("log.mcap.zstd", b"\x28\xb5\x2f\xfdrest", ["packed by zstd", "unpack it first"]),
    ] {
        std::fs::write(folder.path().join(name), content).unwrap();
        let message = read_in(folder.path(), &FULL.replace("log.csv", name)).unwrap_err();
        assert!(message.contains(name) && parts.iter().all(|part| message.contains(part)), "{message}");
    }
    std::fs::write(folder.path().join("peg.stl"), "solid").unwrap();
    let message = read_in(folder.path(), &FULL.replace("peg.csv", "peg.stl")).unwrap_err();
    assert!(message.contains("a mesh, which the key `mesh` takes"), "{message}");
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

#[test]
fn bad_outlines_are_refused() {
    let cases = [
        ("0,0\n1,1\n", "at least 3 vertices, found 2"),
        ("x_mm,y_mm\n0,0\n1,x\n2,0", "peg.csv:3, column y_mm: expected a number of mm within ±10000, found \"x\""),
        ("0,0\n1,NaN\n2,0", "peg.csv:2, column y_mm"),
        ("0,0\n1,1,1\n2,0", "peg.csv:2: expected two numbers"),
        ("x,y\n0,0\n", "peg.csv:1: expected header `x_mm,y_mm`"),
        ("", "found 0"),
    ];
    for (text, part) in cases {
        let folder = folder();
        std::fs::write(folder.path().join("peg.csv"), text).unwrap();
        let message = read_in(folder.path(), FULL).unwrap_err();
        assert!(message.contains(part), "expected `{part}` in: {message}");
    }
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
