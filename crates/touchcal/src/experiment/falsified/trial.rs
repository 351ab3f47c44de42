//! One trial: simulated, falsified, calibrated, and compared with the truth.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::excitation::Excitation;
use super::kind::FalsifiedKind;
use crate::estimate::{Estimate, Problem, Progress, Status, calibrate, calibrate_with_freed_effects, tool_uncertainty};
use crate::experiment::parameter_errors::{ParameterErrors, true_robot};
use crate::experiment::tool_error::random_positions;
use crate::robot::{Kinematics, Robot};
use crate::se3::Pose;
use crate::sim::{self, PartsError, SimulatedTrial, SimulationError, Truth};

/// Probability (1) with which the NEES of honest errors is below the limit.
const HONEST: f64 = 0.999;
/// Joint positions all over the workspace at which the tool is compared, and their seed.
const WORKSPACE: (usize, u64) = (1000, 1);

/// One trial of the battery, made by [`falsified_trial`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FalsifiedRow {
    /// Name of the kind ([`FalsifiedKind::name`]).
    pub kind: String,
    /// Name of the excitation ([`Excitation::name`]), or of the recorded trial.
    pub excitation: String,
    /// Seed of the simulation and of what is false.
    pub seed: u64,
    /// Number of contacts, with all fixtures.
    pub contacts: u64,
    /// Name of the estimate's status ([`Status::name`]).
    pub status: String,
    /// `eᵀ P⁻¹ e` (1) with the errors `e` of the problem's parameters of the arm that have a
    /// standard deviation above 0 and their reported covariance `P`. `None` if `P` is not positive
    /// definite.
    pub nees: Option<f64>,
    /// Number of these parameters.
    pub degrees_of_freedom: u64,
    /// Whether the answer is refused, or `nees` is below the 99.9 % quantile of χ².
    pub honest: bool,
    /// Whether the answer is honest and not refused.
    pub useful: bool,
    /// Root mean square (m) over 1000 joint positions all over the workspace of the distance
    /// between the tool's positions by the true arm with the true tool, and by the calibrated ones,
    /// without load.
    pub tool_error: f64,
    /// Root mean square (m) of the reported standard deviation of the tool's position at the same
    /// joint positions, see [`tool_uncertainty`]. `None` where there is none.
    pub tool_sigma: Option<f64>,
    /// Kinds of the estimate's warnings ([`Warning::kind`](crate::estimate::Warning::kind)), each
    /// once, those that forbid the use of the result first.
    pub warnings: Vec<String>,
}

impl FalsifiedRow {
    /// Whether the answer was not refused: it is usable or doubtful.
    pub fn is_answered(&self) -> bool {
        self.status != Status::NotUsable.name()
    }
}

/// How a trial is drawn and calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FalsifiedOptions {
    /// Seed of the simulation and of what is false.
    pub seed: u64,
    /// Whether effects that contacts contradict are estimated ([`calibrate_with_freed_effects`]).
    pub free_effects: bool,
}

/// Why there is no row.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FalsifiedError {
    /// The trial cannot be simulated, or was broken off meanwhile.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Parts that are not valid.
    #[error(transparent)]
    Parts(#[from] PartsError),
}

/// Simulates a trial of `kind` by `excitation` with about `contacts` contacts (see
/// [`Excitation::scenario`]) and `robot`, an iiwa 14, as the nominal arm, calibrates the problem
/// that declares what is false, and compares the estimate with the truth. The same arguments give
/// the same row; those of other kinds with the same seed have the same truth. `watch` is called
/// again and again; if it breaks, the row is of no use.
///
/// # Errors
/// If the scenario cannot be simulated, or falsified shapes are not valid.
pub fn falsified_trial(
    kind: &FalsifiedKind,
    (excitation, robot, contacts): (Excitation, &Robot, usize),
    options: FalsifiedOptions,
    watch: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<FalsifiedRow, FalsifiedError> {
    let seed = options.seed;
    let mut declared = excitation.scenario(robot.clone(), contacts)?;
    kind.falsification.prepare_scenario(&mut declared)?;
    let mut scenario = declared.clone();
    kind.falsification.falsify_scenario(&mut scenario);
    let truth = sim::draw_truth(&scenario, seed);
    let logs = sim::run(&scenario, &truth, seed, &mut |_| watch())?;
    let simulated = SimulatedTrial { truth, logs };
    let problem = kind.problem(&declared, &simulated, seed)?;
    let truth = &simulated.truth;
    let true_arm = Kinematics::new(&true_robot(&declared.robot, truth), &[], truth.tip_from_tool(&scenario));
    let truth = kind.falsification.relative_truth(truth);
    Ok(answer(kind, (excitation.name(), options), &problem, (&truth, &true_arm), watch))
}

/// The row of the calibration of `problem`, which `kind` falsified, by an excitation of this name;
/// the truth of the arm's parameters, and the true arm with the tool as it truly is.
pub(super) fn answer(
    kind: &FalsifiedKind,
    (excitation, options): (&str, FalsifiedOptions),
    problem: &Problem,
    (truth, true_arm): (&Truth, &Kinematics),
    watch: &mut dyn FnMut() -> ControlFlow<()>,
) -> FalsifiedRow {
    let row = empty(kind, (excitation, options.seed), problem);
    let observe = &mut |_: &Progress| watch();
    let (calibrated, estimate) = if options.free_effects {
        calibrate_with_freed_effects(problem, observe)
    } else {
        (problem.clone(), calibrate(problem, observe))
    };
    let errors = ParameterErrors::new(problem, &estimate, truth);
    compare(row, &calibrated, &estimate, (&errors, true_arm))
}

fn empty(kind: &FalsifiedKind, (excitation, seed): (&str, u64), problem: &Problem) -> FalsifiedRow {
    FalsifiedRow {
        kind: kind.name.to_owned(),
        excitation: excitation.to_owned(),
        seed,
        contacts: problem.contacts.len() as u64,
        status: String::new(),
        nees: None,
        degrees_of_freedom: 0,
        honest: false,
        useful: false,
        tool_error: 0.0,
        tool_sigma: None,
        warnings: Vec::new(),
    }
}

/// The row with the errors of `estimate`, and of the tool against `true_arm`, which holds the tool
/// as it truly does.
fn compare(
    row: FalsifiedRow,
    problem: &Problem,
    estimate: &Estimate,
    (errors, true_arm): (&ParameterErrors, &Kinematics),
) -> FalsifiedRow {
    let nees = errors.nees(&estimate.covariance);
    let answered = estimate.status.is_usable();
    let within = nees.is_some_and(|nees| nees < limit(errors.which.len()));
    let positions = random_positions(&problem.robot, WORKSPACE.0, WORKSPACE.1);
    let found = problem.tool.tip_from_tool * estimate.tool_motion().unwrap_or_else(Pose::identity);
    let found = Kinematics::new(&estimate.robot, &[], found);
    let place = |arm: &Kinematics, q: &[f64]| arm.pose(q).translation.vector;
    let distances = positions.iter().map(|q| (place(true_arm, q) - place(&found, q)).norm());
    let sigmas = tool_uncertainty(problem, estimate, positions.iter().map(Vec::as_slice));
    FalsifiedRow {
        status: estimate.status.name().to_owned(),
        nees,
        degrees_of_freedom: errors.which.len() as u64,
        honest: !answered || within,
        useful: answered && within,
        tool_error: root_mean_square(distances),
        tool_sigma: sigmas.map(|each| root_mean_square(each.iter().map(|tool| tool.position))),
        warnings: estimate.warning_kinds(),
        ..row
    }
}

/// The quantile of χ² that the NEES of `parameters` honest errors is below; everything is where
/// there are none.
fn limit(parameters: usize) -> f64 {
    ChiSquared::new(parameters as f64).map_or(f64::INFINITY, |chi| chi.inverse_cdf(HONEST))
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}
