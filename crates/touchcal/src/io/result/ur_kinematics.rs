//! Joint origins for the ROS 2 driver of Universal Robots: the YAML file that
//! `kinematics_params_file` of its launch files names, which `ur_calibration` otherwise reads from
//! the controller. The keys are those that `urdf/inc/ur_common.xacro` of `ur_description` reads,
//! each the origin of a joint in `urdf/ur_macro.xacro` (Universal Robots, 2024).

use crate::io::base::bytes::sha256;
use crate::io::base::error::{IoError, Place, shown_name};
use crate::io::result::export_text::ExportText;
use crate::io::robot::urdf::{roll_pitch_yaw, written};
use crate::robot::{Joint, JointKind, Robot};
use crate::se3::Pose;

/// The moving joints, base first, and the keys of the links that they carry.
const JOINTS: [(&str, &str); 6] = [
    ("shoulder_pan_joint", "shoulder"),
    ("shoulder_lift_joint", "upper_arm"),
    ("elbow_joint", "forearm"),
    ("wrist_1_joint", "wrist_1"),
    ("wrist_2_joint", "wrist_2"),
    ("wrist_3_joint", "wrist_3"),
];
/// Motion (m, rad) below which a fixed joint is where it was.
const UNCHANGED: f64 = 1e-9;

/// The joint origins of `calibrated`, an arm of Universal Robots whose uncalibrated description is
/// `nominal`: x, y, z (m), roll, pitch and yaw (rad, about fixed axes) of each joint in the frame
/// of the link before it, so that the poses of `wrist_3_link` are those of the calibrated arm, and
/// a name made of them as `hash`. The file lacks fixed joints that moved, lengths behind
/// `wrist_3_link`, and compliances.
///
/// # Errors
/// [`IoError`] if the moving joints are not the six of `ur_description`, whatever the prefix of
/// their names, each about its z axis, one directly after the other.
pub fn of(calibrated: &Robot, nominal: &Robot) -> Result<ExportText, IoError> {
    let joints = arm_joints(calibrated)?;
    let mut origins = String::new();
    for (joint, (_, link)) in joints.iter().zip(JOINTS) {
        let origin = &joint.parent_from_joint;
        let numbers = <[f64; 3]>::from(origin.translation.vector).into_iter().chain(roll_pitch_yaw(&origin.rotation));
        origins.push_str(&format!("  {link}:\n"));
        for (key, number) in ["x", "y", "z", "roll", "pitch", "yaw"].into_iter().zip(numbers) {
            origins.push_str(&format!("    {key}: {}\n", written([number])));
        }
    }
    let left_out = left_out(calibrated, nominal);
    let comments: String = left_out.iter().map(|words| format!("# Not in this file: {words}.\n")).collect();
    let hash = &sha256(&origins)[..16];
    Ok(ExportText { text: format!("{comments}kinematics:\n{origins}  hash: touchcal_{hash}\n"), left_out })
}

/// The six joints of the arm, base first.
fn arm_joints(robot: &Robot) -> Result<&[Joint], IoError> {
    let is_fixed = |joint: &Joint| joint.kind == JointKind::Fixed;
    let first = robot.joints().iter().position(|joint| !is_fixed(joint)).unwrap_or(0);
    let joints = robot.joints().get(first..first + JOINTS.len()).unwrap_or_default();
    let prefix = joints.first().and_then(|joint| joint.name.strip_suffix(JOINTS[0].0));
    let is_named = |(joint, (name, _)): (&Joint, (&str, &str))| joint.name.strip_suffix(name) == prefix;
    let turns = |joint: &Joint| matches!(joint.kind, JointKind::Revolute | JointKind::Continuous);
    let about_z = |joint: &Joint| turns(joint) && joint.axis.xy().norm() < UNCHANGED && joint.axis.z > 0.0;
    let is_arm = prefix.is_some() && joints.iter().zip(JOINTS).all(is_named) && joints.iter().all(about_z);
    if is_arm && robot.dof() == JOINTS.len() {
        return Ok(joints);
    }
    let expected = format!("an arm with the joints {}, each about z", JOINTS.map(|(joint, _)| joint).join(", "));
    let found: Vec<String> = robot.moving().map(|joint| shown_name(&joint.name)).collect();
    Err(IoError::unexpected(Place::file(robot.name()), expected, found.join(", ")))
}

/// What the file cannot hold: fixed joints that moved, lengths behind the last moving joint, and
/// compliances.
fn left_out(calibrated: &Robot, nominal: &Robot) -> Vec<String> {
    let is_moved = |a: &Pose, b: &Pose| {
        let between = a.inv_mul(b);
        between.translation.vector.norm() > UNCHANGED || between.rotation.angle() > UNCHANGED
    };
    let pairs = calibrated.joints().iter().zip(nominal.joints());
    let fixed = pairs.filter(|(joint, _)| joint.kind == JointKind::Fixed);
    let moved = fixed.filter(|(joint, before)| is_moved(&before.parent_from_joint, &joint.parent_from_joint));
    let moved =
        moved.map(|(joint, _)| format!("the origin of the fixed joint `{}`, which moved", shown_name(&joint.name)));
    let last = nominal.joints().iter().rposition(|joint| joint.kind != JointKind::Fixed).unwrap_or(0);
    let behind = nominal.joints().iter().skip(last + 1);
    let long = behind.map(|joint| (joint, 1e3 * joint.parent_from_joint.translation.vector.norm()));
    let long = long.filter(|(_, millimetres)| *millimetres > 1e-3).map(|(joint, millimetres)| {
        let name = shown_name(&joint.name);
        format!(
            "the {millimetres:.1} mm of the fixed joint `{name}` behind wrist_3, where `ur_description` has its flange"
        )
    });
    moved.chain(long).chain(calibrated.is_compliant().then(|| "joint compliances".to_owned())).collect()
}
