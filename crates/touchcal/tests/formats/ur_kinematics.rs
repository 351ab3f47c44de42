//! Joint origins for the driver of Universal Robots.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use touchcal::estimate::workspace_configurations;
use touchcal::io::ur_kinematics;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{Joint, KinematicParameter, Kinematics, Robot, calibrated};
use touchcal::se3::Pose;

const LINKS: [&str; 6] = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];

fn ur10() -> Robot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/ur10/ur10.urdf");
    urdf::read_file(&path, Ends::default()).unwrap().robot
}

/// The joint origins of the file as a driver reads them: by link and key.
fn read(text: &str) -> HashMap<String, f64> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(lines.next(), Some("kinematics:"));
    let (mut link, mut numbers) = (String::new(), HashMap::new());
    for line in lines {
        let (key, value) = line.trim().split_once(':').unwrap();
        match value.trim().parse() {
            Ok(number) => drop(numbers.insert(format!("{link}.{key}"), number)),
            Err(_) if value.is_empty() => key.clone_into(&mut link),
            Err(_) => assert!(key == "hash" && value.starts_with(" touchcal_"), "{line}"),
        }
    }
    numbers
}

/// Pose of `wrist_3_link` in `base_link` as the driver's description has it: origins by x, y, z,
/// roll, pitch and yaw, all joints about z.
fn described(numbers: &HashMap<String, f64>, q: &[f64]) -> Pose {
    let origin = |link: &str| {
        let [x, y, z, roll, pitch, yaw] =
            ["x", "y", "z", "roll", "pitch", "yaw"].map(|key| numbers[&format!("{link}.{key}")]);
        let about =
            |axis: Vector3<f64>, angle| UnitQuaternion::from_axis_angle(&nalgebra::Unit::new_normalize(axis), angle);
        let turned = about(Vector3::z(), yaw) * about(Vector3::y(), pitch) * about(Vector3::x(), roll);
        Isometry3::from_parts(Translation3::new(x, y, z), turned)
    };
    LINKS.iter().zip(q).fold(Pose::identity(), |base_from_link, (link, &angle)| {
        base_from_link * origin(link) * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
    })
}

/// An arm whose joint origins are all off by millimetres and degrees, and its encoders.
fn moved(robot: &Robot) -> Robot {
    let columns: Vec<KinematicParameter> = (0..6)
        .flat_map(|i| (0..6).map(move |k| KinematicParameter::JointOrigin(i, k)))
        .chain((0..6).map(KinematicParameter::JointOffset))
        .collect();
    let values: Vec<f64> = (0..columns.len()).map(|k| 5e-3 * (1.7 * k as f64).sin()).collect();
    calibrated(robot, &columns, &values)
}

/// This URDF has the flange behind the links of `ur_description`.
const FLANGE: &str =
    "the 92.2 mm of the fixed joint `flange_joint` behind wrist_3, where `ur_description` has its flange";

#[test]
fn the_driver_has_the_calibrated_arm() {
    let nominal = ur10();
    let arm = moved(&nominal);
    let written = ur_kinematics::of(&arm, &nominal).unwrap();
    assert_eq!(written.left_out, [FLANGE]);
    let numbers = read(&written.text);
    assert_eq!(numbers.len(), 36);
    let base_from_flange = Kinematics::new(&arm, &[], Pose::identity());
    let wrist_from_flange = arm.joints().last().unwrap().parent_from_joint;
    let difference = |q: Vec<f64>| {
        let between = (described(&numbers, &q) * wrist_from_flange).inv_mul(&base_from_flange.pose(&q));
        between.translation.vector.norm().max(between.rotation.angle())
    };
    let worst = workspace_configurations(&arm, 1000).into_iter().map(difference);
    let worst = worst.fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst:e}");
    // Another arm has another name.
    let hash = |text: &str| text.lines().last().unwrap().to_owned();
    assert_ne!(hash(&written.text), hash(&ur_kinematics::of(&nominal, &nominal).unwrap().text));
}

#[test]
fn what_the_file_cannot_hold_is_told() {
    let nominal = ur10();
    let strained =
        calibrated(&nominal, &[KinematicParameter::Strain, KinematicParameter::JointCompliance(1)], &[0.01, 1e-6]);
    let written = ur_kinematics::of(&strained, &nominal).unwrap();
    let expected = ["the origin of the fixed joint `flange_joint`, which moved", FLANGE, "joint compliances"];
    assert_eq!(written.left_out, expected);
    assert!(
        written.text.starts_with("# Not in this file: the origin of the fixed joint `flange_joint`, which moved.\n")
    );
    // Names with a prefix are those of the same arm; others are of none.
    let renamed = |name: &dyn Fn(&str) -> String| {
        let rename = |joint: &Joint| Joint { name: name(&joint.name), ..joint.clone() };
        let robot = Robot::new("arm", "base_link", nominal.joints().iter().map(rename).collect()).unwrap();
        ur_kinematics::of(&robot, &robot).map_err(|error| error.to_string())
    };
    assert!(renamed(&|name| format!("left_{name}")).is_ok());
    let found = renamed(&|name| name.replace("elbow", "third")).unwrap_err();
    assert!(
        found.starts_with("arm: expected an arm with the joints shoulder_pan_joint, shoulder_lift_joint, elbow_joint,"),
        "{found}"
    );
    assert!(found.contains("found shoulder_pan_joint, shoulder_lift_joint, third_joint, wrist_1_joint"), "{found}");
    let iiwa = urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot;
    assert!(ur_kinematics::of(&iiwa, &iiwa).is_err());
}
