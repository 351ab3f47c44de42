//! What deflects a joint: the mass of its link, its own compliance and its backlash.

use roxmltree::Node;

use super::document::{LARGEST, attribute, child, numbers, place};
use crate::io::base::error::{IoError, Place, quoted, shown_number};
use crate::robot::{Inertia, JointKind};

/// The child element of a joint that holds its compliance. URDF does not know it: other readers
/// pass it over.
pub(super) const COMPLIANCE: &str = "touchcal_compliance";
/// Its attribute, rad/(N m).
pub(super) const RAD_PER_NM: &str = "rad_per_nm";
/// The child element of a joint that holds its backlash, likewise, and its attribute: half of the
/// play (rad, or m for a prismatic joint).
pub(super) const BACKLASH: &str = "touchcal_backlash";
pub(super) const HALF: &str = "half";
/// The attribute of both that says whether it belongs to measured torques, and the only value of
/// that.
pub(super) const TORQUE: &str = "torque";
pub(super) const MEASURED: &str = "measured";

/// Mass and centre of mass of a link; none if it declares none.
pub(super) fn inertia(link: &Node<'_, '_>, file: &str) -> Result<Option<Inertia>, IoError> {
    let Some(inertial) = child(link, "inertial") else { return Ok(None) };
    let name = link.attribute("name").unwrap_or_default();
    let at = |node: &Node<'_, '_>| place(node, file).field(format!("link `{name}`, inertial"));
    let Some(mass) = child(&inertial, "mass") else {
        return Err(IoError::unexpected(at(&inertial), "a <mass value=\"…\"/>", "none"));
    };
    let mass = required(&mass, "value", file, at(&mass))?;
    if mass < 0.0 {
        return Err(IoError::unexpected(at(&inertial), "a mass of at least 0", shown_number(mass)));
    }
    let center = match child(&inertial, "origin") {
        Some(origin) => numbers::<3>(&origin, ("xyz", LARGEST), || at(&origin))?.unwrap_or_default(),
        None => [0.0; 3],
    };
    Ok(Some(Inertia { mass, center: center.into() }))
}

/// The joint's compliance; 0 where it declares none.
pub(super) fn compliance(joint: &Node<'_, '_>, kind: JointKind, file: &str) -> Result<f64, IoError> {
    let Some(element) = child(joint, COMPLIANCE) else { return Ok(0.0) };
    let name = joint.attribute("name").unwrap_or_default();
    let at = place(&element, file).field(format!("joint `{name}`, {COMPLIANCE}"));
    if !matches!(kind, JointKind::Revolute | JointKind::Continuous) {
        let found = joint.attribute("type").unwrap_or_default();
        return Err(IoError::unexpected(at, "a joint of type `revolute` or `continuous`", format!("`{found}`")));
    }
    required(&element, RAD_PER_NM, file, at)
}

/// The joint's backlash; 0 where it declares none.
pub(super) fn backlash(joint: &Node<'_, '_>, kind: JointKind, file: &str) -> Result<f64, IoError> {
    let Some(element) = child(joint, BACKLASH) else { return Ok(0.0) };
    let name = joint.attribute("name").unwrap_or_default();
    let at = place(&element, file).field(format!("joint `{name}`, {BACKLASH}"));
    if kind == JointKind::Fixed {
        return Err(IoError::unexpected(at, "a joint that moves", "one of type `fixed`"));
    }
    required(&element, HALF, file, at)
}

/// Whether a joint's compliance or backlash, the `element`, belongs to measured torques.
pub(super) fn has_measured_torque(joint: &Node<'_, '_>, element: &str, file: &str) -> Result<bool, IoError> {
    let (of, Some(element)) = (element, child(joint, element)) else { return Ok(false) };
    match element.attribute(TORQUE) {
        None => Ok(false),
        Some(MEASURED) => Ok(true),
        Some(other) => {
            let name = joint.attribute("name").unwrap_or_default();
            let at = place(&element, file).field(format!("joint `{name}`, {of}, {TORQUE}"));
            Err(IoError::unexpected(at, format!("`{MEASURED}`"), quoted(other)))
        }
    }
}

/// A number that must be there.
fn required(element: &Node<'_, '_>, name: &str, file: &str, at: Place) -> Result<f64, IoError> {
    attribute(element, name, file)?;
    numbers::<1>(element, (name, LARGEST), || at).map(|number| number.map_or(0.0, |[number]| number))
}
