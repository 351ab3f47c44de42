//! What the estimate is worth where the arm works, not where it was calibrated.

use nalgebra::{DMatrix, DVector, Vector3};

use super::problem::Problem;
use crate::robot::{Block, Column, JointKind, Kinematics, Parameter};
use crate::se3;

/// Pairs of configurations looked at.
const PAIRS: usize = 100;

/// Root mean square uncertainty of distances between tool positions across the workspace, after over before.
///
/// Distances need neither base nor fixtures, so what only moves the whole arm does not count: `d = ‖p(q₁) − p(q₂)‖` at pairs of
/// configurations spread over the joint limits, its variance `∂d/∂θ Σ (∂d/∂θ)ᵀ` with `Σ` the covariance `posterior`, and diag(`scale`²) before.
/// Only the arm's and the tool's parameters take part; 0 if there are none.
pub(crate) fn arm_uncertainty_left(
    problem: &Problem,
    parameters: &[Parameter],
    posterior: &DMatrix<f64>,
    scale: &DVector<f64>,
) -> f64 {
    let of_arm = |parameter: &Parameter| {
        matches!(parameter.column.block(), Block::Tool) || !parameter.column.block().is_nuisance()
    };
    let arm: Vec<usize> = (0..parameters.len()).filter(|&k| of_arm(&parameters[k])).collect();
    let columns: Vec<Column> = arm.iter().map(|&k| parameters[k].column).collect();
    let kinematics = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
    let mut scratch = kinematics.scratch();
    let mut tool = |index: usize| {
        let pose = kinematics.pose_and_jacobian(&configuration(problem, index), &mut scratch);
        let moved: Vec<Vector3<f64>> =
            scratch.columns.iter().map(|column| pose.rotation * se3::linear(column)).collect();
        (pose.translation.vector, moved)
    };
    let (mut before, mut after) = (0.0, 0.0);
    for pair in 0..PAIRS {
        let (first, first_moved) = tool(2 * pair + 1);
        let (second, second_moved) = tool(2 * pair + 2);
        let along = (second - first).normalize();
        let slope: Vec<f64> = first_moved.iter().zip(&second_moved).map(|(a, b)| along.dot(&(b - a))).collect();
        for (a, &i) in arm.iter().enumerate() {
            before += (slope[a] * scale[i]).powi(2);
            for (b, &j) in arm.iter().enumerate() {
                after += slope[a] * posterior[(i, j)] * slope[b];
            }
        }
    }
    if before > 0.0 { (after.max(0.0) / before).sqrt() } else { 0.0 }
}

/// Configuration number `index` of a sequence that fills the joint limits evenly (Halton 1960).
fn configuration(problem: &Problem, index: usize) -> Vec<f64> {
    const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
    let each = problem.robot.moving().enumerate().map(|(i, joint)| {
        let (lower, upper) = match (joint.limits, joint.kind) {
            (Some(limits), _) => (limits.lower, limits.upper),
            (None, JointKind::Prismatic) => (-0.5, 0.5),
            (None, _) => (-std::f64::consts::PI, std::f64::consts::PI),
        };
        lower + (upper - lower) * radical_inverse(index + i / PRIMES.len(), PRIMES[i % PRIMES.len()])
    });
    each.collect()
}

fn radical_inverse(mut index: usize, base: usize) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0 / base as f64);
    while index > 0 {
        value += (index % base) as f64 * digit;
        index /= base;
        digit /= base as f64;
    }
    value
}
