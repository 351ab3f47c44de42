//! The estimator's two stages, and what is made of their minimum.

use std::ops::ControlFlow;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::identifiability::{Held, Identifiability, held};
use super::learn::learn;
use super::levenberg_marquardt::{Limits, Minimum, minimise, observer};
use super::loss::Loss;
use super::outcome::{
    ContactCount, Estimate, Estimated, Progress, Stage, Status, StopReason, Termination, Verdict, Warning,
};
use super::problem::Problem;
use super::score::score;
use super::system::{Rung, System};
use super::workspace::arm_uncertainty_left;
use crate::robot::Column;

/// The coarse stage and the descent of the loss's width look at about this many contacts; the end looks at all.
const GLANCE: usize = 600;
/// Factor by which the robust loss narrows from step to step.
const NARROWING: f64 = 2.0;
/// A contact whose robust weight falls below this counts as rejected.
const REJECTED_BELOW: f64 = 0.05;
/// Share of rejected contacts that deserves a warning.
const MANY_REJECTED: f64 = 0.2;
/// Measured over declared noise that deserves a warning.
const NOISE_EXCEEDED: f64 = 1.5;
/// A joint range (rad or m) below which its parameters resemble its neighbours'.
const HARDLY_MOVED: f64 = 0.035;
/// A parameter is identifiable if the data bring its standard deviation below this share of what it was.
pub(super) const IDENTIFIABLE_BELOW: f64 = 0.5;
/// A result is usable if the data bring the arm's uncertainty below this share of what it was.
const USABLE_BELOW: f64 = 0.5;
/// Prior standard deviations that deserve a warning.
const FAR_FROM_PRIOR: f64 = 4.0;

const COARSE: Limits = Limits { iterations: 100, decrement: 1e-3 };
const NARROW: Limits = Limits { iterations: 3, decrement: 1e-2 };
const FINE: Limits = Limits { iterations: 60, decrement: 1e-5 };

type Observe<'o> = &'o mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// Estimates the parameters of a problem.
///
/// Minimises, from zero, first the distance of all contact poses from their manifolds' envelopes, then
/// `Σ ρ(‖W r(θ)‖²) + Σ (θₖ/σₖ)² + Σ ((dᵢⱼ − d̂ᵢⱼ)/σᵢⱼ)²`, where `r` is a contact's residual, `W` whitens encoder and contact noise, `ρ` is the
/// problem's loss, narrowed in steps from one that is nearly least squares. Parameters without prior that nothing determines are held at zero.
/// `observe` is called at each step and may end the estimation.
///
/// The covariance is that of an M-estimator (Huber 1981, section 7.6): `(A²/B · Σ JᵀJ + Λ)⁻¹` with `A` the mean of ψ′, `B` that of ψ² over all contacts and
/// `Λ` the priors; noise above the declared one widens it.
pub fn calibrate(problem: &Problem, observe: Observe<'_>) -> Estimate {
    let mut system = System::new(problem);
    let mut scale = system.scale();
    let mut minimum = solve(&mut system, &scale, observe);
    if system.learns() && minimum.termination.reason != StopReason::Interrupted {
        let before = minimum.termination.iterations;
        let learned = learn(&mut system, minimum.theta);
        let mut look = observer(Stage::Fine, observe);
        let rung = Rung::Residual(problem.loss);
        scale = system.scale();
        minimum = minimise(|theta| system.linearize(theta, rung, 1), learned.theta, &scale, FINE, &mut look);
        minimum.termination.iterations += before + learned.linearizations;
    }
    let mut found = Found::new(&system, &minimum.theta);
    let mut holding = found.held(&system, &scale);
    let pivots = holding.pivots.clone();
    if !pivots.is_empty() && minimum.termination.reason != StopReason::Interrupted {
        for &k in &pivots {
            scale[k] = 0.0;
        }
        let before = minimum.termination.iterations;
        minimum = solve(&mut system, &scale, observe);
        minimum.termination.iterations += before;
        found = Found::new(&system, &minimum.theta);
        holding.participants.extend(&pivots);
    }
    conclude(&system, &scale, &minimum, &found, &holding)
}

/// The coarse stage from zero.
pub(super) fn coarse(system: &System<'_>, scale: &DVector<f64>, observe: Observe<'_>) -> Minimum {
    let stride = (system.problem.contacts.len() / GLANCE).max(1);
    let start = DVector::zeros(scale.len());
    let mut look = observer(Stage::Coarse, observe);
    minimise(|theta| system.linearize(theta, Rung::Envelope, stride), start, scale, COARSE, &mut look)
}

/// Both stages from zero.
fn solve(system: &mut System<'_>, scale: &DVector<f64>, observe: Observe<'_>) -> Minimum {
    let stride = (system.problem.contacts.len() / GLANCE).max(1);
    let coarse = coarse(system, scale, observe);
    let mut iterations = coarse.termination.iterations;
    let mut theta = coarse.theta;
    system.set_resolution(&theta, stride);
    let mut look = observer(Stage::Fine, observe);
    let mut widening = system.widening(&theta, stride);
    while widening > 1.0 && coarse.termination.reason != StopReason::Interrupted {
        let rung = Rung::Residual(system.problem.loss.widened(widening));
        let step = minimise(|theta| system.linearize(theta, rung, stride), theta, scale, NARROW, &mut look);
        iterations += step.termination.iterations;
        theta = step.theta;
        if step.termination.reason == StopReason::Interrupted {
            break;
        }
        widening /= NARROWING;
    }
    let rung = Rung::Residual(system.problem.loss);
    let mut fine = minimise(|theta| system.linearize(theta, rung, 1), theta, scale, FINE, &mut look);
    fine.termination.iterations += iterations;
    fine
}

impl System<'_> {
    /// How much wider than the problem's loss to begin, so that nine contacts in ten lie within its width.
    fn widening(&self, theta: &DVector<f64>, stride: usize) -> f64 {
        let k = match self.problem.loss {
            Loss::Squared => return 1.0,
            Loss::Huber(k) | Loss::Cauchy(k) | Loss::GemanMcClure(k) => k,
        };
        let at = self.at(theta);
        let mut rows = at.rows();
        let each = (0..self.problem.contacts.len()).step_by(stride);
        let mut deviations: Vec<f64> =
            each.map(|i| at.contact(i, Rung::Residual(Loss::Squared), &mut rows).sqrt()).collect();
        deviations.sort_unstable_by(f64::total_cmp);
        let ninth = deviations.get(deviations.len() * 9 / 10).copied().unwrap_or(0.0);
        (ninth / k).max(1.0)
    }
}

/// Statistics of the contacts at a minimum.
struct Found {
    /// `A²/B · Σ JᵀJ` of all contacts, and the known distances.
    data: DMatrix<f64>,
    /// Robust weight and deviation of each contact.
    verdicts: Vec<Verdict>,
    noise_factor: f64,
    rows: usize,
}

impl Found {
    fn new(system: &System<'_>, theta: &DVector<f64>) -> Self {
        let loss = system.problem.loss;
        let at = system.at(theta);
        let mut rows = at.rows();
        let (mut slope, mut square, mut count) = (0.0, 0.0, 0);
        let mut verdicts = Vec::with_capacity(system.problem.contacts.len());
        for i in 0..system.problem.contacts.len() {
            let squared = at.contact(i, Rung::Residual(loss), &mut rows);
            let weight = loss.weight(squared);
            let dimension = rows.len();
            count += dimension;
            // ψ(r) = w(s) r with s = ‖r‖²: trace of ψ′ is d·w + 2 s w′.
            slope += dimension as f64 * weight + 2.0 * squared * loss.weight_slope(squared);
            square += weight * weight * squared;
            verdicts.push(if weight < REJECTED_BELOW {
                Verdict::Rejected { deviations: squared.sqrt() }
            } else {
                Verdict::Used { weight }
            });
        }
        let contacts = verdicts.len().max(1);
        let rows = count.max(1) as f64;
        let expected = loss.gaussian_variance((count + contacts / 2) / contacts);
        let (slope, square) = ((slope / rows).max(0.05), square / rows);
        let noise_factor = (square / (slope * slope * expected)).max(0.0).sqrt();
        // Declared noise is a floor: a lucky sample makes nothing more certain.
        let share = 1.0 / (expected * noise_factor.max(1.0).powi(2));
        let data = system.information(theta, share);
        Found { data, verdicts, noise_factor, rows: count }
    }

    fn held(&self, system: &System<'_>, scale: &DVector<f64>) -> Held {
        held(&(&self.data + priors(system)), &system.parameters, scale)
    }
}

pub(super) fn priors(system: &System<'_>) -> DMatrix<f64> {
    let each = system.parameters.iter().map(|p| p.prior_sigma.map_or(0.0, |sigma| sigma.powi(-2)));
    DMatrix::from_diagonal(&DVector::from_iterator(system.parameters.len(), each))
}

/// Puts the outcome together.
fn conclude(system: &System<'_>, scale: &DVector<f64>, minimum: &Minimum, found: &Found, holding: &Held) -> Estimate {
    let problem = system.problem;
    let covariance = covariance(&(&found.data + priors(system)), scale);
    let plausible = system.scale();
    let posterior = posterior(&found.data, &plausible);
    let estimated = system.parameters.iter().enumerate().map(|(k, parameter)| {
        let shrunk = posterior[(k, k)].max(0.0).sqrt() / plausible[k] < IDENTIFIABLE_BELOW;
        let bounded = parameter.prior_sigma.is_some() || !holding.participants.contains(&k);
        Estimated {
            parameter: parameter.clone(),
            value: minimum.theta[k],
            sigma: bounded.then(|| covariance[(k, k)].max(0.0).sqrt()),
            identifiable: shrunk && bounded,
        }
    });
    let parameters: Vec<Estimated> = estimated.collect();
    let columns: Vec<Column> = system.parameters.iter().map(|parameter| parameter.column).collect();
    let rejected = found.verdicts.iter().filter(|verdict| matches!(verdict, Verdict::Rejected { .. })).count();
    let mut estimate = Estimate {
        status: Status::Converged,
        covariance,
        identifiability: Identifiability::new(&found.data, &system.parameters, &plausible),
        prefit: score(problem, &system.at(&DVector::zeros(scale.len()))),
        postfit: score(problem, &system.at(&minimum.theta)),
        contacts: ContactCount { read: problem.contacts.rows_read(), used: found.verdicts.len() - rejected, rejected },
        verdicts: found.verdicts.clone(),
        termination: minimum.termination,
        warnings: Vec::new(),
        noise_factor: found.noise_factor,
        robot: problem.robot.calibrated(&columns, minimum.theta.as_slice()),
        parameters,
    };
    let left = arm_uncertainty_left(problem, &system.parameters, &posterior, &plausible);
    estimate.warnings = warnings(system, found, holding, &estimate, left);
    estimate.status = status(&estimate.termination, &estimate.warnings);
    estimate
}

fn status(termination: &Termination, warnings: &[Warning]) -> Status {
    let unusable =
        |warning: &Warning| matches!(warning, Warning::TooFewContacts { .. } | Warning::ArmUndetermined { .. });
    match termination.reason {
        _ if warnings.iter().any(unusable) => Status::NotUsable,
        StopReason::Converged => Status::Converged,
        _ => Status::NotConverged,
    }
}

fn warnings(system: &System<'_>, found: &Found, holding: &Held, estimate: &Estimate, left: f64) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let without_prior = system.parameters.iter().filter(|parameter| parameter.prior_sigma.is_none()).count();
    let rows = found.rows + system.problem.distances.len();
    if found.verdicts.is_empty() || rows < without_prior {
        warnings.push(Warning::TooFewContacts { rows, parameters: without_prior });
    }
    if left > USABLE_BELOW {
        warnings.push(Warning::ArmUndetermined { left });
    }
    if !holding.pivots.is_empty() {
        let names = holding.pivots.iter().map(|&k| system.parameters[k].name.clone()).collect();
        warnings.push(Warning::Held { names });
    }
    if found.noise_factor > NOISE_EXCEEDED {
        warnings.push(Warning::NoiseExceeded { factor: found.noise_factor });
    }
    let share = estimate.contacts.rejected as f64 / found.verdicts.len().max(1) as f64;
    if share > MANY_REJECTED {
        warnings.push(Warning::ManyRejected { share });
    }
    let contacts = &system.problem.contacts;
    for (i, joint) in system.problem.robot.moving().enumerate() {
        let positions = (0..contacts.len()).map(|c| contacts.q(c)[i]);
        let (least, most) = positions.fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)));
        if most - least < HARDLY_MOVED && !contacts.is_empty() {
            warnings.push(Warning::JointHardlyMoved { joint: joint.name.clone(), range: most - least });
        }
    }
    for estimated in &estimate.parameters {
        if let Some(sigma) = estimated.parameter.prior_sigma {
            let deviations = estimated.value.abs() / sigma;
            if deviations > FAR_FROM_PRIOR {
                warnings.push(Warning::FarFromPrior { name: estimated.parameter.name.clone(), deviations });
            }
        }
    }
    warnings
}

/// Inverse of the information over the parameters that are not held.
pub(super) fn covariance(information: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
    let size = scale.len();
    let scaled = DMatrix::from_fn(size, size, |i, j| {
        let held = scale[i] == 0.0 || scale[j] == 0.0;
        if held { f64::from(u8::from(i == j)) } else { scale[i] * information[(i, j)] * scale[j] }
    });
    let inverse = Cholesky::new(scaled.clone()).map(|cholesky| cholesky.inverse());
    let inverse = inverse.or_else(|| scaled.pseudo_inverse(1e-14).ok()).unwrap_or_else(|| DMatrix::zeros(size, size));
    DMatrix::from_fn(size, size, |i, j| scale[i] * inverse[(i, j)] * scale[j])
}

/// Covariance that the data leave of parameters that had standard deviations `scale` before, all of them.
pub(super) fn posterior(data: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
    let prior = DMatrix::from_diagonal(&scale.map(|sigma| sigma.powi(-2)));
    covariance(&(data + prior), scale)
}
