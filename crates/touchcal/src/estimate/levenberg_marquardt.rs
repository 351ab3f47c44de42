//! Levenberg–Marquardt on normal equations.
//!
//! The damping is Levenberg's, in units of each parameter's scale, so that directions the data cannot see stay where they are;
//! its update follows Madsen, Nielsen & Tingleff, *Methods for non-linear least squares problems* (2004), section 3.2.
//!
//! Far from the minimum a step is judged by the cost. Close to it, by the gradient: a step is good if the next one, from the same matrix, is
//! shorter (the natural monotonicity test: Deuflhard, *Newton methods for nonlinear problems* (2004), section 3.3). The gradient takes the
//! variances that rows are whitened with as constants, as it must for its root to be unbiased, so the cost of many contacts has
//! its minimum elsewhere; and where a contact's nearest feature changes the cost jumps, by as much however many contacts there are.

use std::ops::ControlFlow;

use nalgebra::DVector;

use super::normal::{Damped, NormalEquations};
use super::outcome::{Progress, Stage, StopReason, Termination};

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Most linearizations.
    pub iterations: usize,
    /// Newton decrement `gᵀH⁻¹g` (in units of the cost) below which the minimum is reached, and that last step
    /// is still taken if it descends: 1e-2 is a tenth of a standard deviation.
    pub decrement: f64,
    /// The minimum is close if a step moves rows by less than this share of their noise (root mean square).
    pub close: f64,
}

/// Where no step descends, a decrement up to this many times the limit still counts as the minimum: gaps have kinks, on which a
/// step predicted from one side is lost on the other.
const ON_A_KINK: f64 = 10.0;

/// Shortest share of a step that is tried before the damping grows.
const SHORTEST_SHARE: f64 = 0.05;
/// Smallest damping, that of a first failure and the largest, relative to the largest entry of the scaled information.
const LEAST_DAMPING: f64 = 1e-14;
const FIRST_DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e6;

/// A minimisation's end.
pub(crate) struct Minimum {
    pub theta: DVector<f64>,
    pub termination: Termination,
}

/// Minimises a cost given by its normal equations from `theta`. Parameters with `scale` 0 are held.
pub(crate) fn minimise(
    mut linearize: impl FnMut(&DVector<f64>) -> NormalEquations,
    mut theta: DVector<f64>,
    scale: &DVector<f64>,
    limits: Limits,
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Minimum {
    let mut normal = linearize(&theta);
    let largest = normal.scaled_information(scale).diagonal().max().max(f64::MIN_POSITIVE);
    let mut damping = 1e-9;
    let mut growth = 4.0;
    let mut decrement = f64::INFINITY;
    let mut iterations = 1;
    let reason = loop {
        if observe(iterations, normal.cost).is_break() {
            break StopReason::Interrupted;
        }
        if !normal.cost.is_finite() {
            break StopReason::NotFinite;
        }
        let Some(damped) = normal.damped(scale, damping * largest) else {
            damping *= growth;
            growth *= 2.0;
            if damping > MOST_DAMPING {
                break StopReason::NoDescent;
            }
            continue;
        };
        let step = damped.step(&normal.gradient);
        decrement = -normal.gradient.dot(&step);
        if iterations >= limits.iterations && decrement > limits.decrement {
            break StopReason::IterationLimit;
        }
        let mut attempt = |share: f64| {
            iterations += 1;
            let candidate = &theta + &step * share;
            let next = linearize(&candidate);
            let gain = gain(&normal, &next, &damped, decrement, limits.close);
            (candidate, next, gain)
        };
        let mut tried = attempt(1.0);
        if tried.2.is_finite() && tried.2 <= 0.0 {
            // Too long for the curvature: as far as the parabola through both ends says.
            tried = attempt((1.0 / (2.0 - tried.2)).clamp(SHORTEST_SHARE, 0.5));
        }
        let (candidate, next, gain) = tried;
        if next.cost.is_finite() && gain > 0.0 {
            theta = candidate;
            normal = next;
            damping = (damping * (1.0 - (2.0 * gain - 1.0).powi(3)).max(0.1)).max(LEAST_DAMPING);
            growth = 4.0;
        } else if decrement <= ON_A_KINK * limits.decrement {
            break StopReason::Converged;
        } else {
            damping = (damping * growth).max(FIRST_DAMPING);
            growth *= 2.0;
        }
        if decrement <= limits.decrement {
            break StopReason::Converged;
        }
        if damping > MOST_DAMPING {
            break StopReason::NoDescent;
        }
    };
    let termination = Termination { reason, measured: decrement, threshold: limits.decrement, iterations };
    Minimum { theta, termination }
}

/// How much of a step's promise came true: 1 is all of it, above 0 is progress.
fn gain(normal: &NormalEquations, next: &NormalEquations, damped: &Damped, decrement: f64, close: f64) -> f64 {
    if decrement <= close.powi(2) * normal.rows {
        1.0 - damped.decrement(&next.gradient) / decrement
    } else {
        (normal.cost - next.cost) / decrement
    }
}

/// Reports progress of one stage to the caller's observer.
pub(crate) fn observer<'o>(
    stage: Stage,
    observe: &'o mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> impl FnMut(usize, f64) -> ControlFlow<()> + 'o {
    move |iteration, cost| observe(&Progress { stage, iteration, cost })
}

#[cfg(test)]
mod nist;
