//! Gradient descent on mean absolute distances, the search of Negi, Manyar & Gupta, *Kinematic
//! model optimization via differentiable contact manifold for in-space manipulation* (2025, arXiv
//! 2506.17458).
//!
//! Minimizes `L(θ) = 1/N · (Σᵢ ‖rᵢ(θ)‖₁ + c · ½ Σₖ (θₖ/σₖ)²)` from zero, with `rᵢ` a contact's
//! residual (m; angles of a projection count as its metric says), `c` the contact noise and `σ` the
//! priors: the posterior of Laplace noise of scale `c`. Steps are in units of each parameter's
//! plausible size; their length decreases as half a cosine.

use nalgebra::DVector;
use rayon::prelude::*;

use super::state::SearchState;
use crate::estimate::model::{CalibrationModel, LinearizationPoint, Objective, add_distances, add_priors};
use crate::estimate::options::{GradientDescent, Optimizer};
use crate::estimate::result::{Observer, Progress, Stage};
use crate::manifold::MAX_ROWS;
use crate::robot::KinematicsScratch;
use crate::se3::{Pose, Twist};
use crate::solver::{Adam, AdamMoments, Loss, NormalEquations, StopReason, Termination};

/// Number of contacts whose residuals are evaluated together: the batch of a network.
const BATCH: usize = 256;
/// Decay rates as Kingma & Ba (2015) recommend; gradients are far above this ε.
const ADAM: Adam = Adam { beta1: 0.9, beta2: 0.999, epsilon: 1e-12 };
/// The descent has converged if no step against the mean gradient of its last tenth, and none along
/// the displacement over its second half, lowers the loss by more than this share. That the loss no
/// longer falls would prove nothing, as the steps have shrunk; nor does the gradient in a narrow
/// valley, where it points to the opposite slope.
const TOLERANCE: f64 = 1e-3;
/// Lengths of the steps tried for that, in units of the first step and of that displacement.
const TRIAL_STEPS: [f64; 4] = [1.0, 0.1, 0.01, 0.001];

/// Descends from zero; fixed parameters stay there.
pub(crate) fn descend(search: &mut SearchState<'_>, options: &GradientDescent, observe: Observer<'_>) {
    search.fix_unobservable();
    let (model, scale) = (&search.model, search.free.scale());
    let stride = options.stride(model.problem.contacts.len());
    let mut theta = DVector::zeros(scale.len());
    let mut stepper = Stepper::new(options.optimizer, scale.len());
    let last_tenth = options.steps - options.steps.div_ceil(10);
    let mut mean_gradient = DVector::zeros(scale.len());
    let mut halfway = theta.clone();
    let mut last = f64::INFINITY;
    let mut stopped = None;
    for step in 0..options.steps {
        let (loss, gradient) = mean_absolute(model, &theta, stride);
        if observe(&Progress { stage: Stage::Descent, iteration: step + 1, cost: loss }).is_break() {
            stopped = Some((StopReason::Interrupted, step));
            break;
        }
        if !loss.is_finite() {
            stopped = Some((StopReason::NotFinite, step));
            break;
        }
        last = loss;
        let gradient = gradient.component_mul(scale);
        if step == options.steps / 2 {
            halfway.copy_from(&theta);
        }
        if step >= last_tenth {
            mean_gradient += &gradient / (options.steps - last_tenth) as f64;
        }
        let done = step as f64 / options.steps as f64;
        let length = options.rate * 0.5 * (1.0 + (std::f64::consts::PI * done).cos());
        theta -= stepper.direction(&gradient).component_mul(scale) * length;
    }
    let (reason, iterations, measured) = match stopped {
        Some((reason, step)) => (reason, step, 0.0),
        None => {
            let norm = mean_gradient.norm().max(f64::MIN_POSITIVE);
            let down = mean_gradient.component_mul(scale) * (-options.rate / norm);
            let displacement = &theta - &halfway;
            let tried = [down, displacement]
                .into_iter()
                .flat_map(|direction| TRIAL_STEPS.map(|length| &theta + &direction * length));
            let least = tried.map(|theta| mean_absolute(model, &theta, stride).0).fold(last, f64::min);
            let measured = 1.0 - least / last.max(f64::MIN_POSITIVE);
            let has_converged = measured <= TOLERANCE;
            let reason = if has_converged { StopReason::Converged } else { StopReason::IterationLimit };
            (reason, options.steps, measured)
        }
    };
    search.termination = Termination { reason, measured, threshold: TOLERANCE, iterations };
    search.theta = theta;
}

/// Turns gradients into steps of about unit length.
enum Stepper {
    /// With the norm of the first gradient.
    Plain(Option<f64>),
    Adam(AdamMoments),
}

impl Stepper {
    fn new(optimizer: Optimizer, size: usize) -> Self {
        match optimizer {
            Optimizer::Plain => Stepper::Plain(None),
            Optimizer::Adam => Stepper::Adam(AdamMoments::new(ADAM, size)),
        }
    }

    fn direction(&mut self, gradient: &DVector<f64>) -> DVector<f64> {
        match self {
            Stepper::Plain(first) => gradient / *first.get_or_insert(gradient.norm().max(f64::MIN_POSITIVE)),
            Stepper::Adam(moments) => moments.direction(gradient),
        }
    }
}

/// `L` (m) and `∂L/∂θ` of every `stride`-th contact.
fn mean_absolute(model: &CalibrationModel<'_>, theta: &DVector<f64>, stride: usize) -> (f64, DVector<f64>) {
    let point = LinearizationPoint::new(model, theta);
    let contacts = &model.problem.contacts;
    let mut indices: Vec<usize> = (0..contacts.len()).step_by(stride).collect();
    let count = indices.len().max(1) as f64;
    indices.sort_by_key(|&i| contacts.fixture(i));
    let batches: Vec<&[usize]> = indices
        .chunk_by(|&a, &b| contacts.fixture(a) == contacts.fixture(b))
        .flat_map(|of_fixture| of_fixture.chunks(BATCH))
        .collect();
    let parts: Vec<(f64, Vec<f64>)> = batches
        .into_par_iter()
        .map_init(
            || (vec![0.0; point.dof()], point.scratch()),
            |(q, scratch), batch| sum_absolute(&point, batch, q, scratch),
        )
        .collect();
    let mut declared = NormalEquations::new(theta.len());
    add_priors(model, theta, Objective::Residual(Loss::Squared), &mut declared);
    add_distances(&point, &mut declared);
    let scale = model.problem.noise.contact;
    let mut loss = 0.5 * scale * declared.cost;
    let mut gradient = declared.gradient * scale;
    for (part, slopes) in parts {
        loss += part;
        gradient += DVector::from_vec(slopes);
    }
    (loss / count, gradient / count)
}

/// `Σ‖r‖₁` (m) of contacts with one fixture and its derivatives, by reverse mode through the
/// manifold.
fn sum_absolute(
    point: &LinearizationPoint<'_>,
    batch: &[usize],
    q: &mut [f64],
    scratch: &mut KinematicsScratch,
) -> (f64, Vec<f64>) {
    let model = point.model;
    let mut gradient = vec![0.0; model.layout.len()];
    let Some(&first) = batch.first() else { return (0.0, gradient) };
    let f = model.problem.contacts.fixture(first);
    let mut sum = 0.0;
    let mut cotangent = |_: usize, residual: &[f64], slopes: &mut [f64; MAX_ROWS]| {
        for (slope, value) in slopes.iter_mut().zip(residual) {
            sum += value.abs();
            *slope = if *value == 0.0 { 0.0 } else { value.signum() };
        }
    };
    let poses: Vec<Pose> = batch.iter().map(|&i| point.pose(i, q)).collect();
    let mut twists = vec![Twist::zeros(); poses.len()];
    model.problem.fixtures[f].manifold.pull_back(&poses, model.noise.resolution, &mut cotangent, &mut twists);
    for ((&i, pose), twist) in batch.iter().zip(&poses).zip(&twists) {
        point.pose_and_jacobian(i, q, scratch);
        let fixture_motion = point.fixture_motion(i, pose);
        for &k in &model.layout.dependencies[f] {
            gradient[k] += twist.dot(&point.tool_motion((k, i), fixture_motion.as_ref(), scratch));
        }
    }
    (sum, gradient)
}
