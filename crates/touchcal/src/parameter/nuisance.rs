//! Parameters that are estimated with the arm and are no part of it.

use super::arm::VARIANCE_COMPONENT_STRENGTH;
use super::definition::{Parameter, Prior};
use super::parameter_id::{DIRECTION_NAMES, ParameterId};
use crate::robot::{JointKind, Robot};

/// Start of the drifts' variance component.
const DRIFT_SIGMA: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// An encoder offset for each revolute joint in placement number `placement` only (rad), its prior
/// a variance component.
pub fn joint_drift(robot: &Robot, placement: usize, placement_name: &str) -> Vec<Parameter> {
    let revolute = robot.moving().enumerate().filter(|(_, joint)| joint.kind != JointKind::Prismatic);
    let prior =
        Prior::VarianceComponent { sigma: DRIFT_SIGMA, group: "joint_drift", strength: VARIANCE_COMPONENT_STRENGTH };
    let each = revolute.map(|(i, joint)| {
        let name = format!("joint_drift.{}.{placement_name}", joint.name);
        Parameter::angle(name, ParameterId::JointDrift(placement, i)).with_prior(prior)
    });
    each.collect()
}

/// Mean gap (m) at contacts with fixture number `fixture`, without prior.
pub fn gap_bias(fixture_name: &str, fixture: usize) -> Parameter {
    Parameter::length(format!("gap_bias.{fixture_name}"), ParameterId::GapBias(fixture))
}

/// What is added to the gap bias (m) for contacts whose normal points in direction `k` of fixture
/// number `fixture` (+x, −x, +y, −y, +z, −z), without prior.
pub fn directional_gap_bias(fixture_name: &str, fixture: usize, k: usize) -> Parameter {
    let name = format!("gap_bias.{fixture_name}.{}", DIRECTION_NAMES[k.min(5)]);
    Parameter::length(name, ParameterId::DirectionalGapBias(fixture, k))
}
