//! What the estimate is worth where the arm works, not where it was calibrated.

use nalgebra::{DMatrix, DVector, Vector3};

use super::conclude::has_projection;
use super::outcome::Estimate;
use super::problem::Problem;
use crate::robot::{Block, Column, JointKind, Kinematics, Parameter, Robot, Scratch};
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
    let mut place = |index: usize| Place::at(&kinematics, &configuration(&problem.robot, index), &mut scratch);
    let (mut before, mut after) = (0.0, 0.0);
    for pair in 0..PAIRS {
        let slope = place(2 * pair + 1).distance_slope(&place(2 * pair + 2));
        for (a, &i) in arm.iter().enumerate() {
            before += (slope[a] * scale[i]).powi(2);
            for (b, &j) in arm.iter().enumerate() {
                after += slope[a] * posterior[(i, j)] * slope[b];
            }
        }
    }
    if before > 0.0 { (after.max(0.0) / before).sqrt() } else { 0.0 }
}

/// Where the tool is in base (m), and how each parameter moves it.
struct Place {
    place: Vector3<f64>,
    moved: Vec<Vector3<f64>>,
}

impl Place {
    fn at(kinematics: &Kinematics, q: &[f64], scratch: &mut Scratch) -> Self {
        let pose = kinematics.pose_and_jacobian(q, scratch);
        let moved = scratch.columns.iter().map(|column| pose.rotation * se3::linear(column));
        Place { place: pose.translation.vector, moved: moved.collect() }
    }

    /// Derivative of the distance to another place by each parameter.
    fn distance_slope(&self, to: &Place) -> Vec<f64> {
        let along = (to.place - self.place).try_normalize(0.0).unwrap_or_default();
        self.moved.iter().zip(&to.moved).map(|(a, b)| along.dot(&(b - a))).collect()
    }
}

/// How uncertain the tool's pose in base is: roots of the traces of the variances of its place (m) and of its rotation vector (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolUncertainty {
    /// Standard deviation of the place (m).
    pub position: f64,
    /// Standard deviation of the rotation (rad).
    pub angle: f64,
}

/// Uncertainty of the calibrated arm's tool at each of the joint positions: `J Σ Jᵀ` with `Σ` the estimate's covariance, in which
/// parameters that were held count with their scale: nothing says that they are zero. None if the estimate has no uncertainty.
pub fn tool_uncertainty<'q>(
    problem: &Problem,
    estimate: &Estimate,
    positions: impl Iterator<Item = &'q [f64]>,
) -> Option<Vec<ToolUncertainty>> {
    let Calibrated { kinematics, covariance } = calibrated(problem, estimate)?;
    let mut scratch = kinematics.scratch();
    let each = positions.map(|q| {
        kinematics.pose_and_jacobian(q, &mut scratch);
        let jacobian = DMatrix::from_fn(6, scratch.columns.len(), |row, k| scratch.columns[k][row]);
        let of_tool = &jacobian * &covariance * jacobian.transpose();
        let deviation = |from: usize| (from..from + 3).map(|k| of_tool[(k, k)]).sum::<f64>().max(0.0).sqrt();
        ToolUncertainty { position: deviation(0), angle: deviation(3) }
    });
    Some(each.collect())
}

/// Standard deviation (m) of the distance between the tool's places at every two joint positions that follow each other in `positions`: needs no base, so what
/// only moves the whole arm does not count. None if the estimate has no uncertainty.
pub fn distance_uncertainty(problem: &Problem, estimate: &Estimate, positions: &[Vec<f64>]) -> Option<Vec<f64>> {
    let Calibrated { kinematics, covariance } = calibrated(problem, estimate)?;
    let mut scratch = kinematics.scratch();
    let places: Vec<Place> = positions.iter().map(|q| Place::at(&kinematics, q, &mut scratch)).collect();
    let each = places.windows(2).map(|pair| {
        let slope = DVector::from_vec(pair[0].distance_slope(&pair[1]));
        slope.dot(&(&covariance * &slope)).max(0.0).sqrt()
    });
    Some(each.collect())
}

/// The arm with all its parameters at their estimates.
struct Calibrated {
    kinematics: Kinematics,
    /// Of the parameters (SI), in their order.
    covariance: DMatrix<f64>,
}

/// None if the estimate has no uncertainty.
fn calibrated(problem: &Problem, estimate: &Estimate) -> Option<Calibrated> {
    let columns: Vec<Column> = estimate.parameters.iter().map(|entry| entry.parameter.column).collect();
    let mut kinematics = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
    kinematics.set(estimate.values().as_slice());
    let mut covariance = estimate.covariance.clone();
    for (k, entry) in estimate.parameters.iter().enumerate() {
        if covariance[(k, k)] == 0.0 {
            covariance[(k, k)] = entry.parameter.scale.powi(2);
        }
    }
    (!has_projection(problem)).then_some(Calibrated { kinematics, covariance })
}

/// Joint positions (rad, m) spread evenly over the joints' limits, the same for the same robot.
pub fn workspace_configurations(robot: &Robot, count: usize) -> Vec<Vec<f64>> {
    (1..=count).map(|index| configuration(robot, index)).collect()
}

/// Configuration number `index` of a sequence that fills the joint limits evenly (Halton 1960).
fn configuration(robot: &Robot, index: usize) -> Vec<f64> {
    const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
    let each = robot.moving().enumerate().map(|(i, joint)| {
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
