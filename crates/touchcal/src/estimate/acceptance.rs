//! Whether the calibrated tool is within a tolerance where it works.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::problem::{Fixture, Problem};
use super::result::{
    Acceptance, AcceptanceResult, Decision, ErrorFrame, Estimate, Evaluation, PredictiveCheck, TaskErrors,
};
use super::uncertainty::{CalibratedTool, ToolMotion};

/// Draws from the posterior; the probability of an event of 95 % is known to ±0.5 %.
const DRAWS: usize = 2000;
const SEED: u64 = 0xACCE_97ED;

/// Whether `estimate`, one of `problem`, reaches what `asked` asks of it; whatever
/// [`Problem::acceptance`] asks.
///
/// The error of arm and tool is Gaussian with the covariance of the estimate, about the encoder
/// harmonics that the calibrated arm cannot correct, and moves the tool as far as its derivatives
/// say. The largest error over the poses of the task is drawn from it: a pass is one with the
/// confidence asked for after errors are enlarged by the ratio of found to predicted scatter, and
/// contacts that were held out do not contradict the estimate; a fail has the same confidence
/// without.
pub fn acceptance(asked: &Acceptance, problem: &Problem, estimate: &Estimate) -> AcceptanceResult {
    let held_out_agrees = estimate.held_out.as_ref().and_then(Evaluation::agrees);
    let is_usable = estimate.status.is_usable();
    let undecided = AcceptanceResult { decision: Decision::Undecided, is_usable, errors: None, held_out_agrees };
    if !is_usable || asked.positions.is_empty() {
        return undecided;
    }
    let known = CalibratedTool::new(problem, estimate).filter(|tool| !tool.parameters.is_empty());
    let Some(tool) = known else { return undecided };
    // The covariance is wider by the widening already.
    let missing = |check: &PredictiveCheck| (check.ratio / check.widening).max(1.0);
    let ratio = estimate.predictive_check.as_ref().map_or(1.0, missing);
    let task = TaskErrorDistribution::new(asked, &tool, asked.frame);
    let root = root(&tool.covariance);
    let largest = task.largest_errors(&root);
    let probability = within(asked, &largest, ratio);
    let aligned_probability = match asked.frame {
        ErrorFrame::BaseAligned => Some(probability),
        ErrorFrame::Base if asked.positions.len() < Acceptance::MIN_ALIGNED => None,
        ErrorFrame::Base => {
            let aligned = TaskErrorDistribution::new(asked, &tool, ErrorFrame::BaseAligned);
            Some(within(asked, &aligned.largest_errors(&root), ratio))
        }
    };
    // Contacts that were held out may show errors that the covariance lacks.
    let decision = if probability >= asked.confidence && held_out_agrees != Some(false) {
        Decision::Pass
    } else if within(asked, &largest, 1.0) <= 1.0 - asked.confidence {
        Decision::Fail
    } else {
        Decision::Undecided
    };
    let quantile = |part: fn(&(f64, f64)) -> f64| {
        let mut values: Vec<f64> = largest.iter().map(part).collect();
        values.sort_unstable_by(f64::total_cmp);
        values[((asked.confidence * DRAWS as f64).ceil() as usize).clamp(1, DRAWS) - 1]
    };
    let (worst_pose, column, share) = task.worst(asked);
    let parameter = tool.parameters.get(column).map_or_else(String::new, |entry| entry.parameter.name.clone());
    let errors = TaskErrors {
        probability,
        distance: quantile(|error| error.0),
        angle: quantile(|error| error.1),
        worst_pose,
        parameter,
        share,
        aligned_probability,
        base_is_located: problem.fixtures.iter().any(Fixture::is_located),
    };
    AcceptanceResult { decision, is_usable, errors: Some(errors), held_out_agrees }
}

/// Share of the draws of the largest distance (m) and angle (rad) that are within what is asked
/// for if errors are `ratio` times as large.
fn within(asked: &Acceptance, largest: &[(f64, f64)], ratio: f64) -> f64 {
    let is_within = |&&(distance, angle): &&(f64, f64)| {
        ratio * distance <= asked.distance && asked.angle.is_none_or(|most| ratio * angle <= most)
    };
    largest.iter().filter(is_within).count() as f64 / largest.len() as f64
}

/// Errors of the tool in the poses of a task, by those of the parameters.
struct TaskErrorDistribution {
    motion: ToolMotion,
    /// Mean (SI) of the parameters' errors in the calibrated arm.
    mean: DVector<f64>,
    /// Covariance of the parameters (SI).
    covariance: DMatrix<f64>,
}

impl TaskErrorDistribution {
    fn new(asked: &Acceptance, tool: &CalibratedTool, frame: ErrorFrame) -> Self {
        let motion = tool.motion(&asked.positions, frame);
        TaskErrorDistribution { motion, mean: tool.encoder_errors(), covariance: tool.covariance.clone() }
    }

    /// Largest distance (m) and largest angle (rad) over the poses in each draw of the parameters,
    /// with a square `root` of their covariance.
    fn largest_errors(&self, root: &DMatrix<f64>) -> Vec<(f64, f64)> {
        let motions = &self.motion.derivatives * root;
        let mean = &self.motion.derivatives * &self.mean;
        let mut random = Pcg64::seed_from_u64(SEED);
        let mut draw = || {
            let z = DVector::from_fn(motions.ncols(), |_, _| StandardNormal.sample(&mut random));
            let twists = &mean + &motions * z;
            let norm = |from: usize| twists.rows(from, 3).norm();
            let poses = (0..twists.nrows()).step_by(6);
            poses.fold((0.0, 0.0), |(distance, angle), row| {
                (f64::max(distance, norm(row)), f64::max(angle, norm(row + 3)))
            })
        };
        (0..DRAWS).map(|_| draw()).collect()
    }

    /// The pose with the largest variance in units of the tolerance, the parameter that would take
    /// away most of that variance if it were known, and the share it would take away.
    fn worst(&self, asked: &Acceptance) -> (usize, usize, f64) {
        let weight = |row: usize| match (row % 6, asked.angle) {
            (0..3, _) => asked.distance.recip(),
            (_, Some(angle)) => angle.recip(),
            (_, None) => 0.0,
        };
        let weighted = DMatrix::from_fn(self.motion.derivatives.nrows(), self.motion.derivatives.ncols(), |row, k| {
            weight(row) * self.motion.derivatives[(row, k)]
        });
        let moved = &weighted * &self.covariance;
        let variance =
            |pose: usize| (6 * pose..6 * pose + 6).map(|row| moved.row(row).dot(&weighted.row(row))).sum::<f64>();
        let greatest = |values: &mut dyn Iterator<Item = f64>| {
            values.enumerate().fold((0, 0.0), |best, one| if one.1 > best.1 { one } else { best })
        };
        let (pose, all) = greatest(&mut (0..weighted.nrows() / 6).map(variance));
        let of_parameter = |k: usize| match self.covariance[(k, k)] {
            known if known > 0.0 => moved.view((6 * pose, k), (6, 1)).norm_squared() / known,
            _ => 0.0,
        };
        let (column, own) = greatest(&mut (0..weighted.ncols()).map(of_parameter));
        (pose, column, if all > 0.0 { own / all } else { 0.0 })
    }
}

/// A square root `L` of a covariance: `L Lᵀ = Σ`; negative eigenvalues of its correlations count as
/// 0.
fn root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let sigma = covariance.diagonal().map(|variance| if variance > 0.0 { variance.sqrt() } else { 0.0 });
    let inverse = sigma.map(|sigma| if sigma > 0.0 { sigma.recip() } else { 0.0 });
    let correlations = DMatrix::from_diagonal(&inverse) * covariance * DMatrix::from_diagonal(&inverse);
    let eigen = correlations.symmetric_eigen();
    let widths = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    DMatrix::from_diagonal(&sigma) * eigen.eigenvectors * DMatrix::from_diagonal(&widths)
}
