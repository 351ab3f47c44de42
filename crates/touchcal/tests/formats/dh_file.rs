//! Denavit–Hartenberg parameters: the poses of the arm from the numbers of the file alone.

use std::path::Path;

use nalgebra::{Matrix4, Rotation3, Translation3, Vector3};
use serde_json::Value;
use touchcal::estimate::workspace_configurations;
use touchcal::io::dh_file;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{KinematicParameter, Kinematics, Robot, calibrated};
use touchcal::se3::Pose;

/// An arm whose second axis slides across, and whose third slides along the fourth: joints with
/// offsets, axes in all directions, the tip beside the last axis.
const SLIDING: &str = "<robot name='sliding'><link name='b'/><link name='l1'/><link name='l2'/><link name='l3'/><link name='l4'/><link name='t'/>\
  <joint name='j1' type='revolute'><origin xyz='0.1 -0.2 0.3' rpy='0.3 -0.2 0.5'/><parent link='b'/><child link='l1'/><axis xyz='1 2 -1'/></joint>\
  <joint name='j2' type='prismatic'><origin xyz='0.2 0.1 0.4' rpy='1.1 0 0.7'/><parent link='l1'/><child link='l2'/><axis xyz='0 1 0'/></joint>\
  <joint name='j3' type='prismatic'><origin xyz='0 0.3 0.1' rpy='0 1.5 0'/><parent link='l2'/><child link='l3'/></joint>\
  <joint name='j4' type='continuous'><origin xyz='0.4 0.2 0' rpy='0.1 0.02 0.03'/><parent link='l3'/><child link='l4'/></joint>\
  <joint name='end' type='fixed'><origin xyz='0.1 0.2 0.3' rpy='1 2 3'/><parent link='l4'/><child link='t'/></joint></robot>";
/// A selectively compliant arm: all axes are parallel, two of them the same.
const SCARA: &str = "<robot name='scara'><link name='b'/><link name='l1'/><link name='l2'/><link name='l3'/><link name='t'/>\
  <joint name='j1' type='revolute'><origin xyz='0 0 0.4'/><parent link='b'/><child link='l1'/><axis xyz='0 0 1'/></joint>\
  <joint name='j2' type='revolute'><origin xyz='0.3 0 0'/><parent link='l1'/><child link='l2'/><axis xyz='0 0 1'/></joint>\
  <joint name='j3' type='revolute'><origin xyz='0.25 0 0'/><parent link='l2'/><child link='l3'/><axis xyz='0 0 -1'/></joint>\
  <joint name='j4' type='prismatic'><parent link='l3'/><child link='t'/><axis xyz='0 0 -1'/></joint></robot>";

fn ur10() -> Robot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/ur10/ur10.urdf");
    urdf::read_file(&path, Ends::default()).unwrap().robot
}

fn iiwa() -> Robot {
    urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot
}

fn read(text: &str) -> Robot {
    urdf::read(text, "arm.urdf", Ends::default()).unwrap()
}

/// The arm with all joint origins and encoders off by up to `size` (m, rad).
fn moved(robot: &Robot, size: f64) -> Robot {
    let columns: Vec<KinematicParameter> = (0..robot.dof())
        .flat_map(|i| (0..6).map(move |k| KinematicParameter::JointOrigin(i, k)))
        .chain((0..robot.dof()).map(KinematicParameter::JointOffset))
        .collect();
    let values: Vec<f64> = (0..columns.len()).map(|k| size * (1.7 * k as f64).sin()).collect();
    calibrated(robot, &columns, &values)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn translated(x: f64, y: f64, z: f64) -> Matrix4<f64> {
    Translation3::new(x, y, z).to_homogeneous()
}

fn turned(axis: usize, angle_deg: f64) -> Matrix4<f64> {
    let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
    Rotation3::from_axis_angle(&axes[axis], angle_deg.to_radians()).to_homogeneous()
}

fn transform(entry: &Value) -> Matrix4<f64> {
    let [x, y, z] = [0, 1, 2].map(|k| 1e-3 * number(&entry["xyz_mm"][k]));
    let [roll, pitch, yaw] = [0, 1, 2].map(|k| number(&entry["roll_pitch_yaw_deg"][k]));
    translated(x, y, z) * turned(2, yaw) * turned(1, pitch) * turned(0, roll)
}

/// Pose of the tip in the base as the file has it, by one of its conventions.
fn described(file: &Value, convention: &str, q: &[f64]) -> Matrix4<f64> {
    let link = |(row, &position): (&Value, &f64)| {
        let (theta, d) = (number(&row["theta_offset_deg"]), 1e-3 * number(&row["d_offset_mm"]));
        let (theta, d) = match row["kind"].as_str().unwrap() {
            "revolute" => (theta + position.to_degrees(), d),
            "prismatic" => (theta, d + position),
            other => panic!("{other}"),
        };
        let about_z = turned(2, theta) * translated(0.0, 0.0, d);
        let about_x = translated(1e-3 * number(&row["a_mm"]), 0.0, 0.0)
            * turned(0, number(&row["alpha_deg"]))
            * turned(1, number(&row["beta_deg"]));
        if convention == "standard" { about_z * about_x } else { about_x * about_z }
    };
    let rows = file[convention].as_array().unwrap();
    assert_eq!(rows.len(), q.len());
    let links = rows.iter().zip(q).map(link).fold(Matrix4::identity(), |product, link| product * link);
    transform(&file["base_from_dh_base"]) * links * transform(&file["dh_last_from_tip"])
}

/// The file of an arm, after its poses were compared with the arm's.
#[track_caller]
fn checked(robot: &Robot) -> Value {
    let file: Value = serde_json::from_str(&dh_file::of(robot).text).unwrap();
    let base_from_tip = Kinematics::new(robot, &[], Pose::identity());
    for convention in ["standard", "modified"] {
        let difference = |q: Vec<f64>| {
            let expected = base_from_tip.pose(&q).to_homogeneous();
            // Of a rotation matrix the entries differ by no more than the angle (rad).
            (described(&file, convention, &q) - expected).amax()
        };
        let worst = workspace_configurations(robot, 1000).into_iter().map(difference).fold(0.0, f64::max);
        // Seven joints with numbers that are rounded to 1e-10 mm and 1e-10 degrees.
        assert!(worst < 1e-10, "{} {convention}: {worst:e}", robot.name());
    }
    file
}

fn column(file: &Value, convention: &str, key: &str) -> Vec<f64> {
    file[convention].as_array().unwrap().iter().map(|row| number(&row[key])).collect()
}

#[test]
fn the_file_has_the_poses_of_the_arm() {
    for nominal in [iiwa(), ur10(), read(SLIDING), read(SCARA)] {
        checked(&nominal);
        for size in [1e-6, 1e-4, 5e-3, 0.1] {
            let file = checked(&moved(&nominal, size));
            // Nothing is far away: plain parameters of parallel axes would be.
            let largest = ["d_offset_mm", "a_mm"].map(|key| column(&file, "standard", key)).concat();
            assert!(largest.iter().all(|length| length.abs() < 3e3), "{}: {largest:?}", nominal.name());
        }
    }
}

#[test]
fn nominal_arms_have_the_numbers_of_their_makers() {
    let file = checked(&iiwa());
    assert_eq!(column(&file, "standard", "d_offset_mm"), [360.0, 0.0, 420.0, 0.0, 400.0, 0.0, 126.0]);
    assert_eq!(column(&file, "standard", "a_mm"), [0.0; 7]);
    assert_eq!(column(&file, "standard", "beta_deg"), [0.0; 7]);
    assert!(column(&file, "standard", "alpha_deg")[..6].iter().all(|alpha| alpha.abs() == 90.0));
    assert_eq!(file["nearly_parallel_axes"].as_array().unwrap().len(), 0);
    // Universal Robots, DH parameters for calculations of kinematics and dynamics: UR10.
    let file = checked(&ur10());
    assert_eq!(column(&file, "standard", "theta_offset_deg"), [0.0; 6]);
    assert_eq!(column(&file, "standard", "d_offset_mm"), [127.3, 0.0, 0.0, 163.941, 115.7, 92.2]);
    assert_eq!(column(&file, "standard", "a_mm"), [0.0, -612.0, -572.3, 0.0, 0.0, 0.0]);
    assert_eq!(column(&file, "standard", "alpha_deg"), [90.0, 0.0, 0.0, 90.0, -90.0, 0.0]);
    assert_eq!(column(&file, "modified", "alpha_deg"), [0.0, 90.0, 0.0, 0.0, 90.0, -90.0]);
    assert_eq!(column(&file, "modified", "a_mm"), [0.0, 0.0, -612.0, -572.3, 0.0, 0.0]);
    let parallel = serde_json::json!([["shoulder_lift_joint", "elbow_joint"], ["elbow_joint", "wrist_1_joint"]]);
    assert_eq!(file["nearly_parallel_axes"], parallel);
    for end in ["base_from_dh_base", "dh_last_from_tip"] {
        assert!((transform(&file[end]) - Matrix4::identity()).amax() < 1e-15, "{end}: {}", file[end]);
    }
}

#[test]
fn a_calibrated_arm_has_numbers_near_those_of_the_nominal_one() {
    for nominal in [iiwa(), ur10()] {
        let (before, after) = (checked(&nominal), checked(&moved(&nominal, 1e-3)));
        for (key, most) in [("theta_offset_deg", 1.0), ("a_mm", 10.0), ("alpha_deg", 1.0), ("beta_deg", 1.0)] {
            let pairs = column(&before, "standard", key).into_iter().zip(column(&after, "standard", key));
            let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < most && apart > 0.0 || key == "beta_deg", "{} {key}: {apart}", nominal.name());
        }
    }
    // beta takes the place of d at parallel axes, and nowhere else.
    let file = checked(&moved(&ur10(), 1e-3));
    let of = |key| column(&file, "standard", key);
    assert!(of("beta_deg").iter().enumerate().all(|(k, beta)| (*beta != 0.0) == [1, 2].contains(&k)), "{file}");
    assert!(of("d_offset_mm").iter().enumerate().all(|(k, d)| (*d == 0.0) == [1, 2].contains(&k)), "{file}");
}

#[test]
fn what_the_file_lacks_is_told() {
    let soft = calibrated(&iiwa(), &[KinematicParameter::JointCompliance(1)], &[1e-6]);
    let written = dh_file::of(&soft);
    assert_eq!(written.left_out, ["joint compliances"]);
    let file: Value = serde_json::from_str(&written.text).unwrap();
    assert_eq!(file["not_in_this_file"][0], "joint compliances");
    assert_eq!(dh_file::of(&iiwa()).left_out, [""; 0]);
    // A line for each joint, with units in the names of the keys.
    let first = written.text.lines().find(|line| line.contains("\"joint\": ")).unwrap();
    assert_eq!(
        first.trim(),
        r#"{"joint": "joint_a1", "kind": "revolute", "theta_offset_deg": 0.0, "d_offset_mm": 360.0, "a_mm": 0.0, "alpha_deg": -90.0, "beta_deg": 0.0},"#
    );
}
