//! Trials of one scenario: coverage of intervals, NEES, and errors of estimates.

use std::ops::ControlFlow;

use super::parameter_errors::{ParameterErrors, true_robot};
use super::problem::problem;
use super::tool_error::{random_positions, tool_error};
use crate::estimate::{Estimate, Problem, Status, calibrate, cramer_rao};
use crate::parameter::{Block, ParameterId};
use crate::sim::{self, Scenario, SimulationError, Truth};

/// Nominal probabilities (1) of the two-sided intervals whose coverage is counted: 50, 90, 95 and
/// 99 %.
pub const LEVELS: [f64; 4] = [0.50, 0.90, 0.95, 0.99];
/// Half widths of these intervals (standard deviations of a normal distribution).
pub(super) const HALF_WIDTHS: [f64; 4] = [0.674_489_75, 1.644_853_63, 1.959_963_98, 2.575_829_30];
/// Mean size of a normally distributed number over its standard deviation, √(2/π).
const NORMAL_SIZE: f64 = 0.797_884_560_802_865_4;
/// Joint positions all over the workspace at which the tool is compared.
const WORKSPACE_POSES: usize = 1000;
/// Their seed.
const WORKSPACE_SEED: u64 = 1;

/// One simulated trial of a campaign, measured against its truth: made by [`campaign_trial`].
/// Counts and errors are over parameters of the arm, whatever the status.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CampaignRow {
    /// Number of the trial in the campaign, from 0.
    pub trial: u64,
    /// Seed of the trial's simulation.
    pub seed: u64,
    /// Number of contacts, with all fixtures.
    pub contacts: u64,
    /// Status of the estimate ([`Status`]): 0 usable, 1 doubtful, 2 not usable.
    pub status: u64,
    /// Number of the arm's parameters that have a standard deviation above 0: those that `inside`,
    /// `nees` and `nees_of_bound` are over.
    pub parameters: u64,
    /// Number of these parameters whose true value lies within the interval about the estimate, for
    /// each of [`LEVELS`].
    pub inside: [u64; 4],
    /// Normalised estimation error squared `eᵀ P⁻¹ e` (1; Bar-Shalom, Li & Kirubarajan 2001), with
    /// the errors `e` of the parameters and their estimated covariance `P`: on average the number
    /// of parameters if uncertainties are right. NaN if `P` is not positive definite, 0 without
    /// parameters.
    pub nees: f64,
    /// `eᵀ P⁻¹ e` (1) with the Cramér–Rao bound for `P`, see [`cramer_rao`]: on average the number
    /// of parameters if the estimator is efficient. NaN if the bound is not positive definite, 0
    /// without parameters.
    pub nees_of_bound: f64,
    /// Mean absolute error of the strains among the problem's parameters (1); 0 if there are none.
    pub strain_error: f64,
    /// Mean absolute error of the encoder offsets among the problem's parameters (rad, or m for
    /// prismatic joints); 0 if there are none.
    pub offset_error: f64,
    /// Mean absolute error of the same strains (1) to expect of normally distributed errors at the
    /// Cramér–Rao bound: √(2/π) times the mean standard deviation; 0 if there are none.
    pub strain_bound: f64,
    /// Mean absolute error of the same encoder offsets (rad, or m for prismatic joints) to expect
    /// of normally distributed errors at the Cramér–Rao bound: √(2/π) times the mean standard
    /// deviation; 0 if there are none.
    pub offset_bound: f64,
    /// Mean distance (m) between the tool's positions by the calibrated and by the true arm:
    /// [`tool_error`] at 1000 [`random_positions`], the same in all trials. The tool is at its
    /// nominal pose on both arms: the error of that pose is not in the distance.
    pub tool_distance: f64,
    /// Mean angle (rad) between the tool's orientations by the calibrated and by the true arm, at
    /// the joint positions and with the tool of `tool_distance`.
    pub tool_angle: f64,
    /// Measured over declared standard deviation of the contacts' residuals (1), see
    /// [`Estimate::noise_factor`].
    pub noise_factor: f64,
}

/// Simulates and calibrates trial number `trial`, whose seed is `first_seed + trial` (wrapping
/// around), as the [`problem`](super::problem()) that it poses, and compares the estimate with the
/// truth. The same arguments give the same row.
///
/// # Errors
/// If the scenario cannot be simulated, see [`simulate`](crate::sim::simulate()). A calibration
/// that fails is a row with its status.
pub fn campaign_trial(scenario: &Scenario, first_seed: u64, trial: u64) -> Result<CampaignRow, SimulationError> {
    let seed = first_seed.wrapping_add(trial);
    let simulated = sim::simulate(scenario, seed)?;
    let problem = problem(scenario, &simulated);
    let estimate = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
    let status = match estimate.status {
        Status::Usable => 0,
        Status::Doubtful => 1,
        Status::NotUsable => 2,
    };
    let row = CampaignRow { trial, seed, contacts: problem.contacts.len() as u64, status, ..CampaignRow::default() };
    Ok(compare(row, &problem, &estimate, &simulated.truth))
}

/// True value (SI) of a parameter. Where a hole is wider than its nominal outline, contacts with
/// its walls penetrate the outline by the difference; where it is deeper, contacts with its floor
/// do. Contacts with the rim do neither.
fn true_value(truth: &Truth, id: ParameterId) -> f64 {
    match id {
        ParameterId::DirectionalGapBias(f, direction @ 0..=4) => {
            let errors = if direction < 4 { &truth.clearance } else { &truth.depth };
            -errors.get(f).copied().unwrap_or(0.0)
        }
        _ => truth.value(id),
    }
}

/// The row with the errors of `estimate`.
fn compare(row: CampaignRow, problem: &Problem, estimate: &Estimate, truth: &Truth) -> CampaignRow {
    let errors = ParameterErrors::new(problem, estimate, truth);
    let id = |k: usize| estimate.parameters[k].parameter.id;
    let error = |k: usize| estimate.parameters[k].value - truth.value(id(k));
    let inside = HALF_WIDTHS.map(|half_width| {
        let within = |k: &&usize| error(**k).abs() < half_width * estimate.parameters[**k].sigma.unwrap_or(0.0);
        errors.which.iter().filter(within).count() as u64
    });
    let bound = cramer_rao(problem, |id| true_value(truth, id));
    let is_strain = |k: &usize| matches!(id(*k).block(), Block::Strain | Block::SegmentStrain);
    let (strains, others): (Vec<usize>, Vec<usize>) = (0..estimate.parameters.len()).partition(is_strain);
    let offsets: Vec<usize> = others.into_iter().filter(|&k| id(k).block() == Block::JointOffset).collect();
    // An empty sum is −0.
    let mean = |of: &[usize], size: &dyn Fn(usize) -> f64| {
        of.iter().fold(0.0, |sum, &k| sum + size(k)) / of.len().max(1) as f64
    };
    let size = |k: usize| error(k).abs();
    let at_bound = |k: usize| NORMAL_SIZE * bound[(k, k)].sqrt();
    let workspace = random_positions(&problem.robot, WORKSPACE_POSES, WORKSPACE_SEED);
    let tip_from_tool = problem.tool.tip_from_tool;
    let positions = workspace.iter().map(Vec::as_slice);
    let tool = tool_error(&true_robot(&problem.robot, truth), &estimate.robot, tip_from_tool, positions);
    CampaignRow {
        parameters: errors.which.len() as u64,
        inside,
        nees: errors.nees(&estimate.covariance).unwrap_or(f64::NAN),
        nees_of_bound: errors.nees(&bound).unwrap_or(f64::NAN),
        strain_error: mean(&strains, &size),
        offset_error: mean(&offsets, &size),
        strain_bound: mean(&strains, &at_bound),
        offset_bound: mean(&offsets, &at_bound),
        tool_distance: tool.mean_distance,
        tool_angle: tool.mean_angle,
        noise_factor: estimate.noise_factor,
        ..row
    }
}
