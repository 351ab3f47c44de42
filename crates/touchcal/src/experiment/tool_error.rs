//! Errors of the tool's pose by an arm's model, also away from the contacts.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::robot::{Kinematics, Robot};
use crate::se3::Pose;
use crate::statistics::{mean, nearest_rank};

/// Errors of the tool's pose over many joint positions: means and 95 % quantiles, by
/// [`nearest_rank`]. Made by [`tool_error`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolError {
    /// Mean distance between true and modelled position of the tool's origin (m).
    pub mean_distance: f64,
    /// 95 % quantile of that distance (m).
    pub distance_95: f64,
    /// Mean angle of the rotation between true and modelled tool orientation (rad, 0 to π).
    pub mean_angle: f64,
    /// 95 % quantile of that angle (rad).
    pub angle_95: f64,
}

/// Errors of the `model` arm's tool pose relative to that of the `truth` at the same encoder
/// readings `positions` (rad, or m for a prismatic joint; exactly one for each moving joint, base
/// first), with the tool at `tip_from_tool` (m) on both, without load. Both arms have the same
/// number of moving joints. Zeros without positions.
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
    let (mean_distance, distance_95) = mean_and_95(distances);
    let (mean_angle, angle_95) = mean_and_95(angles);
    ToolError { mean_distance, distance_95, mean_angle, angle_95 }
}

fn mean_and_95(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_unstable_by(f64::total_cmp);
    (mean(&values), nearest_rank(&values, 95).unwrap_or(0.0))
}

/// `count` lists of joint positions (rad, or m for a prismatic joint; one for each moving joint,
/// base first), uniform between the joint limits, or over ±π (rad or m) where there are none; the
/// same for the same `seed`. Panics if a joint's limits are not finite or the lower is above the
/// upper one.
pub fn random_positions(robot: &Robot, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut position = || {
        let each = robot.moving().map(|joint| match joint.limits {
            Some(limits) => rng.random_range(limits.lower..=limits.upper),
            None => rng.random_range(-std::f64::consts::PI..=std::f64::consts::PI),
        });
        each.collect()
    };
    (0..count).map(|_| position()).collect()
}
