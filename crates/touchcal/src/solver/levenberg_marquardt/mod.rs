//! Levenberg–Marquardt on normal equations.
//!
//! The damping is Levenberg's, in units of each parameter's scale, so that directions the data do
//! not determine stay where they are; its update follows Madsen, Nielsen & Tingleff, *Methods for
//! non-linear least squares problems* (2004), section 3.2.
//!
//! Far from the minimum a step is judged by the cost. Close to it, by the gradient: a step is good
//! if the next one, from the same matrix, is shorter (the natural monotonicity test: Deuflhard,
//! *Newton methods for nonlinear problems* (2004), section 3.3). The gradient takes the variances
//! that whiten the rows as constants, as it must for its root to be unbiased, so the cost of many
//! contacts has its minimum elsewhere; and where the nearest feature of a contact changes the cost
//! jumps, by as much however many contacts there are.

use std::ops::ControlFlow;

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::free_parameters::FreeParameters;
use super::normal_equations::{DampedInformation, NormalEquations};
use super::termination::{StopReason, Termination};

/// When Levenberg–Marquardt (Madsen, Nielsen & Tingleff 2004) stops, and how it judges steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevenbergMarquardtOptions {
    /// Number of linearizations, the one at the start and those at rejected steps included, from
    /// which no further step is begun; with 0 or 1 there is none, unless the start is the minimum.
    pub max_iterations: usize,
    /// Newton decrement `gᵀH⁻¹g` (1, > 0, in units of the cost) at or below which the minimum is
    /// reached, with half the cost's gradient `g` and the information `H`; that last step is still
    /// taken if it descends. 1e-2 is a tenth of a standard deviation.
    pub decrement: f64,
    /// A step is judged by the gradient (natural monotonicity test: Deuflhard 2004), not by the
    /// cost, if it moves the whitened rows by less than this (1, ≥ 0, root mean square): a share of
    /// their noise. At 0 the cost judges all steps.
    pub gradient_test_below: f64,
}

/// Where no step descends, a decrement of up to this many times the limit still counts as the
/// minimum: gaps have kinks, on which a step predicted from one side is lost on the other.
pub(crate) const KINK_TOLERANCE: f64 = 10.0;
/// Smallest and largest share of a step that is tried before the damping grows.
const MIN_STEP_SHARE: f64 = 0.05;
const MAX_STEP_SHARE: f64 = 0.5;
/// Initial damping, its least value, that after a first failure, and the largest, relative to the
/// largest entry of the scaled information: from a Gauss–Newton step to none at all.
const INITIAL_DAMPING: f64 = 1e-9;
const MIN_DAMPING: f64 = 1e-14;
const FIRST_DAMPING: f64 = 1e-6;
const MAX_DAMPING: f64 = 1e6;
/// Growth of the damping after a first failure; it doubles with each failure in a row.
const DAMPING_GROWTH: f64 = 4.0;

/// The end of a minimization: the parameters there, and why it stopped.
pub(crate) struct Minimum {
    /// Parameters (SI), in the order of the problem.
    pub theta: DVector<f64>,
    /// Why the minimization stopped.
    pub termination: Termination,
}

/// A step that was tried: where it ends, the normal equations there, and its [`gain`].
struct Trial {
    theta: DVector<f64>,
    normal: NormalEquations,
    gain: f64,
}

/// The step (SI) that a minimization would try first, and its Newton decrement (1); `None` where
/// the information is not positive definite.
pub(crate) fn first_step(normal: &NormalEquations, free: &FreeParameters) -> Option<(DVector<f64>, f64)> {
    let damped = normal.damped(free, INITIAL_DAMPING * largest_information(normal, free))?;
    let step = damped.step(&normal.gradient);
    let decrement = -normal.gradient.dot(&step);
    Some((step, decrement))
}

/// Minimizes a cost given by its normal equations over the free parameters, from `theta` (SI, one
/// entry for each parameter). `observe` is called with the number of linearizations and the cost
/// before each step and may end the search: the parameters are then those reached so far.
pub(crate) fn minimize(
    mut linearize: impl FnMut(&DVector<f64>) -> NormalEquations,
    mut theta: DVector<f64>,
    free: &FreeParameters,
    options: LevenbergMarquardtOptions,
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Minimum {
    let mut normal = linearize(&theta);
    let largest = largest_information(&normal, free);
    let mut damping = INITIAL_DAMPING;
    let mut growth = DAMPING_GROWTH;
    let mut decrement = f64::INFINITY;
    let mut iterations = 1;
    let reason = loop {
        if observe(iterations, normal.cost).is_break() {
            break StopReason::Interrupted;
        }
        if !normal.cost.is_finite() {
            break StopReason::NotFinite;
        }
        let Some(damped) = normal.damped(free, damping * largest) else {
            damping *= growth;
            growth *= 2.0;
            if damping > MAX_DAMPING {
                break StopReason::NoDescent;
            }
            continue;
        };
        let step = damped.step(&normal.gradient);
        decrement = -normal.gradient.dot(&step);
        if iterations >= options.max_iterations && decrement > options.decrement {
            break StopReason::IterationLimit;
        }
        let mut attempt = |share: f64| {
            iterations += 1;
            let candidate = &theta + &step * share;
            let next = linearize(&candidate);
            let gain = gain((&normal, &next), &damped, decrement, options.gradient_test_below);
            Trial { theta: candidate, normal: next, gain }
        };
        let mut trial = attempt(1.0);
        if trial.gain.is_finite() && trial.gain <= 0.0 {
            // Too long for the curvature: shorten to the minimum of the parabola through both ends.
            trial = attempt((1.0 / (2.0 - trial.gain)).clamp(MIN_STEP_SHARE, MAX_STEP_SHARE));
        }
        if trial.normal.cost.is_finite() && trial.gain > 0.0 {
            theta = trial.theta;
            normal = trial.normal;
            damping = (damping * (1.0 - (2.0 * trial.gain - 1.0).powi(3)).max(0.1)).max(MIN_DAMPING);
            growth = DAMPING_GROWTH;
        } else if decrement <= KINK_TOLERANCE * options.decrement {
            break StopReason::Converged;
        } else {
            damping = (damping * growth).max(FIRST_DAMPING);
            growth *= 2.0;
        }
        if decrement <= options.decrement {
            break StopReason::Converged;
        }
        if damping > MAX_DAMPING {
            break StopReason::NoDescent;
        }
    };
    let termination = Termination { reason, measured: decrement, threshold: options.decrement, iterations };
    Minimum { theta, termination }
}

/// Largest entry (1) of the scaled information, by which damping is measured.
fn largest_information(normal: &NormalEquations, free: &FreeParameters) -> f64 {
    free.scaled(&normal.information).diagonal().max().max(f64::MIN_POSITIVE)
}

/// Measured over predicted progress of a step: 1 is all of it, above 0 is progress.
fn gain(
    (before, after): (&NormalEquations, &NormalEquations),
    damped: &DampedInformation,
    decrement: f64,
    gradient_test_below: f64,
) -> f64 {
    if decrement <= gradient_test_below.powi(2) * before.rows {
        1.0 - damped.decrement(&after.gradient) / decrement
    } else {
        (before.cost - after.cost) / decrement
    }
}

#[cfg(test)]
mod nist;
