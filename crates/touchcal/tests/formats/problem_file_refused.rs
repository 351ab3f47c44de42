//! Problem files that are refused, with the place and what was expected.

use touchcal::io::problem_file;

use super::problem_file::*;

#[test]
fn unknown_keys_and_names_are_refused_with_a_suggestion() {
    refused("[[fixture]]", "[[fixtrue]]", &["problem.toml:14:", "unknown field `fixtrue`", "did you mean `fixture`?"]);
    refused("depth_mm", "dept_mm", &["problem.toml:19:1: unknown field", "did you mean `depth_mm`?"]);
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
    let single = problem_file::read("[fixture]\nname = \"a\"\n", "problem.toml", std::path::Path::new(""));
    let message = single.unwrap_err().to_string();
    assert!(
        message.contains("problem.toml:1:1: expected a list in brackets (of tables: [[name]]), found a table"),
        "{message}"
    );
    refused(
        "length_mm = 40",
        "length_mm = \"40\"",
        &["problem.toml:10:13", "expected a number, found the text \"40\""],
    );
    refused("[[contacts]]", "[[contacts", &["problem.toml:31:"]);
    let held_out = read(&FULL.replace("[[contacts]]", "[[contacts]]\nheld_out = true")).unwrap_err();
    assert!(held_out.contains("[[contacts]] table, found `held_out` in all of them"), "{held_out}");
    refused(
        "xyz_mm = [600, 100, 150]",
        "xyz_mm = [600, 100]",
        &["problem.toml:17:", "expected a list of length 3, found length 2"],
    );
    refused("[estimate]\n", "", &["problem.toml:", "unknown field", "`encoder_walk_deg`, `estimated`"]);
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
    refused(
        "depth_mm = 30",
        "depth_mm = 0.03",
        &["fixture `hole`", "for a hole 0.030 mm deep: which of these is in another unit?"],
    );
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
    refused("loss_scale = 2", "loss_scale = 0.01", &["estimate, loss_scale", "at least 0.1", "found 0.01"]);
}

#[test]
fn edges_that_parts_cannot_have_are_refused() {
    refused("radius_mm = 10", "radius_mm = 10\nedge_radius_mm = 0.1", &["what belongs to a ball", "`edge_radius_mm`"]);
    refused("length_mm = 40", "length_mm = 40\nedge_radius_mm = 11", &["tool, edge_radius_mm", "long enough", "11 mm"]);
    let sigma = &["fixture `table`", "what belongs to a plane", "`edge_radius_sigma_mm`"];
    refused("xyz_mm = [0, 0, 10] }", "xyz_mm = [0, 0, 10] }\nedge_radius_sigma_mm = 0.1", sigma);
    let both = "depth_mm = 30\nexact = true\nedge_radius_sigma_mm = 0.1";
    refused("depth_mm = 30", both, &["hole`, edge_radius_sigma_mm", "both"]);
    let unknown = "depth_mm = 30\nmanifold = \"unknown\"\nedge_radius_sigma_mm = 0.1";
    refused("outline_offset_mm = 0.5\ndepth_mm = 30", unknown, &["edge_radius_sigma_mm"]);
    refused("depth_mm = 30", "depth_mm = 30\nedge_radius_mm = -1", &["hole`, edge_radius_mm", "-1"]);
    refused("depth_mm = 30", "depth_mm = 30\nedge_radius_mm = 31", &["hole`, edge_radius_mm", "long enough", "31 mm"]);
    let mesh = "mesh = \"peg.stl\"\nedge_radius_mm = 0.1";
    refused("outline = \"peg.csv\"\nlength_mm = 40", mesh, &["what belongs to a peg's mesh", "`edge_radius_mm`"]);
    let plane = "xyz_mm = [0, 0, 10] }\nedge_radius_mm = 0.1";
    refused("xyz_mm = [0, 0, 10] }", plane, &["fixture `table`", "what belongs to a plane", "`edge_radius_mm`"]);
    // The plane alone: the peg's outline has no room, whatever the hole.
    let alone = FULL.replacen("length_mm = 40", "length_mm = 40\nedge_radius_mm = 11", 1);
    let (before, rest) = alone.split_once("[[fixture]]\nname = \"hole\"").unwrap();
    let (_, rest) = rest.split_once("[[fixture]]").unwrap();
    let (fixture, rest) = rest.split_once("[[distance]]").unwrap();
    let (_, rest) = rest.split_once("fixture = \"table\"").unwrap();
    let text = format!("{before}[[fixture]]{fixture}[[contacts]]\nfile = \"deg.csv\"\nfixture = \"table\"{rest}");
    let message = read(&text).unwrap_err();
    assert!(message.contains("tool, edge_radius_mm") && message.contains("found 11 mm"), "{message}");
}

#[test]
fn what_does_not_fit_together_is_refused() {
    refused("name = \"table\"", "name = \"hole\"", &["distinct names", "\"hole\" twice"]);
    let command = "name = \"\\u001b[31m\"";
    refused("name = \"table\"", command, &["fixture, name", "without control characters", "'\\u{1b}'"]);
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
    refused(
        "sigma_mm = 0.1",
        "free = true\nsigma_mm = 0.1",
        &["problem.toml:12:12, tool", "free or standard deviations", "both"],
    );
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
        &["a socket, plane or target, which a ball can touch", "a hole"],
    );
    refused(
        "kind = \"socket\"\nfree = true",
        "kind = \"socket\"\nfree = true\ndepth_mm = 3",
        &["what belongs to a socket", "`depth_mm`"],
    );
    let known = BALL.replace("free = true\n", "").replace("\"fixture\"", "\"strain\"");
    assert!(read(&known).unwrap_err().contains("`base_from_fixture`, or `free = true`"));
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

#[test]
fn more_than_can_be_estimated_is_refused() {
    let hole = &FULL[FULL.find("[[fixture]]").unwrap()..FULL.find("[[distance]]").unwrap()];
    let hole = &hole[..hole[1..].find("[[fixture]]").unwrap() + 1];
    let with = |count: usize| {
        let more: String = (0..count).map(|k| hole.replace("name = \"hole\"", &format!("name = \"h{k}\""))).collect();
        FULL.replace("[[distance]]", &format!("{more}[[distance]]"))
    };
    // Six of the place and seven gap biases each.
    let message = read(&with(90)).unwrap_err();
    assert!(message.contains("at most 1000 parameters to estimate, found 12"), "{message}");
    let message = read(&with(1000)).unwrap_err();
    assert!(message.contains("at most 1000 [[fixture]] tables, found 1002"), "{message}");
}
