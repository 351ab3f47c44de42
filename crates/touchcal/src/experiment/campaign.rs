//! Many trials of one scenario: whether uncertainties are true, and how good estimates are.

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};

use super::problem;
use super::transfer::{random_positions, tool_error};
use crate::estimate::{Estimate, Problem, Status, calibrate, cramer_rao};
use crate::robot::{Column, Robot};
use crate::sim::{Scenario, SimulationError, Truth};

/// Shares of intervals that are counted.
pub const LEVELS: [f64; 4] = [0.50, 0.90, 0.95, 0.99];
/// Half widths of these intervals (standard deviations of a normal distribution).
const HALF_WIDTHS: [f64; 4] = [0.674_489_75, 1.644_853_63, 1.959_963_98, 2.575_829_30];
/// Joint positions all over the workspace at which the tool is compared.
const WORKSPACE_POSES: usize = 1000;
/// Their seed.
const WORKSPACE_SEED: u64 = 1;

/// One trial of a campaign, measured against its truth. Counts and averages are over the arm's parameters that were estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CampaignRow {
    /// Number in the campaign.
    pub trial: u64,
    /// Seed that it was simulated with.
    pub seed: u64,
    /// Contacts.
    pub contacts: u64,
    /// 0 converged, 1 not converged, 2 not usable.
    pub status: u64,
    /// Parameters of the arm with a standard deviation.
    pub parameters: u64,
    /// True values within their intervals of each of [`LEVELS`].
    pub inside: [u64; 4],
    /// Normalised estimation error squared `eᵀ P⁻¹ e`: on average the number of parameters, if uncertainties are true.
    pub nees: f64,
    /// The same with the Cramér–Rao bound for `P`: on average the number of parameters, if nothing could be better.
    pub nees_of_bound: f64,
    /// Mean error of strains (none: 0).
    pub strain_error: f64,
    /// Mean error of joint offsets (rad or m).
    pub offset_error: f64,
    /// Mean error of the tool's place (m) over the workspace.
    pub tool_distance: f64,
    /// Mean error of the tool's rotation (rad) over the workspace.
    pub tool_angle: f64,
    /// Measured over declared noise.
    pub noise_factor: f64,
}

/// Simulates and calibrates trial number `trial`, whose seed is `first_seed + trial`.
///
/// # Errors
/// As [`Scenario::simulate`].
pub fn campaign_trial(scenario: &Scenario, first_seed: u64, trial: u64) -> Result<CampaignRow, SimulationError> {
    let seed = first_seed.wrapping_add(trial);
    let simulated = scenario.simulate(seed)?;
    let problem = problem(scenario, &simulated);
    let estimate = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
    let status = match estimate.status {
        Status::Converged => 0,
        Status::NotConverged => 1,
        Status::NotUsable => 2,
    };
    let row = CampaignRow { trial, seed, contacts: problem.contacts.len() as u64, status, ..CampaignRow::default() };
    Ok(measured(row, &problem, &estimate, &simulated.truth))
}

/// The row with what `truth` says of `estimate`.
fn measured(row: CampaignRow, problem: &Problem, estimate: &Estimate, truth: &Truth) -> CampaignRow {
    let known = |k: &usize| {
        let parameter = &estimate.parameters[*k];
        !parameter.parameter.column.block().is_nuisance() && parameter.sigma.is_some_and(|sigma| sigma > 0.0)
    };
    let which: Vec<usize> = (0..estimate.parameters.len()).filter(known).collect();
    let column = |k: usize| estimate.parameters[k].parameter.column;
    let error = |k: usize| estimate.parameters[k].value - truth.value(column(k));
    let errors = DVector::from_iterator(which.len(), which.iter().map(|&k| error(k)));
    let part = |all: &DMatrix<f64>| DMatrix::from_fn(which.len(), which.len(), |i, j| all[(which[i], which[j])]);
    let nees = |covariance: DMatrix<f64>| match covariance.cholesky() {
        Some(factor) => errors.dot(&factor.solve(&errors)),
        None => f64::NAN,
    };
    let inside = HALF_WIDTHS.map(|half_width| {
        let within = |k: &&usize| error(**k).abs() < half_width * estimate.parameters[**k].sigma.unwrap_or(0.0);
        which.iter().filter(within).count() as u64
    });
    let mean_of = |wanted: fn(&Column) -> bool| {
        let errors: Vec<f64> =
            (0..estimate.parameters.len()).filter(|&k| wanted(&column(k))).map(|k| error(k).abs()).collect();
        // An empty sum is −0.
        errors.iter().fold(0.0, |sum, error| sum + error) / errors.len().max(1) as f64
    };
    let bound = cramer_rao(problem, |column| truth.value(column));
    let everywhere = random_positions(&problem.robot, WORKSPACE_POSES, WORKSPACE_SEED);
    let tip_from_tool = problem.tool.tip_from_tool;
    let positions = everywhere.iter().map(Vec::as_slice);
    let tool = tool_error(&true_robot(&problem.robot, truth), &estimate.robot, tip_from_tool, positions);
    CampaignRow {
        parameters: which.len() as u64,
        inside,
        nees: nees(part(&estimate.covariance)),
        nees_of_bound: nees(part(&bound)),
        strain_error: mean_of(|column| matches!(column, Column::Strain | Column::SegmentStrain(_))),
        offset_error: mean_of(|column| matches!(column, Column::JointOffset(_))),
        tool_distance: tool.mean_distance,
        tool_angle: tool.mean_angle,
        noise_factor: estimate.noise_factor,
        ..row
    }
}

fn true_robot(robot: &Robot, truth: &Truth) -> Robot {
    let arm = truth.errors.iter().filter(|(column, _)| !column.block().is_nuisance());
    let (columns, values): (Vec<Column>, Vec<f64>) = arm.copied().unzip();
    robot.calibrated(&columns, &values)
}

/// What all trials of a campaign come to, added up row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignSummary {
    /// Trials.
    pub trials: u64,
    /// Trials called converged; all else is over these.
    pub converged: u64,
    /// Parameters of the arm, over all trials.
    pub parameters: u64,
    /// True values within their intervals.
    pub inside: [u64; 4],
    /// Sums of the rows' values.
    nees: f64,
    nees_of_bound: f64,
    tool_distance: f64,
    tool_angle: f64,
    offset: Histogram,
    strain: Histogram,
}

impl Default for CampaignSummary {
    fn default() -> Self {
        CampaignSummary {
            trials: 0,
            converged: 0,
            parameters: 0,
            inside: [0; 4],
            nees: 0.0,
            nees_of_bound: 0.0,
            tool_distance: 0.0,
            tool_angle: 0.0,
            offset: Histogram::new(),
            strain: Histogram::new(),
        }
    }
}

/// Standard deviations of 99 % bounds.
const BOUND: f64 = HALF_WIDTHS[3];

impl CampaignSummary {
    /// Adds a trial.
    pub fn add(&mut self, row: &CampaignRow) {
        self.trials += 1;
        if row.status != 0 {
            return;
        }
        self.converged += 1;
        self.parameters += row.parameters;
        self.inside.iter_mut().zip(row.inside).for_each(|(sum, inside)| *sum += inside);
        self.nees += row.nees;
        self.nees_of_bound += row.nees_of_bound;
        self.tool_distance += row.tool_distance;
        self.tool_angle += row.tool_angle;
        self.offset.add(row.offset_error);
        self.strain.add(row.strain_error);
    }

    /// Share of true values within the intervals of each of [`LEVELS`].
    pub fn coverage(&self) -> [f64; 4] {
        self.inside.map(|inside| inside as f64 / self.parameters as f64)
    }

    /// Mean NEES over the number of parameters (1 if uncertainties are true), and the 99 % bounds that chance leaves it (χ², normal approximation).
    pub fn nees(&self) -> (f64, [f64; 2]) {
        let chance = BOUND * (2.0 / self.parameters as f64).sqrt();
        (self.nees / self.parameters as f64, [1.0 - chance, 1.0 + chance])
    }

    /// Errors over those of the Cramér–Rao bound, root mean square.
    pub fn over_bound(&self) -> f64 {
        (self.nees_of_bound / self.parameters as f64).sqrt()
    }

    /// Mean error of the tool's place (m) and rotation (rad) over the workspace.
    pub fn tool(&self) -> (f64, f64) {
        (self.tool_distance / self.converged as f64, self.tool_angle / self.converged as f64)
    }

    /// Quantile `share` of the trials' mean error of joint offsets (rad or m), to 1 %.
    pub fn offset_error(&self, share: f64) -> f64 {
        self.offset.quantile(share)
    }

    /// Quantile `share` of the trials' mean error of strains, to 1 %.
    pub fn strain_error(&self, share: f64) -> f64 {
        self.strain.quantile(share)
    }
}

/// Positive numbers counted in bins of 1 %, so that quantiles of a million need no more memory than those of a thousand.
#[derive(Clone, Debug, PartialEq)]
struct Histogram {
    counts: Vec<u64>,
    total: u64,
}

/// Numbers from 1e-12 to 1e3.
const LEAST: f64 = 1e-12;
const BINS_PER_DECADE: f64 = 230.0;
const BINS: usize = 15 * 230;

impl Histogram {
    fn new() -> Self {
        Histogram { counts: vec![0; BINS], total: 0 }
    }

    fn add(&mut self, value: f64) {
        let bin = ((value / LEAST).log10() * BINS_PER_DECADE).max(0.0) as usize;
        self.counts[bin.min(BINS - 1)] += 1;
        self.total += 1;
    }

    fn quantile(&self, share: f64) -> f64 {
        let mut left = (share * self.total as f64).ceil() as u64;
        for (bin, count) in self.counts.iter().enumerate() {
            if left <= *count && self.total > 0 {
                return if bin == 0 { 0.0 } else { LEAST * 10f64.powf((bin as f64 + 0.5) / BINS_PER_DECADE) };
            }
            left -= *count;
        }
        f64::NAN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_sorted_numbers() {
        let mut histogram = Histogram::new();
        (1..=1000).for_each(|k| histogram.add(1e-6 * f64::from(k)));
        for (share, expected) in [(0.5, 500e-6), (0.95, 950e-6), (1.0, 1e-3)] {
            assert!(
                (histogram.quantile(share) / expected - 1.0).abs() < 0.01,
                "{share}: {}",
                histogram.quantile(share)
            );
        }
    }

    #[test]
    fn only_converged_trials_are_averaged() {
        let good =
            CampaignRow { parameters: 8, inside: [4, 7, 8, 8], nees: 8.0, nees_of_bound: 32.0, ..Default::default() };
        let mut summary = CampaignSummary::default();
        summary.add(&good);
        summary.add(&CampaignRow { status: 2, nees: 1e9, ..good });
        assert_eq!((summary.trials, summary.converged), (2, 1));
        assert_eq!(summary.coverage(), [0.5, 0.875, 1.0, 1.0]);
        assert!((summary.nees().0 - 1.0).abs() < 1e-12 && (summary.over_bound() - 2.0).abs() < 1e-12);
    }
}
