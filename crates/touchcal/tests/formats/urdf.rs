//! URDF: chains read, bad input refused, calibrated origins written back in place.

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{JointKind, KinematicParameter, Robot, calibrated};
use touchcal::se3::Pose;

const ARM: &str = "<?xml version=\"1.0\"?>\r\n<robot name='arm'>\r\n\t<!-- a comment with <origin xyz=\"9 9 9\"/> -->\r\n\
  <link name=\"base\"/><link name=\"l1\"/><link name=\"l2\"/><link name=\"hand\"/>\r\n\
  <joint type=\"revolute\" name=\"a1\">\r\n    <parent link=\"base\"/>\r\n    <child link=\"l1\"/>\r\n    <origin rpy='0.1 1.5707963267948966 0'  xyz = \"0 0 0.36\" />\r\n\
    <axis xyz=\"0 0 2\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/>\r\n  </joint>\r\n\
  <joint name=\"a2\" type=\"continuous\">\r\n    <origin/>\r\n    <parent link=\"l1\"/><child link=\"l2\"/>\r\n  </joint>\r\n\
  <joint name=\"a3\" type=\"prismatic\">\r\n    <parent link=\"l2\"/>\r\n    <child link=\"hand\"/><axis xyz=\"0 1 0\"/>\r\n  </joint>\r\n\
  <gazebo><joint name=\"a1\"/></gazebo>\r\n</robot>\r\n";

fn arm() -> Robot {
    urdf::read(ARM, "arm.urdf", Ends::default()).unwrap()
}

fn error(text: &str) -> String {
    error_between(text, None, None)
}

fn error_between(text: &str, base: Option<&str>, tip: Option<&str>) -> String {
    urdf::read(text, "arm.urdf", Ends { base, tip }).unwrap_err().to_string()
}

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "expected `{part}` in: {message}");
    }
}

fn distance(a: &Robot, b: &Robot) -> f64 {
    let pairs = a.joints().iter().zip(b.joints());
    let each = pairs.map(|(a, b)| {
        let (a, b) = (a.parent_from_joint, b.parent_from_joint);
        let turned = a.rotation.to_rotation_matrix().matrix() - b.rotation.to_rotation_matrix().matrix();
        (a.translation.vector - b.translation.vector).norm() + turned.norm()
    });
    each.fold(0.0, f64::max)
}

#[test]
fn chain_with_defaults_is_read() {
    let robot = arm();
    let kinds: Vec<JointKind> = robot.joints().iter().map(|joint| joint.kind).collect();
    assert_eq!(kinds, [JointKind::Revolute, JointKind::Continuous, JointKind::Prismatic]);
    assert_eq!((robot.name(), robot.base(), robot.tip()), ("arm", "base", "hand"));
    let [a1, a2, a3] = robot.joints() else { panic!() };
    assert_eq!(a1.axis, Vector3::z_axis());
    assert_eq!(a1.limits.map(|limits| (limits.lower, limits.upper)), Some((-2.0, 2.0)));
    assert_eq!(a2.axis, Vector3::x_axis());
    assert_eq!(a2.parent_from_joint, Pose::identity());
    assert_eq!((a2.limits, a3.limits), (None, None));
    let part = urdf::read(ARM, "arm.urdf", Ends { base: Some("l1"), tip: Some("l2") }).unwrap();
    assert_eq!((part.base(), part.tip(), part.dof()), ("l1", "l2", 1));
}

#[test]
fn builtin_arms_end_at_their_flange() {
    assert_eq!(urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot.tip(), "flange");
    let panda = urdf::read_builtin("panda", Ends::default()).unwrap();
    assert_eq!((panda.robot.dof(), panda.robot.tip()), (7, "panda_link8"));
    let message = urdf::read_builtin("pandaa", Ends::default()).unwrap_err().to_string();
    assert_says(&message, &["`iiwa14` or `panda`", "did you mean `panda`?"]);
}

#[test]
fn malformed_text_is_refused_with_its_place() {
    assert_says(&error("<robot>\n <link name='a'>\n</robot>"), &["arm.urdf:3:", "not well-formed XML"]);
    assert_says(&error(""), &["arm.urdf"]);
    assert_says(&error("<sdf/>"), &["arm.urdf:1:1", "<robot>", "found <sdf>"]);
    assert_says(&error("<!DOCTYPE x [<!ENTITY a 'b'>]><robot>&a;</robot>"), &["arm.urdf", "not well-formed XML"]);
    let latin = urdf::read_bytes(b"<robot>\n\xe9</robot>", "arm.urdf", Ends::default()).unwrap_err().to_string();
    assert_says(&latin, &["arm.urdf:2", "expected UTF-8 text", "byte 0xe9"]);
    assert_says(&error("<robot/>"), &["links and joints", "no link"]);
}

#[test]
fn xacro_is_refused_with_the_command_that_expands_it() {
    let expand = "run `xacro file.xacro > file.urdf`";
    assert_says(&error("<robot>\n<xacro:include filename='a'/></robot>"), &["arm.urdf:2:2", expand]);
    let declared = "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'>\n <xacro:arm/></robot>";
    assert_says(&error(declared), &["arm.urdf:2:2", expand]);
    assert_says(&error(&ARM.replace("0 0 0.36", "0 0 ${h}")), &["joint `a1`, origin", "${h}", expand]);
    // Output of xacro may keep the declaration; that alone is no xacro.
    let kept = ARM.replace("<robot name", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro' name");
    assert!(urdf::read(&kept, "arm.urdf", Ends::default()).is_ok());
}

#[test]
fn bad_values_are_refused_with_joint_and_field() {
    let cases = [
        ("0 0 0.36", "0 0", vec!["arm.urdf:8:5", "joint `a1`, origin", "3 finite numbers in `xyz`", "found \"0 0\""]),
        ("0 0 0.36", "0 0 1 2", vec!["3 finite numbers in `xyz`"]),
        ("0 0 0.36", "0 0 NaN", vec!["found \"0 0 NaN\""]),
        ("0 0 0.36", "0 0 1e999", vec!["found \"0 0 1e999\""]),
        ("0 0 0.36", "0 0 1e300", vec!["joint `a1`, origin", "numbers within ±1000 in `xyz`", "found \"0 0 1e300\""]),
        ("name=\"a2\"", "name=\"a2&#10;\"", vec!["attribute `name` of <joint> without control characters", "'\\n'"]),
        ("0 0 2", "0 0 0", vec!["joint `a1`", "an axis with a direction", "found \"0 0 0\""]),
        (
            "continuous",
            "floating",
            vec!["joint `a2`", "`revolute`, `continuous`, `prismatic` or `fixed`", "\"floating\""],
        ),
        ("continuous", "planar", vec!["\"planar\""]),
        ("lower=\"-2\"", "lower=\"3\"", vec!["joint `a1`", "lower limit ≤ upper limit", "3 and 2"]),
        ("lower=\"-2\"", "lower=\"x\"", vec!["a finite number in `lower`", "found \"x\""]),
        ("<axis xyz=\"0 1 0\"/>", "<mimic joint=\"a1\"/>", vec!["joint `a3`", "a <mimic> joint"]),
        ("name=\"a2\" ", "", vec!["attribute `name` of <joint>"]),
        ("type=\"revolute\" ", "", vec!["attribute `type` of <joint>"]),
        ("name=\"a2\"", "name=\"a1\"", vec!["distinct joint names", "`a1` twice"]),
        ("<link name=\"l2\"/>", "<link name=\"l1\"/>", vec!["distinct link names", "`l1` twice"]),
        ("<child link=\"hand\"/>", "", vec!["joint `a3`", "a <child link=\"…\"/>"]),
        ("<child link=\"hand\"/>", "<child link=\"hnd\"/>", vec!["joint `a3`", "`hnd`; did you mean `hand`?"]),
        ("<child link=\"hand\"/>", "<child link=\"l1\"/>", vec!["child of one joint", "`l1` below both `a1` and `a3`"]),
        ("<parent link=\"base\"/>", "<parent link=\"hand\"/>", vec!["a chain of joints below base link `base`"]),
    ];
    for (from, to, parts) in cases {
        assert!(ARM.contains(from), "{from}");
        assert_says(&error(&ARM.replace(from, to)), &parts);
    }
}

#[test]
fn ends_that_do_not_fit_are_refused() {
    assert_says(&error_between(ARM, Some("bse"), None), &["base link", "`bse`; did you mean `base`?"]);
    assert_says(
        &error_between(ARM, None, Some("tool0")),
        &["tip link", "a link (`base`, `l1`, `l2` or `hand`)", "`tool0`"],
    );
    assert_says(&error_between(ARM, Some("hand"), Some("base")), &["tip link `base` to hang below base link `hand`"]);
    assert_says(&error_between(ARM, Some("l1"), Some("l1")), &["the same link"]);
    let forked = ARM.replace("<parent link=\"l2\"/>", "<parent link=\"l1\"/>");
    assert_says(
        &error(&forked),
        &["one leaf link below `base`", "`l2` or `hand`, which branch at `l1`", "choose one of these as `tip`"],
    );
    // A fork at the base is no tip.
    let forked = ARM.replace("<parent link=\"l2\"/>", "<parent link=\"base\"/>");
    assert_says(&error(&forked), &["one leaf link below `base`", "`l2` or `hand`; choose one as `tip`"]);
    let split = ARM.replace("<link name=\"base\"/>", "<link name=\"base\"/><link name=\"world\"/>");
    assert_says(&error(&split), &["one root link", "not connected", "`base` or `world`"]);
    let fixed = "<robot><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint></robot>";
    assert_says(&error(fixed), &["arm.urdf", "at least one moving joint"]);
    let ring = "<robot><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\
                <joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint></robot>";
    assert_says(&error(ring), &["one root link", "a closed loop"]);
    assert_says(&error_between(ring, Some("a"), None), &["a chain of joints below base link `a`"]);
}

#[test]
fn very_long_chains_are_refused_and_quickly() {
    let links: String = (0..20_000).map(|i| format!("<link name='l{i}'/>")).collect();
    let joints: String = (1..20_000)
        .map(|i| format!("<joint name='j{i}' type='revolute'><parent link='l{}'/><child link='l{i}'/></joint>", i - 1))
        .collect();
    assert_says(&error(&format!("<robot>{links}{joints}</robot>")), &["at most 1000 joints"]);
    let deep = format!("<robot>{}{}</robot>", "<a>".repeat(100_000), "</a>".repeat(100_000));
    assert_says(&error(&deep), &["at most 200 elements within each other"]);
    let many: String = (0..100_000).map(|k| format!(" a{k}='1'")).collect();
    assert_says(&error(&format!("<robot{many}/>")), &["at most 1000 attributes of an element"]);
}

#[test]
fn unchanged_robot_leaves_every_byte() {
    assert_eq!(urdf::rewrite(ARM, &arm()).unwrap(), ARM);
    for (_, text) in touchcal::robot::builtin::ALL {
        let robot = urdf::read(text, "builtin", Ends::default()).unwrap();
        let same = calibrated(&robot, &[KinematicParameter::Strain, KinematicParameter::JointOffset(2)], &[0.0, 0.0]);
        assert_eq!(urdf::rewrite(text, &same).unwrap(), text);
    }
}

#[test]
fn only_the_changed_values_are_edited() {
    let raised = calibrated(&arm(), &[KinematicParameter::Strain], &[0.5]);
    assert_eq!(urdf::rewrite(ARM, &raised).unwrap(), ARM.replace("0 0 0.36", "0 0 0.54"));
    let turned = calibrated(&arm(), &[KinematicParameter::JointOffset(1)], &[0.25]);
    assert_eq!(urdf::rewrite(ARM, &turned).unwrap(), ARM.replace("<origin/>", "<origin rpy=\"-0.25 0 0\"/>"));
    let slid = calibrated(&arm(), &[KinematicParameter::JointOffset(2)], &[0.125]);
    let inserted = "<origin xyz=\"0 -0.125 0\"/>\r\n    <parent link=\"l2\"/>";
    assert_eq!(urdf::rewrite(ARM, &slid).unwrap(), ARM.replace("<parent link=\"l2\"/>", inserted));
}

/// `<calibration>` says at which position a reference switch is: the maker's, and for drivers that
/// home.
#[test]
fn calibration_elements_are_left_alone() {
    let text = ARM.replace("<origin/>", "<origin/><calibration rising=\"0.5\"/>");
    let columns: Vec<KinematicParameter> = (0..3).map(KinematicParameter::JointOffset).collect();
    let written = urdf::rewrite(&text, &calibrated(&arm(), &columns, &[0.1, 0.25, 0.2])).unwrap();
    assert!(written.contains("<origin rpy=\"-0.25 0 0\"/><calibration rising=\"0.5\"/>"), "{written}");
}

#[test]
fn byte_order_mark_and_wide_blanks_survive() {
    let wide = format!("\u{feff}{}", ARM.replace("xyz = \"0 0 0.36\"", &format!("xyz={}'0 0 0.36'", " ".repeat(400))));
    let raised = calibrated(&arm(), &[KinematicParameter::Strain], &[0.5]);
    assert_eq!(urdf::rewrite(&wide, &raised).unwrap(), wide.replace("0 0 0.36", "0 0 0.54"));
}

#[test]
fn other_text_is_refused_for_writing() {
    let message = urdf::rewrite(&ARM.replace("\"a3\"", "\"b3\""), &arm()).unwrap_err().to_string();
    assert_says(&message, &["joint `a3` with child link `hand`", "not the text this robot was read from"]);
    assert!(urdf::rewrite("<robot", &arm()).is_err());
}

fn any_columns() -> Vec<KinematicParameter> {
    let origins = (0..3).flat_map(|i| (0..6).map(move |k| KinematicParameter::JointOrigin(i, k)));
    origins.chain((0..3).map(KinematicParameter::JointOffset)).chain([KinematicParameter::Strain]).collect()
}

proptest! {
    #[test]
    fn rewritten_text_reads_back_as_the_same_robot(theta in prop::collection::vec(-3.0..3.0f64, 22), lock in any::<bool>()) {
        let mut theta = theta;
        if lock {
            // Pitch of ±90° at joint a2.
            theta[6..18].fill(0.0);
            theta[10] = std::f64::consts::FRAC_PI_2 * theta[0].signum();
        }
        let robot = calibrated(&arm(), &any_columns(), &theta);
        let text = urdf::rewrite(ARM, &robot).unwrap();
        let back = urdf::read(&text, "arm.urdf", Ends::default()).unwrap();
        prop_assert!(distance(&robot, &back) < 1e-12, "{}", distance(&robot, &back));
        prop_assert_eq!(urdf::rewrite(&text, &back).unwrap(), text);
    }

    #[test]
    fn any_bytes_are_answered(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = urdf::read_bytes(&bytes, "x", Ends::default());
    }

    #[test]
    fn mutated_text_is_answered(at in 0..ARM.len(), cut in 0..40usize, with in "[<>/=\"' a-z0-9.\\-&;]{0,6}") {
        let mut bytes = ARM.as_bytes().to_vec();
        bytes.splice(at..(at + cut).min(ARM.len()), with.bytes());
        if let Ok(robot) = urdf::read_bytes(&bytes, "x", Ends::default()) {
            let text = String::from_utf8(bytes).unwrap();
            let columns = [KinematicParameter::Strain, KinematicParameter::JointOffset(0)];
            let changed = calibrated(&robot, &columns, &[0.01, 0.02]);
            let again = urdf::read(&urdf::rewrite(&text, &changed).unwrap(), "x", Ends::default()).unwrap();
            prop_assert!(distance(&changed, &again) < 1e-9 * (1.0 + distance(&changed, &robot)).max(1e3));
        }
    }
}

#[test]
fn quaternion_of_read_origin_is_fixed_axis() {
    let a1 = arm().joints()[0].parent_from_joint.rotation;
    let expected = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2)
        * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.1);
    assert!(a1.angle_to(&expected) < 1e-7);
}
