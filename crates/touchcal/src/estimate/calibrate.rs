//! The estimator's two stages, and what is made of their minimum.

use std::ops::ControlFlow;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::identifiability::{Held, Identifiability, held};
use super::learn::learn;
use super::levenberg_marquardt::{Limits, minimise, observer};
use super::loss::Loss;
use super::outcome::{
    ContactCount, Estimate, Estimated, Progress, Stage, Status, StopReason, Termination, Verdict, Warning,
};
use super::problem::Problem;
use super::rows::Rung;
use super::score::score;
use super::system::System;
use super::workspace::arm_uncertainty_left;
use crate::robot::{Column, Parameter};

/// The coarse stage and the descent of the loss's width look at about this many contacts; the end looks at all.
const GLANCE: usize = 400;
/// Searches from the start, each holding what the one before found unbounded.
const ROUNDS: usize = 3;
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
const IDENTIFIABLE_BELOW: f64 = 0.5;
/// A result is usable if the data bring the arm's uncertainty below this share of what it was.
const USABLE_BELOW: f64 = 0.5;
/// An arm's parameter beyond so many plausible sizes is no calibration: strains of 25 %, offsets of 25°.
const IMPLAUSIBLE: f64 = 5.0;
/// Prior standard deviations that deserve a warning.
const FAR_FROM_PRIOR: f64 = 4.0;

const COARSE: Limits = Limits { iterations: 100, decrement: 1e-3 };
const NARROW: Limits = Limits { iterations: 12, decrement: 1e-1 };
const FINE: Limits = Limits { iterations: 60, decrement: 1e-2 };

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
    let mut search = Search::new(problem);
    for _ in 0..ROUNDS {
        search.coarse(observe);
        if search.hold_unbounded() {
            search.coarse(observe);
        }
        search.fine(observe);
        if !search.hold_unbounded() {
            break;
        }
    }
    search.learn(observe);
    search.unbias();
    conclude(&search)
}

/// The coarse stage alone: parameters near enough to linearise at.
pub(crate) fn coarse_system(problem: &Problem) -> (System<'_>, DVector<f64>) {
    let mut search = Search::new(problem);
    search.coarse(&mut |_| ControlFlow::Continue(()));
    (search.system, search.theta)
}

/// An estimation under way.
struct Search<'p> {
    system: System<'p>,
    /// Each parameter's scale; 0 where it is held at zero.
    scale: DVector<f64>,
    theta: DVector<f64>,
    held: Held,
    /// Average effect of one-sided noise that was taken off.
    bias: DVector<f64>,
    termination: Termination,
}

impl<'p> Search<'p> {
    fn new(problem: &'p Problem) -> Self {
        let system = System::new(problem);
        let scale = system.scale();
        let theta = DVector::zeros(scale.len());
        let bias = theta.clone();
        let held = Held { pivots: Vec::new(), participants: Vec::new() };
        let termination =
            Termination { reason: StopReason::Converged, measured: 0.0, threshold: FINE.decrement, iterations: 0 };
        Search { system, scale, theta, held, bias, termination }
    }

    fn stride(&self) -> usize {
        (self.system.problem.contacts.len() / GLANCE).max(1)
    }

    fn interrupted(&self) -> bool {
        self.termination.reason == StopReason::Interrupted
    }

    /// Minimises from where the search stands, looking at every `stride`-th contact.
    fn minimise(&mut self, (rung, stride): (Rung, usize), limits: Limits, observe: Observe<'_>) {
        if self.interrupted() {
            return;
        }
        let stage = if rung == Rung::Envelope { Stage::Coarse } else { Stage::Fine };
        let mut look = observer(stage, observe);
        let linearize = |theta: &DVector<f64>| self.system.linearize(theta, rung, stride);
        let minimum = minimise(linearize, self.theta.clone(), &self.scale, limits, &mut look);
        let iterations = self.termination.iterations + minimum.termination.iterations;
        self.theta = minimum.theta;
        self.termination = Termination { iterations, ..minimum.termination };
    }

    /// From zero towards the envelopes.
    fn coarse(&mut self, observe: Observe<'_>) {
        self.theta.fill(0.0);
        self.minimise((Rung::Envelope, self.stride()), COARSE, observe);
    }

    /// Onto the manifolds, the loss narrowing; all contacts at full resolution at the end only.
    fn fine(&mut self, observe: Observe<'_>) {
        let loss = self.system.problem.loss;
        self.system.resolution = 0.0;
        let mut widening = self.system.widening(&self.theta, self.stride());
        while widening > 1.0 {
            self.minimise((Rung::Residual(loss.widened(widening)), self.stride()), NARROW, observe);
            widening /= NARROWING;
        }
        self.system.set_resolution(&self.theta, self.stride());
        self.minimise((Rung::Residual(loss), self.stride()), NARROW, observe);
        self.minimise((Rung::Residual(loss), 1), FINE, observe);
    }

    /// Holds parameters that neither data nor priors bound at zero; says whether any are new.
    fn hold_unbounded(&mut self) -> bool {
        let rung = Rung::Residual(Loss::Squared);
        let information = self.system.linearize(&self.theta, rung, self.stride()).information;
        let found = held(&information, &self.system.parameters, &self.scale);
        for &k in &found.pivots {
            self.scale[k] = 0.0;
            self.theta[k] = 0.0;
        }
        let new = !found.pivots.is_empty();
        self.held.pivots.extend(found.pivots);
        self.held.participants.extend(found.participants);
        new && !self.interrupted()
    }

    /// Learns the widths that the problem leaves open.
    fn learn(&mut self, observe: Observe<'_>) {
        if !self.system.learns() || self.interrupted() {
            return;
        }
        let learned = learn(&mut self.system, self.theta.clone(), &self.held.pivots);
        self.theta = learned.theta;
        self.termination.iterations += learned.linearizations;
        for (k, sigma) in self.system.scale().iter().enumerate() {
            if self.scale[k] > 0.0 {
                self.scale[k] = *sigma;
            }
        }
        self.minimise((Rung::Residual(self.system.problem.loss), 1), FINE, observe);
    }

    /// Takes the average effect of one-sided noise off.
    fn unbias(&mut self) {
        if self.system.has_noise_bias() && self.termination.reason == StopReason::Converged {
            if let Some(bias) = self.system.noise_bias(&self.theta, &self.scale) {
                self.theta -= &bias;
                self.bias = bias;
            }
        }
    }
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
        let (mut slope, mut square, mut count) = (0.0, 0.0, 0);
        let mut verdicts = Vec::with_capacity(system.problem.contacts.len());
        let (information, norms) = system.statistics(theta);
        for (squared, dimension) in norms {
            let weight = loss.weight(squared);
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
        let data = information * share + system.distance_information(theta);
        Found { data, verdicts, noise_factor, rows: count }
    }
}

/// Puts the outcome together.
fn conclude(search: &Search<'_>) -> Estimate {
    let Search { system, scale, theta, held, bias, termination } = search;
    let problem = system.problem;
    let found = &Found::new(system, theta);
    // A correction is known no better than to its own size.
    let covariance = covariance(&(&found.data + system.prior_information()), scale) + bias * bias.transpose();
    let plausible = system.scale();
    let posterior = posterior(&found.data, &plausible);
    let estimated = system.parameters.iter().enumerate().map(|(k, parameter)| {
        let shrunk = posterior[(k, k)].max(0.0).sqrt() / plausible[k] < IDENTIFIABLE_BELOW;
        let bounded = parameter.prior_sigma.is_some() || !held.participants.contains(&k);
        Estimated {
            parameter: parameter.clone(),
            value: theta[k],
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
        postfit: score(problem, &system.at(theta)),
        contacts: ContactCount { read: problem.contacts.rows_read(), used: found.verdicts.len() - rejected, rejected },
        verdicts: found.verdicts.clone(),
        termination: *termination,
        warnings: Vec::new(),
        noise_factor: found.noise_factor,
        robot: problem.robot.calibrated(&columns, theta.as_slice()),
        parameters,
    };
    let left = arm_uncertainty_left(problem, &system.parameters, &posterior, &plausible);
    estimate.warnings = warnings(system, found, held, &estimate, left);
    estimate.status = status(&estimate.termination, &estimate.warnings);
    estimate
}

fn status(termination: &Termination, warnings: &[Warning]) -> Status {
    let unusable = |warning: &Warning| {
        matches!(
            warning,
            Warning::TooFewContacts { .. } | Warning::ArmUndetermined { .. } | Warning::Implausible { .. }
        )
    };
    match termination.reason {
        _ if warnings.iter().any(unusable) => Status::NotUsable,
        StopReason::Converged => Status::Converged,
        _ => Status::NotConverged,
    }
}

fn warnings(system: &System<'_>, found: &Found, held: &Held, estimate: &Estimate, left: f64) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let without_prior = system.parameters.iter().filter(|parameter| parameter.prior_sigma.is_none()).count();
    let rows = found.rows + system.problem.distances.len();
    if found.verdicts.is_empty() || rows < without_prior {
        warnings.push(Warning::TooFewContacts { rows, parameters: without_prior });
    }
    if left > USABLE_BELOW {
        warnings.push(Warning::ArmUndetermined { left });
    }
    if !held.pivots.is_empty() {
        let names = held.pivots.iter().map(|&k| system.parameters[k].name.clone()).collect();
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
        let Parameter { name, column, scale, .. } = &estimated.parameter;
        if !column.block().is_nuisance() && estimated.value.abs() > IMPLAUSIBLE * scale {
            warnings.push(Warning::Implausible { name: name.clone(), value: estimated.value });
        }
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
fn covariance(information: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
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
fn posterior(data: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
    let prior = DMatrix::from_diagonal(&scale.map(|sigma| sigma.powi(-2)));
    covariance(&(data + prior), scale)
}
