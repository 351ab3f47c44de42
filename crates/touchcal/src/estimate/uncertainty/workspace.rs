//! Uncertainty of the tool across the arm's workspace.

use nalgebra::{DMatrix, DVector, Vector3};

use super::tool_motion::{ToolMotion, tool_jacobians};
use crate::estimate::problem::Problem;
use crate::estimate::result::{ErrorFrame, Estimate, ParameterEstimate, WorkspaceUncertainty};
use crate::parameter::{Parameter, ParameterId, kinematic_part};
use crate::robot::{JointKind, KinematicParameter, Kinematics, Robot};
use crate::se3::{self, Pose};

/// Pairs of configurations that the mean is taken over.
const PAIRS: usize = 100;
/// Number of joint positions over the workspace at which the motion of the tool is taken.
pub(crate) const SAMPLED_POSITIONS: usize = 100;
/// Positions of a prismatic joint without limits are within ± this (m).
const PRISMATIC_RANGE: f64 = 0.5;

/// Root mean square standard deviations (m) of distances between tool positions across the
/// workspace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ArmUncertainty {
    /// By the scales of the parameters alone.
    pub before: f64,
    /// By contacts and scales.
    pub after: f64,
}

impl ArmUncertainty {
    /// After over before (1); 0 if nothing moves the tool.
    pub fn remaining(self) -> f64 {
        if self.before > 0.0 { self.after / self.before } else { 0.0 }
    }
}

/// How uncertain distances between tool positions are.
///
/// Distances need neither base nor fixtures, so motion of the whole arm does not count: `d = ‖p(q₁)
/// − p(q₂)‖` at pairs of configurations spread over the joint limits, its variance `∂d/∂θ Σ
/// (∂d/∂θ)ᵀ` with `Σ` the `covariance` after, and diag(`scale`²) before. Only parameters of the
/// kinematics take part; 0 if there are none.
pub(crate) fn arm_uncertainty(
    problem: &Problem,
    parameters: &[Parameter],
    covariance: &DMatrix<f64>,
    scale: &DVector<f64>,
) -> ArmUncertainty {
    let of_kinematics = |k: usize| parameters[k].id.kinematic().map(|parameter| (k, parameter));
    let (indices, columns): (Vec<usize>, Vec<KinematicParameter>) =
        (0..parameters.len()).filter_map(of_kinematics).unzip();
    let kinematics = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
    let kinematics = kinematics.with_usual_torques(problem.usual_torques());
    let mut scratch = kinematics.scratch();
    let limits = workspace_limits(&problem.robot);
    let mut place = |index: usize| {
        let pose = kinematics.pose_and_jacobian(&configuration(&limits, index), &mut scratch);
        ToolPosition::new(&pose, scratch.parameters.iter().map(se3::linear))
    };
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
    let of_pairs = |variance: f64| (variance.max(0.0) / PAIRS as f64).sqrt();
    ArmUncertainty { before: of_pairs(before), after: of_pairs(after) }
}

/// Position of the tool in base (m), and its derivative by each parameter of the kinematics.
struct ToolPosition {
    position: Vector3<f64>,
    derivatives: Vec<Vector3<f64>>,
}

impl ToolPosition {
    /// The tool at `pose` in base, moved in its own frame by each parameter as `derivatives` say.
    fn new(pose: &Pose, derivatives: impl Iterator<Item = Vector3<f64>>) -> Self {
        let derivatives = derivatives.map(|column| pose.rotation * column).collect();
        ToolPosition { position: pose.translation.vector, derivatives }
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

/// Uncertainty of the calibrated arm's tool, without load (joints that deflect by measured torques
/// bear those usual in the contacts), at each of the joint `positions` (rad,
/// or m for a prismatic joint; one for each moving joint, base first), in their order: of `J Σ Jᵀ`,
/// with `J` the derivative of the pose `base_from_tool` by the parameters of arm, tool, encoder
/// harmonics and gear ratios, and `Σ` their part of the estimate's covariance. The errors of
/// encoders themselves count as corrected. `estimate` must be one of `problem`. Fixed parameters
/// have their scale as standard deviation: no datum makes them zero. `None` if the contacts of any
/// fixture are measured by a projection, from which no uncertainty follows.
pub fn tool_uncertainty<'q>(
    problem: &Problem,
    estimate: &Estimate,
    positions: impl Iterator<Item = &'q [f64]>,
) -> Option<Vec<ToolUncertainty>> {
    let tool = CalibratedTool::new(problem, estimate)?;
    let each = tool.jacobians(positions).into_iter().map(|jacobian| {
        let of_tool = &jacobian * &tool.covariance * jacobian.transpose();
        let deviation = |from: usize| (from..from + 3).map(|k| of_tool[(k, k)]).sum::<f64>().max(0.0).sqrt();
        ToolUncertainty { position: deviation(0), angle: deviation(3) }
    });
    Some(each.collect())
}

/// Root mean squares of [`tool_uncertainty`] and [`distance_uncertainty`] over positions spread
/// evenly over the workspace, and with them those of the nominal tool's error.
pub(crate) fn workspace_uncertainty(problem: &Problem, estimate: &Estimate) -> Option<WorkspaceUncertainty> {
    let positions = workspace_configurations(&problem.robot, SAMPLED_POSITIONS);
    let tool = tool_uncertainty(problem, estimate, positions.iter().map(Vec::as_slice))?;
    let distances = distance_uncertainty(problem, estimate, &positions)?;
    let calibrated = CalibratedTool::new(problem, estimate)?.kinematics;
    let nominal = Kinematics::new(&problem.robot, &[], problem.tool.tip_from_tool);
    let nominal = nominal.with_usual_torques(problem.usual_torques());
    let poses = |kinematics: &Kinematics| positions.iter().map(|q| kinematics.pose(q)).collect::<Vec<Pose>>();
    let (calibrated, nominal) = (poses(&calibrated), poses(&nominal));
    let apart = |pair: &[Pose]| (pair[1].translation.vector - pair[0].translation.vector).norm();
    let of_position =
        calibrated.iter().zip(&nominal).map(|(a, b)| (a.translation.vector - b.translation.vector).norm());
    let of_angle = calibrated.iter().zip(&nominal).map(|(a, b)| a.rotation.angle_to(&b.rotation));
    let of_distance = calibrated.windows(2).zip(nominal.windows(2)).map(|(a, b)| apart(a) - apart(b));
    let [position, angle] = [|tool: &ToolUncertainty| tool.position, |tool: &ToolUncertainty| tool.angle]
        .map(|part| root_mean_square(tool.iter().map(part)));
    let distance = root_mean_square(distances.into_iter());
    Some(WorkspaceUncertainty {
        position,
        angle,
        distance,
        nominal_position: position.hypot(root_mean_square(of_position)),
        nominal_angle: angle.hypot(root_mean_square(of_angle)),
        nominal_distance: distance.hypot(root_mean_square(of_distance)),
    })
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

/// Standard deviation (m) of the distance between the tool's positions at every two successive
/// joint `positions` (rad, or m for a prismatic joint; one for each moving joint, base first),
/// without load, by the covariance of [`tool_uncertainty`]: one number fewer than positions, none
/// for an empty list, 0 where both positions of the tool are the same. Independent of the base, so
/// motion of the whole arm does not count. `None` if the contacts of any fixture are measured by a
/// projection.
pub fn distance_uncertainty(problem: &Problem, estimate: &Estimate, positions: &[Vec<f64>]) -> Option<Vec<f64>> {
    let tool = CalibratedTool::new(problem, estimate)?;
    let mut scratch = tool.kinematics.scratch();
    let place = |(q, jacobian): (&Vec<f64>, DMatrix<f64>)| {
        let pose = tool.kinematics.pose_and_jacobian(q, &mut scratch);
        ToolPosition::new(&pose, jacobian.fixed_rows::<3>(0).column_iter().map(|column| column.into_owned()))
    };
    let jacobians = tool.jacobians(positions.iter().map(Vec::as_slice));
    let places: Vec<ToolPosition> = positions.iter().zip(jacobians).map(place).collect();
    let each = places.windows(2).map(|pair| {
        let slope = DVector::from_vec(pair[0].distance_gradient(&pair[1]));
        slope.dot(&(&tool.covariance * &slope)).max(0.0).sqrt()
    });
    Some(each.collect())
}

/// The tool of the arm at its estimated parameters.
pub(crate) struct CalibratedTool {
    kinematics: Kinematics,
    /// Indices in [`Estimate::parameters`] of the parameters that move the tool: those of the
    /// kinematics, harmonics of the encoders and gear ratios.
    pub indices: Vec<usize>,
    /// These parameters.
    pub parameters: Vec<ParameterEstimate>,
    /// Of these parameters (SI), in their order.
    pub covariance: DMatrix<f64>,
}

impl CalibratedTool {
    /// None if the estimate has no uncertainty.
    pub fn new(problem: &Problem, estimate: &Estimate) -> Option<Self> {
        if !problem.has_uncertainty() {
            return None;
        }
        let moves_tool = |id| matches!(id, ParameterId::Kinematic(_) | ParameterId::EncoderError(..));
        let indices: Vec<usize> =
            (0..estimate.parameters.len()).filter(|&k| moves_tool(estimate.parameters[k].parameter.id)).collect();
        let parameters: Vec<ParameterEstimate> = indices.iter().map(|&k| estimate.parameters[k].clone()).collect();
        let (columns, values) = kinematic_part(parameters.iter().map(|entry| (entry.parameter.id, entry.value)));
        let mut kinematics = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
        kinematics.set(&values);
        let kinematics = kinematics.with_usual_torques(problem.usual_torques());
        let mut covariance = estimate.covariance.select_rows(&indices).select_columns(&indices);
        for (k, entry) in parameters.iter().enumerate() {
            if covariance[(k, k)] == 0.0 {
                covariance[(k, k)] = entry.parameter.scale.powi(2);
            }
        }
        Some(CalibratedTool { kinematics, indices, parameters, covariance })
    }

    /// Derivative of the tool's pose (its local twist, m and rad) by each parameter (SI) at each of
    /// the joint `positions`: 6 rows.
    pub fn jacobians<'q>(&self, positions: impl Iterator<Item = &'q [f64]>) -> Vec<DMatrix<f64>> {
        let ids: Vec<ParameterId> = self.parameters.iter().map(|entry| entry.parameter.id).collect();
        tool_jacobians(&self.kinematics, &ids, positions)
    }

    /// How these parameters move the tool at each of the joint `positions`, in `frame`.
    pub fn motion(&self, positions: &[Vec<f64>], frame: ErrorFrame) -> ToolMotion {
        let ids: Vec<ParameterId> = self.parameters.iter().map(|entry| entry.parameter.id).collect();
        ToolMotion::new(&self.kinematics, &ids, positions, frame)
    }

    /// Errors of the encoders that depend on the position (SI), 0 for other parameters: a robot
    /// description does not contain them.
    pub fn encoder_errors(&self) -> DVector<f64> {
        let value = |entry: &ParameterEstimate| match entry.parameter.id {
            ParameterId::EncoderError(..) => entry.value,
            _ => 0.0,
        };
        DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(value))
    }
}

/// Root mean square distance (m) in [`tool_positions`] between the tool's positions in base of the
/// problem's arm with the values `a` of the `parameters` (SI) and with `b`.
pub(crate) fn tool_distance(problem: &Problem, parameters: &[Parameter], a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let positions = tool_positions(problem);
    let [a, b] = [a, b].map(|values| {
        let (columns, values) = kinematic_part(parameters.iter().map(|p| p.id).zip(values.iter().copied()));
        let mut kinematics = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
        kinematics.set(&values);
        let kinematics = kinematics.with_usual_torques(problem.usual_torques());
        let position = |q: &Vec<f64>| kinematics.pose(q).translation.vector;
        positions.iter().map(position).collect::<Vec<Vector3<f64>>>()
    });
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).norm_squared()).sum();
    (squares / positions.len().max(1) as f64).sqrt()
}

/// Joint positions (rad, or m for a prismatic joint; one for each moving joint, base first) in
/// which errors of the tool count: those of the task that is asked for, or else over the workspace.
pub(crate) fn tool_positions(problem: &Problem) -> Vec<Vec<f64>> {
    match &problem.acceptance {
        Some(asked) if !asked.positions.is_empty() => asked.positions.clone(),
        _ => workspace_configurations(&problem.robot, SAMPLED_POSITIONS),
    }
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
