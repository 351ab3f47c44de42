//! How far the tool is from where an arm's model puts it, also where the arm was not calibrated.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::robot::{Kinematics, Robot};
use crate::se3::Pose;

/// Errors of the tool's pose over many joint positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolError {
    /// Mean distance (m).
    pub mean_distance: f64,
    /// Distance that 95 % stay below (m).
    pub most_distance: f64,
    /// Mean angle (rad).
    pub mean_angle: f64,
    /// Angle that 95 % stay below (rad).
    pub most_angle: f64,
}

/// Compares where two arms put the tool at the same encoder readings `positions` (rad or m).
pub fn tool_error<'q>(
    truth: &Robot,
    model: &Robot,
    tip_from_tool: Pose,
    positions: impl IntoIterator<Item = &'q [f64]>,
) -> ToolError {
    let [truth, model] = [truth, model].map(|arm| Kinematics::new(arm, &[], tip_from_tool));
    let between = positions.into_iter().map(|q| truth.pose(q).inverse() * model.pose(q));
    let (distances, angles): (Vec<f64>, Vec<f64>) =
        between.map(|error| (error.translation.vector.norm(), error.rotation.angle())).unzip();
    let (mean_distance, most_distance) = mean_and_most(distances);
    let (mean_angle, most_angle) = mean_and_most(angles);
    ToolError { mean_distance, most_distance, mean_angle, most_angle }
}

fn mean_and_most(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_unstable_by(f64::total_cmp);
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let most = values.get((values.len() * 95).div_ceil(100).saturating_sub(1)).copied().unwrap_or(0.0);
    (mean, most)
}

/// Joint positions (rad or m) drawn evenly between the joint limits, a full turn where there are
/// none: places, elbow angles and all.
pub fn random_positions(robot: &Robot, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut chance = Pcg64::seed_from_u64(seed);
    let mut position = || {
        let each = robot.moving().map(|joint| match joint.limits {
            Some(limits) => chance.random_range(limits.lower..=limits.upper),
            None => chance.random_range(-std::f64::consts::PI..=std::f64::consts::PI),
        });
        each.collect()
    };
    (0..count).map(|_| position()).collect()
}
