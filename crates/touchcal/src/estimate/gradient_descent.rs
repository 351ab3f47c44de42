//! Gradient descent on mean absolute distances, the search of Negi, Manyar & Gupta (2025, arXiv 2506.17458).
//!
//! Minimises `L(θ) = 1/N · (Σᵢ ‖rᵢ(θ)‖₁ + c · ½ Σₖ (θₖ/σₖ)²)` from zero, with `rᵢ` a contact's residual (m; a projection's angles count as its
//! metric says), `c` the contact noise and `σ` the priors: the posterior of Laplace noise of scale `c`. Steps are in units of each parameter's
//! plausible size, and shrink as half a cosine.

use std::ops::ControlFlow;

use nalgebra::DVector;
use rayon::prelude::*;

use super::loss::Loss;
use super::normal::NormalEquations;
use super::outcome::{Progress, Stage, StopReason, Termination};
use super::rows::{At, ContactRows, Rung};
use super::system::System;
use crate::manifold::MAX_ROWS;

/// Contacts that a manifold is asked for at once.
const BATCH: usize = 256;
/// Adam's memory of slopes and of their squares, and what keeps it from dividing by zero.
const ADAM_SLOPE: f64 = 0.9;
const ADAM_SQUARE: f64 = 0.999;
const ADAM_FLOOR: f64 = 1e-12;
/// No step against the mean gradient of the last tenth of the steps may lower the loss by more than this share. That the loss falls no more
/// would say nothing, as the steps have shrunk.
const SETTLED: f64 = 1e-3;
/// Lengths of the steps tried, in first steps.
const TRIED: [f64; 4] = [1.0, 0.1, 0.01, 0.001];

/// How to descend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Descent {
    /// Which steps are taken.
    pub optimiser: Optimiser,
    /// How many.
    pub steps: usize,
    /// Length of the first step, in plausible sizes of the parameters.
    pub rate: f64,
    /// At most about this many contacts are looked at, evenly spread over the log.
    pub contacts: usize,
}

impl Default for Descent {
    /// Adam, 5000 steps, the first of 5 % of a plausible size, on 500 contacts.
    fn default() -> Self {
        Descent { optimiser: Optimiser::Adam, steps: 5000, rate: 0.05, contacts: 500 }
    }
}

/// Which steps gradient descent takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Optimiser {
    /// Against the gradient; the first one as long as the rate says.
    Plain,
    /// Adam (Kingma & Ba 2015, algorithm 1).
    Adam,
}

/// Where a descent ended.
pub(super) struct Descended {
    pub theta: DVector<f64>,
    pub termination: Termination,
}

/// Descends from zero; parameters of `scale` 0 stay there.
pub(super) fn descend(
    system: &System<'_>,
    scale: &DVector<f64>,
    descent: &Descent,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Descended {
    let stride = system.problem.contacts.len().div_ceil(descent.contacts.max(1)).max(1);
    let mut theta = DVector::zeros(scale.len());
    let mut stepper = Stepper::new(descent.optimiser, scale.len());
    let last_tenth = descent.steps - descent.steps.div_ceil(10);
    let mut mean_slope = DVector::zeros(scale.len());
    let mut last = f64::INFINITY;
    let mut termination =
        Termination { reason: StopReason::Converged, measured: 0.0, threshold: SETTLED, iterations: descent.steps };
    for step in 0..descent.steps {
        let (loss, gradient) = system.absolute(&theta, stride);
        if observe(&Progress { stage: Stage::Descent, iteration: step + 1, cost: loss }).is_break() {
            termination = Termination { reason: StopReason::Interrupted, iterations: step, ..termination };
            return Descended { theta, termination };
        }
        if !loss.is_finite() {
            termination = Termination { reason: StopReason::NotFinite, iterations: step, ..termination };
            return Descended { theta, termination };
        }
        last = loss;
        let slope = gradient.component_mul(scale);
        if step >= last_tenth {
            mean_slope += &slope / (descent.steps - last_tenth) as f64;
        }
        let done = step as f64 / descent.steps as f64;
        let length = descent.rate * 0.5 * (1.0 + (std::f64::consts::PI * done).cos());
        let direction = stepper.direction(&slope);
        theta -= direction.component_mul(scale) * length;
    }
    let down = mean_slope.component_mul(scale) * (-descent.rate / mean_slope.norm().max(f64::MIN_POSITIVE));
    let tried = TRIED.map(|length| system.absolute(&(&theta + &down * length), stride).0);
    termination.measured = 1.0 - tried.into_iter().fold(last, f64::min) / last.max(f64::MIN_POSITIVE);
    if termination.measured.is_nan() || termination.measured > SETTLED {
        termination.reason = StopReason::IterationLimit;
    }
    Descended { theta, termination }
}

/// Turns gradients into steps of about unit length.
struct Stepper {
    optimiser: Optimiser,
    steps: i32,
    /// Length of the first gradient.
    first: f64,
    slope: DVector<f64>,
    square: DVector<f64>,
}

impl Stepper {
    fn new(optimiser: Optimiser, size: usize) -> Self {
        Stepper { optimiser, steps: 0, first: 0.0, slope: DVector::zeros(size), square: DVector::zeros(size) }
    }

    fn direction(&mut self, gradient: &DVector<f64>) -> DVector<f64> {
        self.steps += 1;
        if self.steps == 1 {
            self.first = gradient.norm().max(f64::MIN_POSITIVE);
        }
        if self.optimiser == Optimiser::Plain {
            return gradient / self.first;
        }
        self.slope = &self.slope * ADAM_SLOPE + gradient * (1.0 - ADAM_SLOPE);
        self.square = &self.square * ADAM_SQUARE + gradient.component_mul(gradient) * (1.0 - ADAM_SQUARE);
        let slope_share = 1.0 - ADAM_SLOPE.powi(self.steps);
        let square_share = 1.0 - ADAM_SQUARE.powi(self.steps);
        self.slope
            .zip_map(&self.square, |slope, square| slope / slope_share / ((square / square_share).sqrt() + ADAM_FLOOR))
    }
}

impl System<'_> {
    /// `L` (m) and `∂L/∂θ` of every `stride`-th contact.
    fn absolute(&self, theta: &DVector<f64>, stride: usize) -> (f64, DVector<f64>) {
        let at = self.at(theta);
        let contacts = &self.problem.contacts;
        let mut which: Vec<usize> = (0..contacts.len()).step_by(stride).collect();
        let count = which.len().max(1) as f64;
        which.sort_by_key(|&i| contacts.fixture(i));
        let batches: Vec<&[usize]> = which
            .chunk_by(|&a, &b| contacts.fixture(a) == contacts.fixture(b))
            .flat_map(|of_fixture| of_fixture.chunks(BATCH))
            .collect();
        let parts: Vec<(f64, Vec<f64>)> = batches
            .into_par_iter()
            .map_init(|| at.rows(), |rows, batch| absolute(&at, batch, rows, theta.len()))
            .collect();
        let mut known = NormalEquations::new(theta.len());
        self.add_priors(theta, Rung::Residual(Loss::Squared), &mut known);
        at.add_distances(&mut known);
        let scale = self.problem.noise.contact;
        let mut loss = 0.5 * scale * known.cost;
        let mut gradient = known.gradient * scale;
        for (part, slopes) in parts {
            loss += part;
            gradient += DVector::from_vec(slopes);
        }
        (loss / count, gradient / count)
    }
}

/// `Σ‖r‖₁` (m) of a batch of contacts and its derivatives.
fn absolute(at: &At<'_>, batch: &[usize], rows: &mut ContactRows, parameters: usize) -> (f64, Vec<f64>) {
    let mut gradient = vec![0.0; parameters];
    let mut sum = 0.0;
    let mut cotangent = |_: usize, residual: &[f64], slopes: &mut [f64; MAX_ROWS]| {
        for (slope, value) in slopes.iter_mut().zip(residual) {
            sum += value.abs();
            *slope = if *value == 0.0 { 0.0 } else { value.signum() };
        }
    };
    at.pull_back(batch, &mut cotangent, rows, &mut gradient);
    (sum, gradient)
}
