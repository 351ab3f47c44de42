//! Results for drivers: `calibrate --driver-offsets`, offsets and URDF that together are the
//! calibrated arm, and `calibrate --export`.

use std::path::Path;

use super::new::filled_in;
use super::{json, stderr, stdout, touchcal};

#[test]
fn offsets_go_to_the_driver_and_leave_the_urdf_as_it_was() {
    let folder = filled_in("planes", &["planes.toml"]);
    let at = |name: &str| folder.path().join(name);
    let args = ["calibrate", "planes/problem.toml", "--out", "out", "--driver-offsets"];
    let done = touchcal(folder.path(), &args).success();
    assert!(
        stdout(&done)
            .contains("out/driver/joint_offsets.yaml, for drivers that apply encoder offsets: use both or neither")
    );
    let read = |name: &str| std::fs::read_to_string(at(name)).unwrap();
    assert_eq!(read("out/driver/robot.urdf"), read("planes/robot.urdf"), "nothing but offsets was estimated");
    assert_ne!(read("out/calibrated.urdf"), read("planes/robot.urdf"));
    let yaml = read("out/driver/joint_offsets.yaml");
    let lines: Vec<&str> = yaml.lines().filter(|line| !line.starts_with('#')).collect();
    let estimate = json(&at("out/estimate.json"));
    let offsets = estimate["parameters"].as_array().unwrap().iter().filter(|entry| entry["block"] == "joint_offset");
    let mut compared = 0;
    for (line, entry) in lines.iter().zip(offsets) {
        let (joint, rest) = line.split_once(": ").unwrap();
        assert_eq!(format!("joint_offset.{joint}"), entry["name"].as_str().unwrap());
        let offset: f64 = rest.strip_suffix("  # rad").unwrap().parse().unwrap();
        assert!((offset - entry["value"].as_f64().unwrap()).abs() < 1e-12, "{line}");
        compared += 1;
    }
    assert_eq!((compared, lines.len()), (7, 7));
}

/// Files that go to a robot are seen apart from the report.
#[test]
fn files_of_a_result_that_is_not_usable_say_so() {
    const WORDS: &str = "NOT USABLE: do not use this calibration";
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--contacts", "25", "--out", "demo"]).code(3);
    let calibrate = ["calibrate", "demo/problem.toml", "--out", "out", "--driver-offsets", "--export", "xacro"];
    let refused = touchcal(folder.path(), &calibrate).code(3);
    assert!(stdout(&refused).contains("Warning   (not usable) "), "{}", stdout(&refused));
    let read = |name: &str| std::fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    for name in ["calibrated.urdf", "driver/robot.urdf", "calibrated.xacro"] {
        assert_eq!(read(name).matches(&format!("<!-- {WORDS}")).count(), 1, "{name}");
    }
    let urdf = folder.path().join("out/calibrated.urdf");
    assert!(touchcal::io::urdf::read_file(&urdf, touchcal::io::urdf::Ends::default()).is_ok());
    assert!(read("driver/joint_offsets.yaml").starts_with(&format!("# {WORDS}")));

    touchcal(folder.path(), &["demo", "--contacts", "600", "--out", "more"]).success();
    touchcal(folder.path(), &["calibrate", "more/problem.toml", "--out", "usable"]).success();
    let urdf = std::fs::read_to_string(folder.path().join("usable/calibrated.urdf")).unwrap();
    assert!(!urdf.contains(WORDS));
}

#[test]
fn joint_origins_go_to_the_driver_of_universal_robots() {
    const PROBLEM: &str = r#"
[robot]
urdf = "arm.urdf"
[tool]
kind = "point"
free = true
[[fixture]]
name = "socket"
kind = "socket"
free = true
[[contacts]]
file = "log.csv"
fixture = "socket"
[estimate]
parameters = ["strain", "joint_offset"]
"#;
    let folder = filled_in("planes", &["planes.toml"]);
    let at = |name: &str| folder.path().join(name);
    let args = ["calibrate", "planes/problem.toml", "--out", "out", "--export", "ur"];
    let refused = touchcal(folder.path(), &args).code(1);
    assert!(stderr(&refused).contains("expected an arm with the joints shoulder_pan_joint, "), "{}", stderr(&refused));
    let args = ["calibrate", "planes/problem.toml", "--out", "out", "--export", "ros2_control"];
    let refused = touchcal(folder.path(), &args).code(1);
    assert!(stderr(&refused).contains("SimpleTransmission in <ros2_control> with the joint `joint_a1`, found none"));
    assert!(!at("out").exists());
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/ur10/ur10.urdf"), at("arm.urdf")).unwrap();
    let row =
        |k: usize| (0..6).map(|j| format!("{:.6}", (0.7 * k as f64 + 1.3 * f64::from(j)).sin())).collect::<Vec<_>>();
    let log: String = (0..40).map(|k| row(k).join(",") + "\n").collect();
    std::fs::write(at("log.csv"), log).unwrap();
    std::fs::write(at("problem.toml"), PROBLEM).unwrap();
    // Contacts that touch nothing: the result is not usable, and its files are written too.
    // All formats together, one of them twice.
    let args =
        ["calibrate", "problem.toml", "--out", "out", "--export", "ur", "--export", "dh,xacro", "--export", "ur"];
    let done = touchcal(folder.path(), &args).code(3);
    let said = stdout(&done);
    assert!(
        said.contains("out/ur_kinematics.yaml, kinematics_params_file of the driver of Universal Robots\n"),
        "{said}"
    );
    assert!(said.contains("-> it lacks the origin of the fixed joint `flange_joint`, which moved\n"), "{said}");
    let yaml = std::fs::read_to_string(at("out/ur_kinematics.yaml")).unwrap();
    assert!(yaml.contains("\nkinematics:\n  shoulder:\n    x: "), "{yaml}");
    let listed = &json(&at("out/touchcal.json"))["results"]["calibration"]["files"];
    for name in ["ur_kinematics.yaml", "dh.json", "calibrated.xacro"] {
        assert!(listed[name].is_string(), "{name}: {listed}");
        assert_eq!(said.matches(&format!("out/{name}, ")).count(), 1, "{said}");
    }
    let dh = json(&at("out/dh.json"));
    assert_eq!(dh["standard"].as_array().unwrap().len(), 6);
    assert_eq!(dh["tip"], "flange");
    let read = |name: &str| std::fs::read_to_string(at(name)).unwrap();
    let origin = |text: &str| {
        text.split("shoulder_lift_joint").nth(1).and_then(|rest| rest.split('>').nth(1)).map(str::to_owned)
    };
    assert_eq!(origin(&read("out/calibrated.xacro")), origin(&read("out/calibrated.urdf")));
    assert_ne!(origin(&read("out/calibrated.xacro")), origin(&read("arm.urdf")));
    // A calibration without them removes them.
    touchcal(folder.path(), &["calibrate", "problem.toml", "--out", "out"]).code(3);
    assert!(!at("out/dh.json").exists() && !at("out/calibrated.xacro").exists());
}

#[test]
fn a_folder_holds_one_calibration() {
    let folder = filled_in("planes", &["planes.toml"]);
    let at = |name: &str| folder.path().join(name);
    let calibrate = |more: &[&str]| {
        let args = ["calibrate", "planes/problem.toml", "--out", "out"];
        touchcal(folder.path(), &[&args[..], more].concat())
    };
    calibrate(&["--driver-offsets"]).success();
    std::fs::write(at("out/mine.txt"), "mine").unwrap();
    // A second calibration has no files for a driver: the former ones go, others stay.
    calibrate(&[]).success();
    assert!(!at("out/driver").exists() && at("out/mine.txt").exists());
    let names = |value: &serde_json::Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(
        names(&json(&at("out/touchcal.json"))["results"]["calibration"]["files"]),
        ["calibrated.urdf", "estimate.json", "report.html"]
    );
    // What touchcal did not write is not replaced.
    std::fs::create_dir(at("other")).unwrap();
    std::fs::write(at("other/report.html"), "mine").unwrap();
    let refused = touchcal(folder.path(), &["calibrate", "planes/problem.toml", "--out", "other"]).code(1);
    let expected = "other/report.html: expected no file but those that touchcal wrote, found another";
    assert!(stderr(&refused).contains(expected), "{}", stderr(&refused));
    assert_eq!(std::fs::read_dir(at("other")).unwrap().count(), 1);
    // A result whose writing was interrupted is not read, and replaced by the next one.
    let manifest = std::fs::read_to_string(at("out/touchcal.json")).unwrap();
    std::fs::write(at("out/touchcal.json"), manifest.replace("false", "true")).unwrap();
    let evaluate = ["evaluate", "planes/problem.toml", "--urdf", "out/calibrated.urdf"];
    let refused = touchcal(folder.path(), &evaluate).code(1);
    assert!(
        stderr(&refused).contains("out/calibrated.urdf: expected a file of a finished result"),
        "{}",
        stderr(&refused)
    );
    calibrate(&[]).success();
    touchcal(folder.path(), &evaluate).success();
}

/// The log with its offsets taken off, as the driver does, scores with the driver's URDF as the raw
/// one with the calibrated URDF.
#[test]
fn both_exports_are_the_same_arm() {
    let folder = filled_in("sockets", &["--preset", "mukca"]);
    let at = |name: &str| folder.path().join(name);
    touchcal(folder.path(), &["calibrate", "sockets/problem.toml", "--out", "out", "--driver-offsets"]).success();
    let score = |urdf: &str| -> f64 {
        let args = ["evaluate", "sockets/problem.toml", "--urdf", urdf, "--estimate", "out/estimate.json", "--json"];
        let score: serde_json::Value =
            serde_json::from_str(&stdout(&touchcal(folder.path(), &args).success())).unwrap();
        score["rms_mm"].as_f64().unwrap()
    };
    let folded = score("out/calibrated.urdf");
    let yaml = std::fs::read_to_string(at("out/driver/joint_offsets.yaml")).unwrap();
    let offset = |line: &str| Some(line.split_once(": ")?.1.strip_suffix("  # rad")?.parse::<f64>().unwrap());
    let offsets: Vec<f64> = yaml.lines().filter_map(offset).collect();
    assert!(offsets.iter().any(|offset| offset.abs() > 1e-3), "{offsets:?}");
    for file in std::fs::read_dir(at("sockets")).unwrap().map(|file| file.unwrap().path()) {
        if file.extension().is_some_and(|extension| extension == "csv") {
            std::fs::write(&file, taken_off(&std::fs::read_to_string(&file).unwrap(), &offsets)).unwrap();
        }
    }
    // Nine digits of a radian are in the log.
    assert!((score("out/driver/robot.urdf") - folded).abs() < 1e-5);
    assert!((score("out/calibrated.urdf") - folded).abs() > 0.1, "offsets twice are another arm");
}

/// A simulated log, whose second to eighth columns are the joints, with corrected positions.
fn taken_off(log: &str, offsets: &[f64]) -> String {
    let row = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        for (cell, offset) in cells[1..].iter_mut().zip(offsets) {
            *cell = format!("{:.12}", cell.parse::<f64>().unwrap() - offset);
        }
        cells.join(",") + "\n"
    };
    let (header, rows) = log.split_once('\n').unwrap();
    format!("{header}\n{}", rows.lines().map(row).collect::<String>())
}
