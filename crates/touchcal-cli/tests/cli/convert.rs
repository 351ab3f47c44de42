//! `convert`, and `calibrate --mcap`.

use super::new::filled_in;
use super::{errors, json, stderr, stdout, touchcal};

/// Rows of a table as text, without its header.
fn rows(text: &str) -> Vec<Vec<f64>> {
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

#[test]
fn a_recorders_log_becomes_ours_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let names: Vec<String> = (0..7).map(|k| format!("axisQMsr_LBR_iiwa_14_R820_1[{k}]")).collect();
    let header = format!("%ZeitInSec {} cartForce1_X cartForce1_Y cartForce1_Z", names.join(" "));
    let row = |i: i32| (0..7).map(move |k| f64::from(i * 7 + k) * 0.5 - 40.0);
    let line = |i: i32| row(i).map(|q| q.to_string()).collect::<Vec<_>>().join(" ");
    let lines: Vec<String> = (0..20).map(|i| format!("{} {} {i} -1.5 0.25", f64::from(i) * 0.01, line(i))).collect();
    std::fs::write(at("kuka.log"), format!("{header}\n{}\n", lines.join("\n"))).unwrap();
    let convert = |from: &str, to: &str| touchcal(folder.path(), &["convert", from, "--urdf", "iiwa14", "--out", to]);

    let done = convert("kuka.log", "a.csv").success();
    assert!(stdout(&done).starts_with("a.csv: 20 rows of joint_a1, joint_a2, "), "{}", stdout(&done));
    let said = stderr(&done);
    assert!(said.contains("touchcal: note: kuka.log: the unit of angles is not declared: taken as DEGREES"), "{said}");
    let first = std::fs::read_to_string(at("a.csv")).unwrap();
    assert!(first.starts_with("joint_a1,joint_a2,joint_a3,joint_a4,joint_a5,joint_a6,joint_a7,fx,fy,fz\n"));
    for (i, values) in (0..).zip(rows(&first)) {
        assert!(row(i).zip(&values).all(|(deg, rad)| (deg.to_radians() - rad).abs() < 1e-15));
        assert_eq!(values[7..], [f64::from(i), -1.5, 0.25]);
    }
    // From each format to the next, and back to the same bytes, without a note: radians are ours.
    for (from, to) in [("a.csv", "b.parquet"), ("b.parquet", "c.csv.gz"), ("c.csv.gz", "d.csv")] {
        assert_eq!(errors(&convert(from, to).success()), "", "{to}");
    }
    assert_eq!(std::fs::read_to_string(at("d.csv")).unwrap(), first);

    let refused = convert("a.csv", "a.xlsx").code(1);
    let said = stderr(&refused);
    assert!(said.contains("a.xlsx: expected a name that ends in .csv, .csv.gz or .parquet"), "{said}");
    assert!(!at("a.xlsx").exists());
}

#[test]
fn a_calibration_is_written_for_viewers_and_read_as_a_log() {
    let folder = filled_in("planes", &["planes.toml"]);
    let at = |name: &str| folder.path().join(name);
    let args = ["calibrate", "planes/problem.toml", "--out", "out", "--mcap"];
    assert!(
        stdout(&touchcal(folder.path(), &args).success()).contains("out/calibration.mcap, for Foxglove or Rerun\n")
    );
    let args = ["convert", "out/calibration.mcap", "--urdf", "out/calibrated.urdf", "--out", "joints.csv"];
    touchcal(folder.path(), &args).success();
    let drawn = rows(&std::fs::read_to_string(at("joints.csv")).unwrap());
    let read = json(&at("out/estimate.json"))["contacts"]["read"].as_u64().unwrap() as usize;
    assert!(!drawn.is_empty() && drawn.len() <= read.min(3000) && drawn.iter().all(|q| q.len() == 7));
}

/// Columns of joint torques, as they are; where one of a joint is missing, none is taken.
#[test]
fn joint_torques_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let names = |before: &str| (1..=7).map(|k| format!("{before}{k}")).collect::<Vec<String>>().join(",");
    let row = |i: i32| (0..14).map(|k| format!("{}", f64::from(i * 14 + k) * 1e-3)).collect::<Vec<String>>().join(",");
    let log: String = (0..5).map(|i| row(i) + "\n").collect();
    std::fs::write(at("log.csv"), format!("{},{}\n{log}", names("q"), names("tau_"))).unwrap();
    let convert = |from: &str, to: &str| touchcal(folder.path(), &["convert", from, "--urdf", "iiwa14", "--out", to]);
    let said = stdout(&convert("log.csv", "a.csv").success());
    assert!(said.ends_with("joint_a7, tau_joint_a1, tau_joint_a2, tau_joint_a3, tau_joint_a4, tau_joint_a5, tau_joint_a6, tau_joint_a7\n"), "{said}");
    convert("a.csv", "b.parquet").success();
    convert("b.parquet", "c.csv").success();
    let [first, last] = ["a.csv", "c.csv"].map(|name| std::fs::read_to_string(at(name)).unwrap());
    assert_eq!(first, last);
    for (i, values) in (0..).zip(rows(&first)) {
        let expected: Vec<f64> = (0..14).map(|k| f64::from(i * 14 + k) * 1e-3).collect();
        assert_eq!(values, expected);
    }
    std::fs::write(at("few.csv"), format!("{},{}\n{log}", names("q"), names("tau_").replace("tau_7", "other")))
        .unwrap();
    let said = stdout(&convert("few.csv", "d.csv").success());
    assert!(said.ends_with("joint_a6, joint_a7\n"), "{said}");
}
