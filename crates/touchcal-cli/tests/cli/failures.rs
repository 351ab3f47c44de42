//! Wrong input and wrong usage: one message, the right exit code, no files.

use std::path::Path;

use super::{data, json, stderr, stdout, touchcal};

const SOCKET: &str = r#"
[robot]
urdf = "panda.urdf"
[tool]
kind = "ball"
[[fixture]]
name = "socket"
kind = "socket"
free = true
[[contacts]]
file = "contacts.csv"
fixture = "socket"
[estimate]
parameters = ["strain", "joint_offset"]
"#;

/// A folder with one socket's problem, as `problem` changes it.
fn one_socket(problem: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let copy = |from: &str, to: &str| std::fs::copy(data().join("mukca").join(from), folder.path().join(to)).unwrap();
    copy("panda.urdf", "panda.urdf");
    copy("panda_3/backleft/hole_0.csv", "contacts.csv");
    std::fs::write(folder.path().join("problem.toml"), problem).unwrap();
    folder
}

#[track_caller]
fn fails(folder: &Path, args: &[&str], code: i32, message: &[&str]) {
    let done = touchcal(folder, args).code(code);
    for part in message {
        assert!(stderr(&done).contains(part), "expected `{part}` in: {}", stderr(&done));
    }
    assert_eq!(stdout(&done), "");
    assert!(!folder.join("out").exists());
}

#[test]
fn a_typo_gets_one_clear_message() {
    let folder = one_socket(&SOCKET.replace("fixture = ", "fixtur = "));
    let done = touchcal(folder.path(), &["calibrate", "problem.toml", "--out", "out"]).code(1);
    let message = stderr(&done);
    assert!(message.starts_with("touchcal: error: problem.toml:12:1: unknown field `fixtur`"), "{message}");
    assert!(message.ends_with("did you mean `fixture`?\n"), "{message}");
    assert_eq!(message.lines().count(), 1);
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_unit_left_out_of_a_key_is_suggested() {
    let folder = one_socket(&SOCKET.replace("\"ball\"", "\"ball\"\nsigma = 1"));
    fails(folder.path(), &["inspect", "problem.toml"], 1, &["unknown field `sigma`", "did you mean `sigma_mm`?"]);
}

/// What a command prints may not get lost without a word.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    for args in [&["--help"][..], &["calibrate", "--help"], &["--version"], &["reference"], &["completions", "bash"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let child = std::process::Command::new(env!("CARGO_BIN_EXE_touchcal"))
            .current_dir(folder.path())
            .args(args)
            .stdout(full)
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{args:?}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains("could not write to stdout"), "{args:?}: {message}");
    }
}

#[test]
fn names_do_not_command_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let done = touchcal(folder.path(), &["inspect", "\u{1b}[31mno.toml"]);
    assert!(stderr(&done).starts_with("touchcal: error: \\u001b[31mno.toml: could not open"), "{}", stderr(&done));
}

#[test]
fn missing_files_are_named() {
    let folder = one_socket(&SOCKET.replace("contacts.csv", "contact.csv"));
    fails(folder.path(), &["calibrate", "nothing.toml", "--out", "out"], 1, &["nothing.toml", "No such file"]);
    fails(folder.path(), &["calibrate", "problem.toml", "--out", "out"], 1, &["problem.toml:11:8", "contact.csv"]);
}

#[test]
fn sockets_that_no_arm_can_have_so_far_apart_are_contradicted() {
    let mut problem = SOCKET.replace("\"socket\"", "\"one\"");
    let second = "[[fixture]]\nname = \"two\"\nkind = \"socket\"\nfree = true\n";
    problem = problem
        .replace("kind = \"one\"", "kind = \"socket\"")
        .replace("[[contacts]]", &format!("{second}[[contacts]]"));
    problem +=
        "[[contacts]]\nfile = \"second.csv\"\nfixture = \"two\"\n[[distance]]\nbetween = [\"one\", \"two\"]\nmm = 50\n";
    let folder = one_socket(&problem);
    let at = |name: &str| folder.path().join(name);
    let second =
        |from: &str| std::fs::copy(data().join("mukca/panda_3/backleft").join(from), at("second.csv")).unwrap();
    let warnings = |code: i32| stdout(&touchcal(folder.path(), &["inspect", "problem.toml"]).code(code));
    second("hole_1.csv");
    assert!(!warnings(0).contains("Warning"), "{}", warnings(0));
    // The same contacts twice, in other digits and as the same rows, then a distance in metres.
    let same = std::fs::read_to_string(at("contacts.csv")).unwrap();
    std::fs::write(at("second.csv"), same.replace("e+00", "E+0")).unwrap();
    assert!(warnings(3).contains("`one` and `two` are declared 50 mm apart; by the nominal arm it is 0.0 mm"));
    second("hole_0.csv");
    let done = touchcal(folder.path(), &["inspect", "problem.toml"]);
    let note = "second.csv: 31 of 31 contacts are rows that were read before, in this log or another";
    assert!(stderr(&done).contains(note), "{}", stderr(&done));
    second("hole_1.csv");
    std::fs::write(at("problem.toml"), problem.replace("mm = 50", "mm = 0.05")).unwrap();
    assert!(warnings(3).contains("`one` and `two` are declared 0.05 mm apart"), "{}", warnings(3));
    let done = touchcal(folder.path(), &["calibrate", "problem.toml", "--out", "out"]).code(3);
    assert!(stdout(&done).contains("-> check the unit of the distance"), "{}", stdout(&done));
}

#[test]
fn a_tool_far_from_where_it_is_said_to_be_is_seen() {
    let problem =
        SOCKET.replace("kind = \"ball\"", "kind = \"ball\"\nsigma_mm = 5\ntip_from_tool = { xyz_mm = [0, 0, 120] }");
    let folder = one_socket(&problem);
    let nominal = |problem: &str, code: i32| {
        std::fs::write(folder.path().join("problem.toml"), problem).unwrap();
        let inspected = stdout(&touchcal(folder.path(), &["inspect", "problem.toml"]).code(code));
        let row = inspected.lines().find(|line| line.trim_start().starts_with("socket")).unwrap().to_owned();
        row.split_whitespace().rev().nth(1).unwrap().parse::<f64>().unwrap()
    };
    // The tip link is the ball.
    assert!(nominal(SOCKET, 0) < 5.0 && nominal(&problem, 3) > 40.0);
    let done = touchcal(folder.path(), &["calibrate", "problem.toml", "--out", "out"]);
    let said = stdout(&done.code(3));
    assert!(said.contains("-> measure the tool's pose again, and check its unit and axes"), "{said}");
}

#[test]
fn wrong_usage_exits_with_2() {
    let folder = one_socket(SOCKET);
    fails(folder.path(), &["calibrate", "problem.toml", "--out", "out", "--fast"], 2, &["--fast"]);
    fails(folder.path(), &["calibrate", "--out", "out"], 2, &["PROBLEM.toml"]);
    fails(folder.path(), &["calibrate", "problem.toml", "--mukca", ".", "--out", "out"], 2, &["cannot be used with"]);
}

/// Options that were replaced with `--mukca` are refused beside a problem file.
#[test]
fn options_of_a_folder_do_not_go_with_a_problem_file() {
    let folder = one_socket(SOCKET);
    for (command, option, value) in [
        ("inspect", "--urdf", Some("panda.urdf")),
        ("calibrate", "--urdf", Some("panda.urdf")),
        ("calibrate", "--spacing-mm", Some("50")),
        ("calibrate", "--joint-compliance", None),
        ("evaluate", "--nominal", Some("panda.urdf")),
    ] {
        let needed = match command {
            "calibrate" => &["--out", "out"][..],
            "evaluate" => &["--urdf", "panda.urdf"],
            _ => &[],
        };
        let args = [&[command, "problem.toml", option], value.as_slice(), needed].concat();
        fails(folder.path(), &args, 2, &["[PROBLEM.toml]' cannot be used with", option]);
    }
}

#[test]
fn inputs_are_not_overwritten() {
    let folder = one_socket(&SOCKET.replace("panda.urdf", "calibrated.urdf"));
    let at = |name: &str| folder.path().join(name);
    std::fs::rename(at("panda.urdf"), at("calibrated.urdf")).unwrap();
    let before = std::fs::read(at("calibrated.urdf")).unwrap();
    fails(
        folder.path(),
        &["calibrate", "problem.toml", "--out", "."],
        2,
        &["calibrated.urdf: expected an output that"],
    );
    assert_eq!(std::fs::read(at("calibrated.urdf")).unwrap(), before);
    assert!(!at("estimate.json").exists());

    let log = std::fs::read(at("contacts.csv")).unwrap();
    let convert = ["convert", "contacts.csv", "--urdf", "calibrated.urdf", "--out", "./contacts.csv"];
    fails(folder.path(), &convert, 2, &["contacts.csv: expected an output that is no input"]);
    assert_eq!(std::fs::read(at("contacts.csv")).unwrap(), log);

    std::fs::write(at("manifold.csv"), "x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n0.01,0,0,1,0,0,0\n").unwrap();
    fails(folder.path(), &["manifold", "--poses", "manifold.csv", "--out", "manifold.csv"], 2, &["manifold.csv: "]);

    std::fs::create_dir(at("sim")).unwrap();
    std::fs::write(at("sim/scenario.toml"), "preset = \"paper\"  # mine\n").unwrap();
    fails(folder.path(), &["simulate", "sim/scenario.toml", "--out", "sim"], 2, &["sim/scenario.toml: "]);
}

#[test]
fn a_file_is_no_folder_to_write_into() {
    let folder = one_socket(SOCKET);
    let into = ["calibrate", "problem.toml", "--out", "contacts.csv/deeper"];
    fails(folder.path(), &into, 2, &["contacts.csv: expected a folder to write into, found a file"]);
}

#[test]
fn a_peg_drawn_beside_its_frame_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["simulate", "--preset", "paper", "--contacts", "100", "--out", "sim"]).code(0);
    let at = |name: &str| folder.path().join("sim").join(name);
    let problem = std::fs::read_to_string(at("problem.toml")).unwrap();
    std::fs::write(at("problem.toml"), problem.replace("builtin = \"extrusion25\"", "outline = \"peg.csv\"")).unwrap();
    let inspect = |left: f64| {
        let corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)];
        let outline: String = corners.map(|(x, y)| format!("{},{}\n", x - left, y - 5.0)).concat();
        std::fs::write(at("peg.csv"), outline).unwrap();
        stdout(&touchcal(folder.path(), &["inspect", "sim/problem.toml"]).code(0))
    };
    assert!(!inspect(1.0).contains("Warning"), "{}", inspect(1.0));
    let said = inspect(-1.0);
    assert!(said.contains("its middle is at (11.0, 0.0) mm"), "{said}");
}

/// `inspect` says that a log does not determine the arm, with the exit code that `calibrate` will
/// have; the whole log does.
#[test]
fn contacts_that_do_not_determine_the_arm_are_told_by_inspect() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["simulate", "--preset", "paper", "--contacts", "600", "--out", "sim"]).code(0);
    let log = folder.path().join("sim/hole.csv");
    let whole = std::fs::read_to_string(&log).unwrap();
    let inspect = |code| stdout(&touchcal(folder.path(), &["inspect", "sim/problem.toml"]).code(code));
    assert!(!inspect(0).contains("Warning"), "{}", inspect(0));
    for (rows, words) in [(4, "4 measured rows cannot determine 8 parameters"), (11, "% as uncertain as before")] {
        let first: Vec<&str> = whole.lines().take(1 + rows).collect();
        std::fs::write(&log, first.join("\n") + "\n").unwrap();
        assert!(inspect(3).contains(words), "{}", inspect(3));
        let calibrated = touchcal(folder.path(), &["calibrate", "sim/problem.toml", "--out", "out"]).code(3);
        assert!(stdout(&calibrated).contains(words), "{}", stdout(&calibrated));
    }
}

/// Priors that are far narrower than what contacts show leave the arm as it was, and the summary
/// has both expected errors.
#[test]
fn a_calibration_that_hardly_improves_the_arm_says_so() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["simulate", "--preset", "paper", "--contacts", "60", "--out", "sim"]).code(0);
    let path = folder.path().join("sim/problem.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let narrow = "parameters = [\"joint_offset\"]\nprior = { joint_offset_deg = 1e-5 }";
    let changed = text.replace("parameters = [\"strain\", \"joint_offset\"]", narrow);
    assert_ne!(changed, text);
    std::fs::write(&path, changed).unwrap();
    let done = stdout(&touchcal(folder.path(), &["calibrate", "sim/problem.toml", "--out", "out"]).code(3));
    assert!(done.contains("hardly better than the nominal one"), "{done}");
    let estimate = json(&folder.path().join("out/estimate.json"));
    let warnings = estimate["warnings"].as_array().unwrap();
    let message = |kind: &str| {
        let found = warnings.iter().find(|warning| warning["kind"] == kind);
        found.and_then(|warning| warning["message"].as_str()).unwrap_or_default()
    };
    assert!(message("arm_undetermined").contains("without contacts 0.00"), "{warnings:?}");
    let tool = &estimate["workspace_uncertainty"];
    for key in ["distance_mm", "nominal_distance_mm"] {
        let number = format!("by {:.3} mm", tool[key].as_f64().unwrap());
        assert!(message("little_improvement").contains(&number), "{number}: {warnings:?}");
    }
}

/// Four vertices (mm) of OBJ around (`x`, 0), anticlockwise from above.
fn square_of_obj(x: f64, half: f64, z: f64) -> String {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    corners.map(|(i, j)| format!("v {} {} {z}\n", x + half * i, half * j)).concat()
}

/// Triangles of OBJ: two for each of these faces of four vertices.
fn faces_of_obj(faces: &[[i32; 4]]) -> String {
    let triangles = faces.iter().map(|[a, b, c, d]| format!("f {a} {b} {c}\nf {a} {c} {d}\n"));
    triangles.collect()
}

#[test]
fn inspect_exits_with_3_for_a_mesh_of_two_pegs() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["simulate", "--preset", "paper", "--contacts", "100", "--out", "sim"]).code(0);
    let at = |name: &str| folder.path().join("sim").join(name);
    let peg = |x: f64, half: f64| {
        let vertices = square_of_obj(x, half, 0.0) + &square_of_obj(x, half, 40.0);
        let sides = [[-8, -7, -3, -4], [-7, -6, -2, -3], [-6, -5, -1, -2], [-5, -8, -4, -1]];
        vertices + &faces_of_obj(&[[-8, -5, -6, -7], [-4, -3, -2, -1]]) + &faces_of_obj(&sides)
    };
    // Outside, from below, the rim, and the hole's floor.
    let squares = [(30.0, -40.0), (30.0, 0.0), (10.5, 0.0), (10.5, -30.0)].map(|(half, z)| square_of_obj(0.0, half, z));
    let sides = (0..4).flat_map(|k| {
        let [low, top, rim, floor] = [1, 5, 9, 13].map(|first| [first + k, first + (k + 1) % 4]);
        let between = |[a, b]: [i32; 2], [d, c]: [i32; 2]| [a, b, c, d];
        [between(low, top), between(top, rim), between(rim, floor)]
    });
    let sides: Vec<[i32; 4]> = sides.collect();
    let hole = squares.concat() + &faces_of_obj(&[[1, 4, 3, 2], [13, 14, 15, 16]]) + &faces_of_obj(&sides);
    std::fs::write(at("hole.obj"), hole).unwrap();
    let problem = std::fs::read_to_string(at("problem.toml")).unwrap();
    let problem = problem.replace("builtin = \"extrusion25\"\nlength_mm = 40\n", "mesh = \"peg.obj\"\n");
    let problem = problem.replace("outline_offset_mm = 0.5", "mesh = \"hole.obj\"");
    std::fs::write(at("problem.toml"), problem.replace("edge_radius_mm = 0\n", "")).unwrap();
    let inspect = |peg: String, code: i32| {
        std::fs::write(at("peg.obj"), peg).unwrap();
        let done = touchcal(folder.path(), &["inspect", "sim/problem.toml"]).code(code);
        String::from_utf8_lossy(&done.get_output().stderr).into_owned()
    };
    assert!(!inspect(peg(0.0, 10.0), 0).contains("several bodies"));
    let stderr = inspect(peg(-5.0, 4.0) + &peg(5.0, 4.0), 3);
    assert!(stderr.contains("meshes of several bodies, each of which can be touched: tool (2)"), "{stderr}");
}

#[test]
fn another_robot_cannot_be_scored() {
    let folder = one_socket(SOCKET);
    let urdf = std::fs::read_to_string(folder.path().join("panda.urdf")).unwrap();
    std::fs::write(folder.path().join("other.urdf"), urdf.replace("panda_joint3", "elbow")).unwrap();
    let message = ["other.urdf: expected the moving joints", "panda_joint3", "elbow"];
    fails(folder.path(), &["evaluate", "problem.toml", "--urdf", "other.urdf"], 1, &message);
}

#[test]
fn places_that_are_uncertain_are_scored_with_a_note() {
    let noted = |problem: &str| {
        let folder = one_socket(problem);
        let said = stderr(&touchcal(folder.path(), &["evaluate", "problem.toml", "--urdf", "panda.urdf"]).success());
        let (assumed, others): (Vec<&str>, Vec<&str>) =
            said.lines().partition(|line| line.starts_with("touchcal: note: assumed, since no standard deviations"));
        assert_eq!(assumed.len(), usize::from(!problem.contains("\"ball\"\nsigma_mm")), "{said}");
        others.join("\n")
    };
    assert_eq!(noted(SOCKET), "", "a socket without a place is scored without one");
    assert_eq!(
        noted(&SOCKET.replace("\"ball\"", "\"ball\"\nsigma_mm = 1")),
        "",
        "the tip link is where the URDF has it"
    );
    let beside = "\"ball\"\nsigma_mm = 1\ntip_from_tool = { xyz_mm = [0, 0, 1] }";
    let said = noted(&SOCKET.replace("\"ball\"", beside));
    assert!(said.starts_with("touchcal: note: poses are taken as declared"), "{said}");
    assert!(said.contains("that of the tool is") && said.contains("`--estimate estimate.json`"), "{said}");
    let said = noted(&SOCKET.replace("free = true", "sigma_mm = 1\nbase_from_fixture = { xyz_mm = [500, 0, 100] }"));
    assert!(said.contains("that of fixture `socket` is"), "{said}");
}

#[test]
fn an_undetermined_arm_is_not_usable_and_says_so() {
    let folder = one_socket(SOCKET);
    let done = touchcal(folder.path(), &["calibrate", "problem.toml", "--out", "out"]).code(3);
    assert!(stdout(&done).starts_with("NOT USABLE: DO NOT USE"), "{}", stdout(&done));
    assert!(stderr(&done).contains("NOT USABLE"));
    let estimate = json(&folder.path().join("out/estimate.json"));
    assert_eq!(estimate["status"], "not_usable");
    assert_eq!(estimate["warnings"][0]["kind"], "arm_undetermined");
    assert!(folder.path().join("out/calibrated.urdf").exists());
}

#[test]
fn no_contacts_are_an_outcome_with_advice() {
    let folder = one_socket(&SOCKET.replace("file =", "force_threshold_n = 3\nfile ="));
    let log = "q1,q2,q3,q4,q5,q6,q7,fx,fy,fz\n0,0,0,-1,0,1,0,0.5,0,0\n";
    std::fs::write(folder.path().join("contacts.csv"), log).unwrap();
    let done = touchcal(folder.path(), &["calibrate", "problem.toml", "--out", "out"]).code(3);
    assert!(stdout(&done).contains("record more contacts"), "{}", stdout(&done));
    let inspected = touchcal(folder.path(), &["inspect", "problem.toml"]).code(3);
    assert!(stdout(&inspected).contains("record more contacts"), "{}", stdout(&inspected));
    let args = ["evaluate", "problem.toml", "--urdf", "panda.urdf"];
    let done = touchcal(folder.path(), &args).code(1);
    assert!(stderr(&done).ends_with("expected contacts to evaluate on, found none\n"), "{}", stderr(&done));
}

#[test]
fn demo_does_not_overwrite_a_users_problem() {
    let folder = one_socket(SOCKET);
    fails(
        folder.path(),
        &["demo", "--out", "."],
        1,
        &["problem.toml: expected no file but those that touchcal wrote", "choose another folder"],
    );
    assert_eq!(std::fs::read_to_string(folder.path().join("problem.toml")).unwrap(), SOCKET);
}
