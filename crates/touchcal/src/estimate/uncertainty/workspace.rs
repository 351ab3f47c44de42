//! Uncertainty of the tool across the arm's workspace.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::estimate::problem::Problem;
use crate::estimate::result::{Estimate, ParameterEstimate};
use crate::parameter::Parameter;
use crate::robot::{JointKind, KinematicParameter, Kinematics, KinematicsScratch, Robot};
use crate::se3;

/// Pairs of configurations that the mean is taken over.
const PAIRS: usize = 100;
/// Positions of a prismatic joint without limits are within ± this (m).
const PRISMATIC_RANGE: f64 = 0.5;

/// Root mean square uncertainty of distances between tool positions across the workspace, after
/// over before the calibration (1).
///
/// Distances need neither base nor fixtures, so motion of the whole arm does not count: `d = ‖p(q₁)
/// − p(q₂)‖` at pairs of configurations spread over the joint limits, its variance `∂d/∂θ Σ
/// (∂d/∂θ)ᵀ` with `Σ` the `covariance` after, and diag(`scale`²) before. Only parameters of the
/// kinematics take part; 0 if there are none.
pub(crate) fn arm_uncertainty_ratio(
    problem: &Problem,
    parameters: &[Parameter],
    covariance: &DMatrix<f64>,
    scale: &DVector<f64>,
) -> f64 {
    let of_kinematics = |k: usize| parameters[k].id.kinematic().map(|parameter| (k, parameter));
    let (indices, columns): (Vec<usize>, Vec<KinematicParameter>) =
        (0..parameters.len()).filter_map(of_kinematics).unzip();
    let kinematics = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
    let mut scratch = kinematics.scratch();
    let limits = workspace_limits(&problem.robot);
    let mut place = |index: usize| ToolPosition::new(&kinematics, &configuration(&limits, index), &mut scratch);
    let (mut before, mut after) = (0.0, 0.0);
    for pair in 0..PAIRS {
        let slope = place(2 * pair + 1).distance_gradient(&place(2 * pair + 2));
        for (a, &i) in indices.iter().enumerate() {
            before += (slope[a] * scale[i]).powi(2);
            for (b, &j) in indices.iter().enumerate() {
                after += slope[a] * covariance[(i, j)] * slope[b];
            }
        }
    }
    if before > 0.0 { (after.max(0.0) / before).sqrt() } else { 0.0 }
}

/// Position of the tool in base (m), and its derivative by each parameter of the kinematics.
struct ToolPosition {
    position: Vector3<f64>,
    derivatives: Vec<Vector3<f64>>,
}

impl ToolPosition {
    fn new(kinematics: &Kinematics, q: &[f64], scratch: &mut KinematicsScratch) -> Self {
        let pose = kinematics.pose_and_jacobian(q, scratch);
        let derivatives = scratch.parameters.iter().map(|column| pose.rotation * se3::linear(column));
        ToolPosition { position: pose.translation.vector, derivatives: derivatives.collect() }
    }

    /// Derivative of the distance to another position by each parameter.
    fn distance_gradient(&self, to: &ToolPosition) -> Vec<f64> {
        let along = (to.position - self.position).try_normalize(0.0).unwrap_or_default();
        self.derivatives.iter().zip(&to.derivatives).map(|(a, b)| along.dot(&(b - a))).collect()
    }
}

/// Uncertainty of the tool's pose `base_from_tool` at one configuration: square roots of the traces
/// of the covariances of its position and of its rotation vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolUncertainty {
    /// Standard deviation of the tool's position, all three components together (m).
    pub position: f64,
    /// Standard deviation of the tool's rotation vector, all three components together (rad).
    pub angle: f64,
}

/// Uncertainty of the calibrated arm's tool, without load, at each of the joint `positions` (rad,
/// or m for a prismatic joint; one for each moving joint, base first), in their order: of `J Σ Jᵀ`,
/// with `J` the derivative of the pose `base_from_tool` by the parameters of arm and tool and `Σ`
/// their part of the estimate's covariance. `estimate` must be one of `problem`. Fixed parameters
/// have their scale as standard deviation: no datum makes them zero. `None` if the contacts of any
/// fixture are measured by a projection, from which no uncertainty follows.
pub fn tool_uncertainty<'q>(
    problem: &Problem,
    estimate: &Estimate,
    positions: impl Iterator<Item = &'q [f64]>,
) -> Option<Vec<ToolUncertainty>> {
    let CalibratedKinematics { kinematics, covariance } = calibrated_kinematics(problem, estimate)?;
    let mut scratch = kinematics.scratch();
    let each = positions.map(|q| {
        kinematics.pose_and_jacobian(q, &mut scratch);
        let jacobian = DMatrix::from_fn(6, scratch.parameters.len(), |row, k| scratch.parameters[k][row]);
        let of_tool = &jacobian * &covariance * jacobian.transpose();
        let deviation = |from: usize| (from..from + 3).map(|k| of_tool[(k, k)]).sum::<f64>().max(0.0).sqrt();
        ToolUncertainty { position: deviation(0), angle: deviation(3) }
    });
    Some(each.collect())
}

/// Standard deviation (m) of the distance between the tool's positions at every two successive
/// joint `positions` (rad, or m for a prismatic joint; one for each moving joint, base first),
/// without load, by the covariance of [`tool_uncertainty`]: one number fewer than positions, none
/// for an empty list, 0 where both positions of the tool are the same. Independent of the base, so
/// motion of the whole arm does not count. `None` if the contacts of any fixture are measured by a
/// projection.
pub fn distance_uncertainty(problem: &Problem, estimate: &Estimate, positions: &[Vec<f64>]) -> Option<Vec<f64>> {
    let CalibratedKinematics { kinematics, covariance } = calibrated_kinematics(problem, estimate)?;
    let mut scratch = kinematics.scratch();
    let places: Vec<ToolPosition> = positions.iter().map(|q| ToolPosition::new(&kinematics, q, &mut scratch)).collect();
    let each = places.windows(2).map(|pair| {
        let slope = DVector::from_vec(pair[0].distance_gradient(&pair[1]));
        slope.dot(&(&covariance * &slope)).max(0.0).sqrt()
    });
    Some(each.collect())
}

/// The arm at the estimated parameters of its kinematics.
pub(crate) struct CalibratedKinematics {
    pub kinematics: Kinematics,
    /// Of these parameters (SI), in their order.
    pub covariance: DMatrix<f64>,
}

/// None if the estimate has no uncertainty.
pub(crate) fn calibrated_kinematics(problem: &Problem, estimate: &Estimate) -> Option<CalibratedKinematics> {
    let of_kinematics = |(k, entry): (usize, &ParameterEstimate)| Some((k, entry.parameter.id.kinematic()?));
    let (indices, columns): (Vec<usize>, Vec<KinematicParameter>) =
        estimate.parameters.iter().enumerate().filter_map(of_kinematics).unzip();
    let mut kinematics = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
    kinematics.set(&indices.iter().map(|&k| estimate.parameters[k].value).collect::<Vec<f64>>());
    let mut covariance = estimate.covariance.select_rows(&indices).select_columns(&indices);
    for (own, &k) in indices.iter().enumerate() {
        if covariance[(own, own)] == 0.0 {
            covariance[(own, own)] = estimate.parameters[k].parameter.scale.powi(2);
        }
    }
    (!problem.has_projection()).then_some(CalibratedKinematics { kinematics, covariance })
}

/// `count` lists of joint positions (rad, or m for a prismatic joint; one for each moving joint,
/// base first), spread evenly over the joint limits, or over ±π and ±0.5 m without limits: a Halton
/// sequence, the same for the same robot, of which a larger `count` continues a smaller one
/// (Halton, *On the efficiency of certain quasi-random sequences of points* (1960)).
pub fn workspace_configurations(robot: &Robot, count: usize) -> Vec<Vec<f64>> {
    configurations_within(&workspace_limits(robot), count)
}

/// `count` lists of joint positions, each between the `limits` of its joint, lower and upper,
/// spread as those of [`workspace_configurations`].
pub fn configurations_within(limits: &[(f64, f64)], count: usize) -> Vec<Vec<f64>> {
    (1..=count).map(|index| configuration(limits, index)).collect()
}

/// The joint limits, or ±π and ±0.5 m without limits.
fn workspace_limits(robot: &Robot) -> Vec<(f64, f64)> {
    let each = robot.moving().map(|joint| match (joint.limits, joint.kind) {
        (Some(limits), _) => (limits.lower, limits.upper),
        (None, JointKind::Prismatic) => (-PRISMATIC_RANGE, PRISMATIC_RANGE),
        (None, _) => (-std::f64::consts::PI, std::f64::consts::PI),
    });
    each.collect()
}

/// Configuration number `index` of a low-discrepancy sequence within the limits of the joints.
fn configuration(limits: &[(f64, f64)], index: usize) -> Vec<f64> {
    const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
    let each = limits.iter().enumerate().map(|(i, &(lower, upper))| {
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
