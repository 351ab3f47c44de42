//! A calibrated chain written into the text it was read from.

use nalgebra::UnitQuaternion;
use roxmltree::Node;

use super::document::{child, children, parse, place, robot_element};
use super::edit::{Edit, FILE, apply, name_end, slice, value_range};
use super::numbers::{roll_pitch_yaw, written};
use super::read::origin;
use super::weight::{COMPLIANCE, RAD_PER_NM, compliance};
use crate::io::base::error::{IoError, Place};
use crate::robot::{Joint, Robot};
use crate::se3::Pose;

/// Origins that differ by less (m, rad) from what the text says are left as they are written.
const UNCHANGED: f64 = 1e-13;

/// The URDF `text` with the joint origins (m, rad) and compliances (rad/(N m)) of `calibrated`,
/// which was read from this text. Masses, axes and limits are left as the text has them.
///
/// For every joint whose origin differs from the text by more than 10⁻¹³ (m, rad), the values of
/// `xyz` and `rpy` (roll, pitch and yaw about fixed axes) are replaced, or added where absent; so
/// is `<touchcal_compliance rad_per_nm="…"/>` where it differs. Every other byte stays as it is.
/// Numbers are written with all their digits; origins below 10⁻¹⁵ as 0.
///
/// # Errors
/// [`IoError`] if the text is no URDF, has unexpanded xacro, lacks a joint of the chain with its
/// child link, or has a malformed origin or compliance there.
pub fn rewrite(text: &str, calibrated: &Robot) -> Result<String, IoError> {
    let document = parse(text, FILE)?;
    let robot = robot_element(&document, FILE)?;
    let mut edits = Vec::new();
    for joint in calibrated.joints() {
        let node = find(&robot, joint)?;
        edit_origin(&node, &joint.parent_from_joint, text, &mut edits)?;
        edits.extend(compliance_edit(&node, joint, text)?);
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

/// The edit that gives the joint its compliance, where the text says another.
fn compliance_edit(node: &Node<'_, '_>, joint: &Joint, text: &str) -> Result<Option<Edit>, IoError> {
    if compliance(node, joint.kind, FILE)? == joint.compliance {
        return Ok(None);
    }
    let value = format!("{:e}", joint.compliance);
    Ok(Some(match child(node, COMPLIANCE) {
        Some(element) => set_attribute(&element, RAD_PER_NM, value, text)?,
        None => insert_first(node, &format!("<{COMPLIANCE} {RAD_PER_NM}=\"{value}\"/>"))?,
    }))
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
