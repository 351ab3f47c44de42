//! A calibrated chain written into the text it was read from.

use nalgebra::UnitQuaternion;
use roxmltree::Node;

use super::document::{child, children, parse, place, robot_element};
use super::edit::{Edit, FILE, apply, name_end, slice, value_range};
use super::numbers::{roll_pitch_yaw, written};
use super::read::origin;
use super::weight::{
    BACKLASH, COMPLIANCE, HALF, MEASURED, RAD_PER_NM, TORQUE, backlash, compliance, has_measured_torque,
};
use crate::io::base::error::{IoError, Place};
use crate::robot::{Joint, Robot};
use crate::se3::Pose;

/// Origins that differ by less (m, rad) from what the text says are left as they are written.
const UNCHANGED: f64 = 1e-13;

/// The URDF `text` with the joint origins (m, rad), compliances (rad/(N m)) and backlashes (rad, m)
/// of `calibrated`, which was read from this text. Masses, axes and limits are left as the text has
/// them.
///
/// For every joint whose origin differs from the text by more than 10⁻¹³ (m, rad), the values of
/// `xyz` and `rpy` (roll, pitch and yaw about fixed axes) are replaced, or added where absent; so
/// are `<touchcal_compliance rad_per_nm="…"/>` and `<touchcal_backlash half="…"/>` where they
/// differ, with `torque="measured"` where the arm's torques are measured. Every other byte stays as
/// it is. Numbers are written with all their digits; origins below 10⁻¹⁵ as 0.
///
/// # Errors
/// [`IoError`] if the text is no URDF, has unexpanded xacro, lacks a joint of the chain with its
/// child link, or has a malformed origin, compliance or backlash there.
pub fn rewrite(text: &str, calibrated: &Robot) -> Result<String, IoError> {
    let document = parse(text, FILE)?;
    let robot = robot_element(&document, FILE)?;
    let mut edits = Vec::new();
    for joint in calibrated.joints() {
        let node = find(&robot, joint)?;
        edit_origin(&node, &joint.parent_from_joint, text, &mut edits)?;
        let is_measured = calibrated.has_measured_torques();
        let of_text = [compliance(&node, joint.kind, FILE)?, backlash(&node, joint.kind, FILE)?];
        let [compliance, backlash] = [(of_text[0], joint.compliance), (of_text[1], joint.backlash)];
        edits.extend(deflection_edits(&node, (COMPLIANCE, RAD_PER_NM), compliance, is_measured, text)?);
        edits.extend(deflection_edits(&node, (BACKLASH, HALF), backlash, is_measured, text)?);
    }
    Ok(apply(text, edits))
}

fn find<'a, 't>(robot: &Node<'a, 't>, joint: &Joint) -> Result<Node<'a, 't>, IoError> {
    let found = children(robot, "joint").find(|node| node.attribute("name") == Some(&joint.name));
    let leads_to =
        |node: &Node<'_, '_>| child(node, "child").and_then(|below| below.attribute("link").map(str::to_owned));
    found.filter(|node| leads_to(node).as_deref() == Some(&joint.child_link)).ok_or_else(|| {
        let expected = format!("joint `{}` with child link `{}`", joint.name, joint.child_link);
        IoError::unexpected(Place::file(FILE), expected, "none: not the text this robot was read from")
    })
}

/// The edits that give an `element` of a joint the `value` of its attribute, which may belong to
/// measured torques, where the text says another, `from`.
fn deflection_edits(
    node: &Node<'_, '_>,
    (element, attribute): (&str, &str),
    (from, value): (f64, f64),
    is_measured: bool,
    text: &str,
) -> Result<Vec<Edit>, IoError> {
    let written = format!("{value:e}");
    let Some(found) = child(node, element) else {
        let torque = if is_measured { format!(" {TORQUE}=\"{MEASURED}\"") } else { String::new() };
        let whole = format!("<{element} {attribute}=\"{written}\"{torque}/>");
        return (value != from).then(|| insert_first(node, &whole)).into_iter().collect();
    };
    let mut edits = Vec::new();
    if value != from {
        edits.push(set_attribute(&found, attribute, written, text)?);
    }
    if is_measured && !has_measured_torque(node, element, FILE)? {
        edits.push(set_attribute(&found, TORQUE, MEASURED.to_owned(), text)?);
    }
    Ok(edits)
}

/// The edits that give `joint` the origin `to`.
fn edit_origin(joint: &Node<'_, '_>, to: &Pose, text: &str, edits: &mut Vec<Edit>) -> Result<(), IoError> {
    let from = origin(joint, FILE)?;
    let moved = (to.translation.vector - from.translation.vector).amax() > UNCHANGED;
    let turned = angle(&from.rotation, &to.rotation) > UNCHANGED;
    let xyz = moved.then(|| written(to.translation.vector.into()));
    let rpy = turned.then(|| written(roll_pitch_yaw(&to.rotation)));
    let values = [("xyz", xyz), ("rpy", rpy)];
    match child(joint, "origin") {
        Some(origin) => {
            for (name, value) in values {
                edits.extend(value.map(|value| set_attribute(&origin, name, value, text)).transpose()?);
            }
        }
        None if moved || turned => {
            let attributes = values.into_iter().filter_map(|(name, value)| Some(format!(" {name}=\"{}\"", value?)));
            edits.push(insert_first(joint, &format!("<origin{}/>", attributes.collect::<String>()))?);
        }
        None => {}
    }
    Ok(())
}

/// Angle between two rotations (rad), exact near zero.
fn angle(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    let between = a.inverse() * b;
    2.0 * between.imag().norm().atan2(between.w.abs())
}

fn set_attribute(element: &Node<'_, '_>, name: &str, value: String, text: &str) -> Result<Edit, IoError> {
    match element.attribute_node(name) {
        Some(attribute) => Ok(Edit { range: value_range(element, &attribute, text)?, with: value }),
        None => Ok(Edit::insert(name_end(element, text), format!(" {name}=\"{value}\""))),
    }
}

/// Puts an element before the first child element, and indents that one as it was.
fn insert_first(parent: &Node<'_, '_>, element: &str) -> Result<Edit, IoError> {
    let Some(first) = parent.first_element_child() else {
        return Err(IoError::unexpected(place(parent, FILE), "child elements", "none"));
    };
    let text = parent.document().input_text();
    let start = first.range().start;
    let before = slice(text, 0..start);
    let indent = &before[before.trim_end_matches([' ', '\t', '\r', '\n']).len()..];
    Ok(Edit::insert(start, format!("{element}{indent}")))
}
