//! A URDF as a macro of xacro. `scripts/validate` compares with xacro itself.

use std::path::Path;

use touchcal::estimate::workspace_configurations;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{Kinematics, builtin};
use touchcal::se3::Pose;

/// What a macro with a prefix has to change, and what it must leave.
const CELL: &str = r#"<?xml version="1.0"?>
<!-- ${left} as it is -->
<robot name='two-armed 1'>
  <material name="grey"><color rgba="1 1 1 1"/></material>
  <link name="base"><visual><material name="grey"/></visual><visual><material name=""/></visual></link>
  <link name="tool$${x}"><collision><geometry><mesh filename="package://a$b/$(find x)&#36;{y}.stl"/></geometry></collision></link>
  <link name='finger'/>
  <joint name="a" type="revolute"><parent link="base"/><child link="tool$${x}"/><axis xyz="0 0 1"/></joint>
  <joint name="b" type="prismatic"><parent link="base"/><child link="finger"/><mimic joint="a" multiplier="2"/></joint>
  <transmission name="t"><type>a</type><joint name="a"><hardwareInterface>a</hardwareInterface></joint><actuator name="m"/></transmission>
  <ros2_control name="arm" type="system"><joint name="b"><param name="mimic"> a </param><param name="min">-1</param></joint></ros2_control>
  <gazebo reference="base"><material>Gazebo/Grey</material></gazebo>
  <gazebo><plugin name="p"><body>finger</body><topic>$$x</topic><text><![CDATA[${kept}]]></text></plugin></gazebo>
</robot>
"#;

/// The macro called with a prefix: what the file defines, with `${prefix}` and escapes evaluated
/// as xacro does.
fn expanded(xacro: &str, prefix: &str) -> String {
    let (head, rest) = xacro.split_once("<xacro:macro ").unwrap();
    let (body, tail) = rest.split_once('>').unwrap().1.split_once("</xacro:macro>").unwrap();
    let head = head.replace(" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"", "");
    let body = body.replace("${prefix}", prefix).replace("${&apos;$&apos;}", "&#36;");
    format!("{head}{}{tail}", body.replace("$${", "&#36;{").replace("$$(", "&#36;("))
}

#[test]
fn names_and_references_have_the_prefix() {
    let xacro = urdf::xacro_macro(CELL).unwrap();
    assert!(xacro.contains("<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" name='two-armed 1'>"), "{xacro}");
    assert!(xacro.contains("\n<xacro:macro name=\"two_armed_1\" params=\"prefix:=''\">\n"), "{xacro}");
    let lines: Vec<&str> = xacro.lines().filter(|line| line.starts_with("  ")).collect();
    let expected = [
        r#"  <material name="${prefix}grey"><color rgba="1 1 1 1"/></material>"#,
        r#"  <link name="${prefix}base"><visual><material name="${prefix}grey"/></visual><visual><material name=""/></visual></link>"#,
        r#"  <link name="${prefix}tool$$${x}"><collision><geometry><mesh filename="package://a$b/$$(find x)$${y}.stl"/></geometry></collision></link>"#,
        r#"  <link name='${prefix}finger'/>"#,
        r#"  <joint name="${prefix}a" type="revolute"><parent link="${prefix}base"/><child link="${prefix}tool$$${x}"/><axis xyz="0 0 1"/></joint>"#,
        r#"  <joint name="${prefix}b" type="prismatic"><parent link="${prefix}base"/><child link="${prefix}finger"/><mimic joint="${prefix}a" multiplier="2"/></joint>"#,
        r#"  <transmission name="${prefix}t"><type>a</type><joint name="${prefix}a"><hardwareInterface>a</hardwareInterface></joint><actuator name="${prefix}m"/></transmission>"#,
        r#"  <ros2_control name="${prefix}arm" type="system"><joint name="${prefix}b"><param name="mimic"> ${prefix}a </param><param name="min">-1</param></joint></ros2_control>"#,
        r#"  <gazebo reference="${prefix}base"><material>Gazebo/Grey</material></gazebo>"#,
        r#"  <gazebo><plugin name="p"><body>${prefix}finger</body><topic>${&apos;$&apos;}$x</topic><text><![CDATA[${kept}]]></text></plugin></gazebo>"#,
    ];
    assert_eq!(lines, expected);
    // Plain URDF only.
    assert!(urdf::xacro_macro(&xacro).unwrap_err().to_string().contains("xacro, which must be expanded first"));
}

#[test]
fn names_of_macros_are_valid() {
    let name = |robot: &str| {
        let text = format!("<robot name='{robot}'><link name='a'/></robot>");
        let xacro = urdf::xacro_macro(&text).unwrap();
        xacro.split("<xacro:macro name=\"").nth(1).unwrap().split('"').next().unwrap().to_owned()
    };
    for (robot, expected) in [
        ("ur10", "ur10"),
        ("lbr-iiwa.14", "lbr_iiwa_14"),
        ("7dof", "robot_7dof"),
        ("call", "robot_call"),
        ("", "robot_"),
    ] {
        assert_eq!(name(robot), expected);
    }
}

#[test]
fn an_expanded_macro_is_the_arm() {
    let ur10 = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/ur10/ur10.urdf");
    let ur10 = std::fs::read_to_string(ur10).unwrap();
    for text in [builtin::IIWA14, builtin::PANDA, &ur10, CELL] {
        let ends = if text == CELL { ["base", "tool$${x}"].map(Some) } else { [None, None] };
        let arm = urdf::read(text, "arm.urdf", Ends { base: ends[0], tip: ends[1] }).unwrap();
        let xacro = urdf::xacro_macro(text).unwrap();
        let [base, tip] = [arm.base(), arm.tip()].map(|link| format!("left_{link}"));
        let ends = Ends { base: Some(&base), tip: Some(&tip) };
        let left = urdf::read(&expanded(&xacro, "left_"), "left.urdf", ends).unwrap();
        let names =
            |joints: &[touchcal::robot::Joint]| joints.iter().map(|joint| joint.name.clone()).collect::<Vec<_>>();
        let expected: Vec<String> = names(arm.joints()).iter().map(|name| format!("left_{name}")).collect();
        assert_eq!(names(left.joints()), expected);
        let [a, b] = [&arm, &left].map(|robot| Kinematics::new(robot, &[], Pose::identity()));
        assert!(workspace_configurations(&arm, 1000).iter().all(|q| a.pose(q) == b.pose(q)));
        // Without a prefix it is the text that it was made of.
        let without = expanded(&xacro, "");
        let as_read = urdf::read(&without, "arm.urdf", Ends { base: Some(arm.base()), tip: Some(arm.tip()) }).unwrap();
        assert_eq!(as_read.joints(), arm.joints());
    }
}
