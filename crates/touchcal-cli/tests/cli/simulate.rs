//! Simulated logs: files, that they can be calibrated, errors.

use std::path::Path;

use super::{errors, json, stderr, stdout, touchcal};

fn bytes(folder: &Path, names: &[&str]) -> Vec<Vec<u8>> {
    names.iter().map(|name| std::fs::read(folder.join(name)).unwrap()).collect()
}

#[test]
fn a_preset_is_simulated_and_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let args = ["simulate", "--preset", "leo_aluminium", "--seed", "3", "--contacts", "1500", "--out"];
    let done = touchcal(folder.path(), &[&args[..], &["a"]].concat()).success();
    assert!(errors(&done).is_empty() && stdout(&done).contains("touchcal calibrate a/problem.toml"));
    touchcal(folder.path(), &[&args[..], &["b"]].concat()).success();
    let names = ["problem.toml", "scenario.toml", "hole.csv", "truth.json", "true.urdf"];
    assert_eq!(bytes(&at("a"), &names), bytes(&at("b"), &names), "the same seed, the same bytes");
    let header = std::fs::read_to_string(at("a/hole.csv")).unwrap().lines().next().unwrap().to_owned();
    assert!(
        header.starts_with("t,joint_a1,")
            && header.ends_with(",tz,contact,temperature_0_c,temperature_1_c,temperature_2_c,temperature_3_c")
    );

    touchcal(folder.path(), &["calibrate", "a/problem.toml", "--out", "out"]).success();
    let (estimate, truth) = (json(&at("out/estimate.json")), json(&at("a/truth.json")));
    assert_eq!(
        estimate["contacts"]["used"].as_u64().unwrap() + estimate["contacts"]["rejected"].as_u64().unwrap(),
        1500
    );
    let truth = truth["parameters"].as_object().unwrap();
    assert_eq!(truth.len(), 24, "four segments, seven offsets, six components each of tool and hole, edges");
    for parameter in estimate["parameters"].as_array().unwrap() {
        let Some(truth) = truth.get(parameter["name"].as_str().unwrap()) else { continue };
        let (error, sigma) =
            (parameter["value"].as_f64().unwrap() - truth.as_f64().unwrap(), parameter["sigma"].as_f64().unwrap());
        assert!(error.abs() < 5.0 * sigma, "{}: {error} ± {sigma}", parameter["name"]);
    }
}

#[test]
fn another_noise_leaves_the_arm_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // With random phases another noise seed draws another path.
    let text = "preset = \"workcell\"\ncontacts = 50\n[exploration]\nrandom_phases = false\n";
    std::fs::write(at("path.toml"), text).unwrap();
    let args = ["simulate", "path.toml", "--seed", "3"];
    let simulate = |more: &[&str]| touchcal(folder.path(), &[&args[..], more].concat()).success();
    simulate(&["--out", "a"]);
    simulate(&["--out", "same", "--noise-seed", "3"]);
    simulate(&["--out", "other", "--noise-seed", "4"]);
    let names = ["problem.toml", "scenario.toml", "hole.csv", "truth.json"];
    assert_eq!(bytes(&at("a"), &names), bytes(&at("same"), &names));
    assert_eq!(bytes(&at("a"), &names[..2]), bytes(&at("other"), &names[..2]));

    let [a, other] = ["a", "other"].map(|name| json(&at(name).join("truth.json")));
    for key in ["seed", "parameters", "clearance_mm"] {
        assert_eq!(a[key], other[key]);
    }
    assert_eq!((&a["noise_seed"], &other["noise_seed"]), (&serde_json::Value::Null, &4.into()));
    let joints = |name: &str| {
        let log = std::fs::read_to_string(at(name).join("hole.csv")).unwrap();
        let row = log.lines().nth(1).unwrap().split(',').skip(1).take(7);
        row.map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<_>>()
    };
    for (a, other) in joints("a").iter().zip(joints("other")) {
        assert!(*a != other && (a - other).abs() < 1e-3, "{a} {other}: encoders scatter by hundredths of a degree");
    }
}

/// What is written is what was simulated: to the digits of the file.
#[test]
fn the_scenario_written_gives_the_same_log() {
    let folder = tempfile::tempdir().unwrap();
    let text = "preset = \"workcell\"\ncontacts = 300\n[exploration]\nswing_deg = 12\n[recorder]\nmissed = 0.1\nspurious = 0.2\n";
    std::fs::write(folder.path().join("mine.toml"), text).unwrap();
    touchcal(folder.path(), &["simulate", "mine.toml", "--out", "a"]).success();
    touchcal(folder.path(), &["simulate", "a/scenario.toml", "--out", "b"]).success();
    let names = ["problem.toml", "scenario.toml"];
    assert_eq!(bytes(&folder.path().join("a"), &names), bytes(&folder.path().join("b"), &names));
    let log = |name: &str| std::fs::read_to_string(folder.path().join(name).join("hole.csv")).unwrap();
    let (first, second) = (log("a"), log("b"));
    assert_eq!(first.lines().count(), second.lines().count());
    for (a, b) in first.lines().zip(second.lines()).skip(1) {
        for (a, b) in a.split(',').zip(b.split(',')) {
            let [a, b] = [a, b].map(|cell| cell.parse::<f64>().unwrap());
            assert!((a - b).abs() < 3e-4, "{a} {b}");
        }
    }
    let truth = json(&folder.path().join("a/truth.json"));
    assert!(
        truth["rows"]["hole"]["spurious"].as_u64().unwrap() > 30
            && truth["rows"]["hole"]["missed"].as_u64().unwrap() > 10
    );
}

/// What the scenario says of tolerances and distances is declared in the problem that it poses.
#[test]
fn exact_parts_and_measured_distances_are_declared() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut text = "contacts = 40\n[errors]\njoint_offset_deg = 0.2\n[tool]\nkind = \"ball\"\n\
         tip_from_tool = { xyz_mm = [20, 0, 100], quat_wxyz = [0, 0, 1, 0] }\nsigma_mm = 0.1\n\
         [exploration]\nradius_mm = 0\npress_mm = 10\ntilt_deg = 30\nswing_deg = 20\n[recorder]\nrate_hz = 2\n"
        .to_owned();
    for (name, place, known) in [
        ("front", "[550, 0, 150]", "exact = true"),
        ("left", "[400, 400, 250]", "sigma_mm = 0.5"),
        ("right", "[450, -350, 100]", "free = true\nsigma_mm = 2"),
    ] {
        text += &format!(
            "[[fixture]]\nname = \"{name}\"\nkind = \"socket\"\nbase_from_fixture = {{ xyz_mm = {place} }}\n\
             {known}\npostures_deg = [[0, 42, 15, -89, -13, 50, -1]]\n"
        );
    }
    text += "[[distance]]\nbetween = [\"front\", \"left\"]\nexact = true\n\
         [[distance]]\nbetween = [\"left\", \"right\"]\nsigma_mm = 0.2\n";
    std::fs::write(at("s.toml"), text).unwrap();
    touchcal(folder.path(), &["simulate", "s.toml", "--seed", "5", "--out", "sim"]).success();
    touchcal(folder.path(), &["simulate", "sim/scenario.toml", "--seed", "5", "--out", "again"]).success();
    let names = ["problem.toml", "scenario.toml", "truth.json"];
    assert_eq!(bytes(&at("sim"), &names[..2]), bytes(&at("again"), &names[..2]));

    let truth = json(&at("sim/truth.json"));
    let names: Vec<&String> = truth["parameters"].as_object().unwrap().keys().collect();
    assert!(names.iter().any(|name| name.starts_with("fixture.left")), "{names:?}");
    assert!(!names.iter().any(|name| name.starts_with("fixture.front")), "{names:?}");
    let number = |table: &serde_json::Value, key: &str| table[key].as_f64().unwrap();
    let [exact, measured] = &truth["distances"].as_array().unwrap()[..] else { panic!("two distances") };
    assert_eq!(number(exact, "true_mm"), number(exact, "declared_mm"));
    let error = number(measured, "declared_mm") - number(measured, "true_mm");
    assert!(error != 0.0 && error.abs() < 1.0, "{error} mm");
    let problem = std::fs::read_to_string(at("sim/problem.toml")).unwrap();
    assert!(problem.contains(&format!("mm = {:.9}", number(measured, "declared_mm"))[..12]), "{problem}");
    assert_eq!(problem.matches("exact = true").count(), 2, "of `front` and the first distance: {problem}");

    touchcal(folder.path(), &["calibrate", "sim/problem.toml", "--out", "out"]).success();
    let estimate = json(&at("out/estimate.json"));
    // That of a free fixture is about where its contacts put it, not about the scenario's place.
    let all = estimate["parameters"].as_array().unwrap().iter();
    for parameter in all.filter(|parameter| !parameter["name"].as_str().unwrap().starts_with("fixture.right")) {
        let Some(truth) = truth["parameters"].get(parameter["name"].as_str().unwrap()) else { continue };
        let (error, sigma) = (number(parameter, "value") - truth.as_f64().unwrap(), number(parameter, "sigma"));
        assert!(error.abs() < 5.0 * sigma, "{}: {error} ± {sigma}", parameter["name"]);
    }
}

/// Of several ways to reach a fixture inverse kinematics takes the one that it finds from the
/// posture given; where that is far from it, a note says so.
#[test]
fn another_posture_than_given_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    let notes = |turn: i32, wrist: i32| {
        let text = format!(
            "contacts = 20\n[tool]\nkind = \"ball\"\ntip_from_tool = {{ xyz_mm = [0, 0, 100], quat_wxyz = [0, 0, 1, 0] }}\n\
             [exploration]\nradius_mm = 0\npress_mm = 10\ntilt_deg = 30\nswing_deg = 10\n[recorder]\nrate_hz = 2\n\
             [[fixture]]\nname = \"near\"\nkind = \"socket\"\nbase_from_fixture = {{ xyz_mm = [550, 0, 150] }}\n\
             postures_deg = [[0, 42, 15, -89, -13, 50, -1]]\n\
             [[fixture]]\nname = \"far\"\nkind = \"socket\"\nbase_from_fixture = {{ xyz_mm = [-300, 460, 150] }}\n\
             postures_deg = [[{turn}, 42, 15, -89, -13, 50, {wrist}]]\n"
        );
        std::fs::write(folder.path().join("s.toml"), text).unwrap();
        let done = touchcal(folder.path(), &["simulate", "s.toml", "--out", &format!("turned{turn}")]).success();
        errors(&done).lines().filter(|line| line.contains("posture than given")).map(str::to_owned).collect::<Vec<_>>()
    };
    let [note] = &notes(0, -1)[..] else { panic!("one note") };
    assert!(
        note.starts_with(
            "touchcal: note: `far`: the arm works in another posture than given in 20 of 20 contacts, `joint_a"
        ),
        "{note}"
    );
    assert!(notes(123, 122).is_empty());
}

#[track_caller]
fn refused(text: &str, message: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let done = touchcal(folder.path(), &["simulate", "s.toml", "--out", "out"]).code(1);
    for part in message {
        assert!(stderr(&done).contains(part), "expected `{part}` in: {}", stderr(&done));
    }
    assert_eq!(errors(&done).lines().count(), 1);
    assert!(stdout(&done).is_empty() && !folder.path().join("out").exists());
}

#[test]
fn wrong_scenarios_are_refused_with_line_and_column() {
    refused("preset = \"papr\"", &["s.toml:1:10, preset: expected `paper`, ", "did you mean `paper`?"]);
    refused(
        "preset = \"paper\"\n[recorder]\nrate_h = 300\n",
        &["s.toml:3:1: unknown field `rate_h`", "did you mean `rate_hz`?"],
    );
    refused(
        "[recorder]\nspurious = 1.5\n",
        &["s.toml:2:12, recorder, spurious: expected a share from 0 to below 1, found 1.5"],
    );
    refused("contacts = 0\n", &["s.toml:1:12, contacts: expected a whole number from 1 to 1000000, found 0"]);
    refused("[robot]\nbuiltin = \"panda\"\n[[fixture]]\nname = \"a\"\n", &["missing field `kind`"]);
    let mesh = "meshes can be calibrated with, but not simulated, found a mesh";
    refused(
        "[tool]\nkind = \"peg\"\nmesh = \"peg.stl\"\n[[fixture]]\nname = \"h\"\nkind = \"hole\"\ndepth_mm = 10\nbase_from_fixture = { xyz_mm = [500, 0, 0] }\npostures_deg = [[0, 40, 0, -90, 0, 50, 0]]\n",
        &["s.toml:3:8, tool: expected `outline` or `builtin`", mesh],
    );
    refused(
        "[tool]\nkind = \"peg\"\nbuiltin = \"extrusion25\"\nlength_mm = 20\n[[fixture]]\nname = \"h\"\nkind = \"hole\"\nmesh = \"h.stl\"\nbase_from_fixture = { xyz_mm = [500, 0, 0] }\npostures_deg = [[0, 40, 0, -90, 0, 50, 0]]\n",
        &["s.toml:8:8, fixture `h`: expected `outline` or `builtin`", mesh],
    );
    let exact = "expected true, false, or a list of what is exact (`place` or `outline`), found \"plac\"";
    refused(
        "[tool]\nkind = \"ball\"\nexact = [\"plac\"]\n[[fixture]]\nname = \"s\"\nkind = \"socket\"\nbase_from_fixture = {}\npostures_deg = [[0, 40, 0, -90, 0, 50, 0]]\n",
        &["s.toml:3:9, tool, exact: ", exact, "did you mean `place`?"],
    );
    refused(
        "preset = \"mukca\"\n[[distance]]\nbetween = [\"front/0\", \"left/0\"]\nmm = 250\n",
        &["s.toml:4:6, distance, mm: expected `sigma_mm` or `exact` alone"],
    );
    refused("[tool]\nkind = \"ball\"\n", &["s.toml:1:1, tool: expected [[fixture]] tables"]);
    refused("[exploration]\nradius_mm = 0\npress_mm = 0\ntilt_deg = 0\n", &["expected contacts with `hole`"]);
    refused(
        "[tool]\nkind = \"ball\"\n[[fixture]]\nname = \"s\"\nkind = \"socket\"\nbase_from_fixture = { xyz_mm = [9000, 0, 0] }\npostures_deg = [[0, 40, 0, -90, 0, 50, 0]]\n",
        &["the arm cannot reach `s`"],
    );
}

#[test]
fn a_users_problem_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("problem.toml"), "mine").unwrap();
    let done = touchcal(folder.path(), &["simulate", "--preset", "paper", "--out", "."]).code(1);
    assert!(stderr(&done).contains("problem.toml: expected no file but those that touchcal wrote"));
    assert_eq!(std::fs::read_to_string(folder.path().join("problem.toml")).unwrap(), "mine");
}

/// An arm whose last joint turns twice, and postures a turn apart: joints go on from where they
/// were, within their limits.
#[test]
fn joints_do_not_jump_by_a_turn() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (_, urdf) = touchcal::robot::builtin::ALL.iter().find(|(name, _)| *name == "iiwa14").unwrap();
    let narrow = "lower=\"-3.054326\" upper=\"3.054326\"";
    let wide = urdf.replace(narrow, "lower=\"-6.283185\" upper=\"6.283185\"");
    assert_ne!(*urdf, wide);
    std::fs::write(at("wide.urdf"), wide).unwrap();
    touchcal(folder.path(), &["simulate", "--preset", "paper", "--contacts", "60", "--out", "first"]).success();
    let text = std::fs::read_to_string(at("first/scenario.toml")).unwrap();
    let (before, rest) = text.split_once("postures_deg = [[").unwrap();
    let (posture, after) = rest.split_once("]]").unwrap();
    let (others, last) = posture.rsplit_once(", ").unwrap();
    let last: f64 = last.parse().unwrap();
    let turned = |turns: [f64; 3]| {
        let each = turns.map(|turns| format!("[{others}, {}]", last + 360.0 * turns));
        format!("{before}postures_deg = [{}]{after}", each.join(", "))
    };
    let apart = |name: &str, scenario: String| {
        std::fs::write(at(name), scenario).unwrap();
        touchcal(folder.path(), &["simulate", name, "--out", "sim"]).success();
        let log = std::fs::read_to_string(at("sim/hole.csv")).unwrap();
        let q: Vec<f64> = log.lines().skip(1).map(|line| line.split(',').nth(7).unwrap().parse().unwrap()).collect();
        let most = q.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        let largest = q.iter().fold(0.0, |largest: f64, q| largest.max(q.abs()));
        (most, largest)
    };
    let wide = |text: String| text.replace("builtin = \"iiwa14\"", "urdf = \"wide.urdf\"");
    let (most, largest) = apart("wide.toml", wide(turned([0.0, 1.0, -1.0])));
    assert!(most < 1.0 && largest < 2.0, "{most} {largest}");
    let (most, largest) = apart("far.toml", wide(turned([1.0, 0.0, -1.0])));
    assert!(most < 1.0 && largest > 5.0, "{most} {largest}");
    // A joint of less than a turn stays where the posture has it.
    let (most, _) = apart("narrow.toml", turned([0.0, 1.0, 0.0]));
    assert!(most > 6.0, "{most}");
}
