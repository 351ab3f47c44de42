//! What a log calls joints and wrenches, and the unit of its positions.

use super::options::Options;
use crate::contact::AngleUnit;
use crate::io::base::csv::same;
use crate::io::base::error::{IoError, Place};
use crate::io::base::suggest::{did_you_mean, list};
#[cfg(feature = "mcap")]
use crate::robot::Joint;
use crate::robot::{JointKind, Robot};

/// Usual names of a wrench's components.
pub(crate) const WRENCH: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];

/// Usual names of the column of a joint's torque: with the joint's name and with its number among
/// the columns, from 1.
pub(crate) fn torque_names(joint: &str, number: usize) -> [String; 2] {
    [format!("tau_{joint}"), format!("tau_{number}")]
}

/// Usual names of a target's coordinates, in m and in mm, and of its normal.
pub(crate) const TARGET: [[&str; 2]; 3] = [["x_m", "x_mm"], ["y_m", "y_mm"], ["z_m", "z_mm"]];
pub(crate) const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// For each moving joint, what to multiply its column with to get rad or m.
pub(crate) fn scale(robot: &Robot, options: &Options) -> Vec<f64> {
    let degree = |kind| options.unit == AngleUnit::Degree && kind != JointKind::Prismatic;
    robot.moving().map(|joint| if degree(joint.kind) { std::f64::consts::PI / 180.0 } else { 1.0 }).collect()
}

/// Where names of a log's columns belong, which are no names of joints.
const OF_LOG: &str = "; names of columns belong in `columns`";

/// For each of `q1`…`qn`, its place among the moving joints.
pub(crate) fn joint_order(file: &str, robot: &Robot, options: &Options) -> Result<Vec<usize>, IoError> {
    let Some(wanted) = &options.joints else { return Ok((0..robot.dof()).collect()) };
    let known: Vec<&str> = robot.moving().map(|joint| joint.name.as_str()).collect();
    let mut order = Vec::with_capacity(known.len());
    for name in wanted {
        let found = known.iter().position(|joint| joint == name);
        match found.filter(|index| !order.contains(index)) {
            Some(index) => order.push(index),
            None => {
                let found = match found {
                    Some(_) => format!("`{name}` twice"),
                    None => format!("`{name}`{}", did_you_mean(name, known.iter().copied())),
                };
                let expected = format!(
                    "a list of the moving joints ({}), by the names of the URDF{OF_LOG}",
                    list(known.iter().copied())
                );
                return Err(IoError::unexpected(Place::file(file).field("joints"), expected, found));
            }
        }
    }
    if order.len() != known.len() {
        let expected = format!("all {} moving joints ({}){OF_LOG}", known.len(), list(known.iter().copied()));
        return Err(IoError::unexpected(Place::file(file).field("joints"), expected, format!("{}", order.len())));
    }
    Ok(order)
}

/// The name that each moving joint goes by, where it must be the only one: that of
/// [`Options::columns`], else its own.
#[cfg(feature = "mcap")]
pub(crate) fn joint_names(file: &str, robot: &Robot, options: &Options) -> Result<Vec<String>, IoError> {
    let order = joint_order(file, robot, options)?;
    check_renames(file, robot, options)?;
    let renamed = |usual: &str| options.columns.iter().find(|(key, _)| same(key, usual)).map(|(_, name)| name.clone());
    let name = |(index, joint): (usize, &Joint)| {
        let number = 1 + order.iter().position(|at| *at == index).unwrap_or(index);
        renamed(&joint.name).or_else(|| renamed(&format!("q{number}"))).unwrap_or_else(|| joint.name.clone())
    };
    Ok(robot.moving().enumerate().map(name).collect())
}

/// Every key of the renames must be a usual name, or it would silently do nothing.
pub(crate) fn check_renames(file: &str, robot: &Robot, options: &Options) -> Result<(), IoError> {
    let numbered: Vec<String> = (1..=robot.dof()).map(|number| format!("q{number}")).collect();
    let joints = robot.moving().map(|joint| joint.name.as_str());
    let of_target = TARGET.iter().flatten().chain(&NORMAL).copied().filter(|_| options.targets.is_some());
    let torques: Vec<String> = match options.finds_joint_torques() {
        true => robot.moving().zip(1..).flat_map(|(joint, number)| torque_names(&joint.name, number)).collect(),
        false => Vec::new(),
    };
    let of_joints = joints.chain(numbered.iter().map(String::as_str)).chain(torques.iter().map(String::as_str));
    let known = of_joints.chain(WRENCH).chain(["contact"]).chain(of_target);
    let known: Vec<&str> = known.collect();
    match options.columns.keys().find(|key| !known.iter().any(|name| same(key, name))) {
        None => Ok(()),
        Some(key) => {
            let place = Place::file(file).field("columns");
            let expected = format!("a name to rename ({})", list(known.iter().copied()));
            Err(IoError::unexpected(place, expected, format!("`{key}`{}", did_you_mean(key, known))))
        }
    }
}
