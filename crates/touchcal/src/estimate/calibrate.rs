//! The estimator's two stages, and what is made of their minimum.

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};

use super::conclude::conclude;
use super::gradient_descent::{Descent, descend};
use super::identifiability::{Held, held};
use super::learn::learn;
use super::levenberg_marquardt::{Limits, minimise, observer};
use super::loss::Loss;
use super::outcome::{Estimate, Progress, Stage, StopReason, Termination};
use super::problem::{Method, Problem};
use super::rows::Rung;
use super::statistics::SHORT;
use super::system::System;

/// The coarse stage and the descent of the loss's width look at about this many contacts; the end looks at all.
const GLANCE: usize = 250;
/// Searches from the start, each holding what the one before found unbounded.
const ROUNDS: usize = 3;
/// Factor by which more contacts are looked at from stage to stage.
const LADDER: usize = 12;
/// Factor by which the robust loss narrows from step to step.
const NARROWING: f64 = 2.0;

/// About so many contacts say how often walls are touched, at first and at last. From 500 that is so rough that it costs a third of the accuracy.
const LOOKS: [usize; 2] = [750, 3000];
/// Most rounds of learning how often walls are touched, and the change that ends them: from another way there, results then differ by some hundredths of a standard deviation.
const POLISHINGS: usize = 10;
const SETTLED: f64 = 0.04;
/// Share of the one-sided contacts that must tell which walls they touch, so that all are asked.
const TELLING: f64 = 0.3;
/// How noisy walls are taken to be at first, over what is declared. The search begins where the least gaps are; a wall that many contacts rest on may be some standard
/// deviations away there, and must not be given up as one that is never touched.
const NOISY: f64 = 3.0;

const FINE: Limits = Limits { iterations: 60, decrement: 1e-2, close: 0.03 };
const COARSE: Limits = Limits { iterations: 100, decrement: 1e-3, ..FINE };
const NARROW: Limits = Limits { decrement: 1e-1, ..FINE };
/// Walls come and go: the cost of all contacts jumps by more than a step of some standard deviations is worth.
const FINE_WALLS: Limits = Limits { close: 0.1, ..FINE };
/// No nearer: steps of expectation–maximisation lead on, or the next round searches again.
const NEAR_WALLS: Limits = Limits { decrement: SHORT, ..FINE_WALLS };

pub(super) type Observe<'o> = &'o mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// Estimates the parameters of a problem.
///
/// Minimises, from zero, first the distance of all contact poses from their manifolds' envelopes, then
/// `Σ ρ(‖W r(θ)‖²) + Σ (θₖ/σₖ)² + Σ ((dᵢⱼ − d̂ᵢⱼ)/σᵢⱼ)²`, where `r` is a contact's residual, `W` whitens encoder and contact noise, `ρ` is the
/// problem's loss, narrowed in steps from one that is nearly least squares. Parameters without prior that nothing determines are held at zero.
/// `observe` is called at each step and may end the estimation. [`Method::GradientDescent`] goes another way, see [`Descent`].
///
/// The covariance is that of an M-estimator (Huber 1981, section 7.6): `(A²/B · Σ JᵀJ + Λ)⁻¹` with `A` the mean of ψ′, `B` that of ψ² over all contacts and
/// `Λ` the priors; noise above the declared one widens it.
pub fn calibrate(problem: &Problem, observe: Observe<'_>) -> Estimate {
    let mut search = Search::new(problem);
    if let Method::GradientDescent(descent) = problem.method {
        search.descend(&descent, observe);
        return conclude(&search);
    }
    let mut coarse = search.theta.clone();
    for _ in 0..ROUNDS {
        search.coarse(observe);
        if search.hold_unbounded() {
            search.coarse(observe);
        }
        coarse.copy_from(&search.theta);
        search.fine(observe);
        if !search.hold_unbounded() {
            break;
        }
    }
    search.learn(observe);
    search.ambiguous = search.has_other_minima(&coarse, observe);
    search.polish(observe);
    conclude(&search)
}

/// The coarse stage alone: near enough to linearise at.
pub(super) fn coarse<'p>(problem: &'p Problem, observe: Observe<'_>) -> Search<'p> {
    let mut search = Search::new(problem);
    search.coarse(observe);
    if search.hold_unbounded() {
        search.coarse(observe);
    }
    search.system.set_resolution(&search.theta, search.stride());
    search
}

/// An estimation under way.
pub(super) struct Search<'p> {
    pub system: System<'p>,
    /// Each parameter's scale; 0 where it is held at zero.
    pub scale: DVector<f64>,
    pub theta: DVector<f64>,
    pub held: Held,
    /// Share of the one-sided contacts that tell which walls they touch, where that was asked.
    pub telling: Option<f64>,
    /// Other starts led to other minima.
    pub ambiguous: bool,
    pub termination: Termination,
}

impl<'p> Search<'p> {
    fn new(problem: &'p Problem) -> Self {
        let system = System::new(problem);
        let scale = system.scale();
        let theta = DVector::zeros(scale.len());
        let held = Held { pivots: Vec::new(), participants: Vec::new() };
        let termination =
            Termination { reason: StopReason::Converged, measured: 0.0, threshold: FINE.decrement, iterations: 0 };
        Search { system, scale, theta, held, telling: None, ambiguous: false, termination }
    }

    pub(super) fn stride(&self) -> usize {
        self.system.stride(GLANCE)
    }

    pub(super) fn interrupted(&self) -> bool {
        self.termination.reason == StopReason::Interrupted
    }

    /// Minimises from where the search stands, looking at every `stride`-th contact.
    fn minimise(&mut self, (rung, stride): (Rung, usize), limits: Limits, observe: Observe<'_>) {
        if self.interrupted() {
            return;
        }
        let stage = if rung == Rung::Envelope { Stage::Coarse } else { Stage::Fine };
        let mut look = observer(stage, observe);
        // A part's minimum need be no nearer than the part knows it.
        let looseness = if rung == Rung::Envelope { 1.0 } else { stride as f64 };
        let limits = Limits { decrement: limits.decrement * looseness, ..limits };
        let linearize = |theta: &DVector<f64>| self.system.linearize(theta, rung, stride);
        let minimum = minimise(linearize, self.theta.clone(), &self.scale, limits, &mut look);
        let iterations = self.termination.iterations + minimum.termination.iterations;
        self.theta = minimum.theta;
        self.termination = Termination { iterations, ..minimum.termination };
    }

    /// From zero by gradient descent.
    fn descend(&mut self, descent: &Descent, observe: Observe<'_>) {
        self.hold_unbounded();
        let descended = descend(&self.system, &self.scale, descent, observe);
        self.theta = descended.theta;
        self.termination = descended.termination;
    }

    /// From zero towards the envelopes.
    fn coarse(&mut self, observe: Observe<'_>) {
        self.theta.fill(0.0);
        self.minimise((Rung::Envelope, self.stride()), COARSE, observe);
    }

    /// Onto the manifolds, the loss narrowing. One-sided contacts are asked for their walls next, for which a few contacts lead near enough.
    fn fine(&mut self, observe: Observe<'_>) {
        self.glance(observe);
        if !self.system.has_walls() || self.termination.reason != StopReason::Converged {
            self.narrow(observe);
        }
    }

    /// From a few contacts to all.
    fn narrow(&mut self, observe: Observe<'_>) {
        let loss = self.system.problem.loss;
        let mut stride = self.stride() / LADDER;
        while stride > 1 {
            self.minimise((Rung::Residual(loss), stride), NARROW, observe);
            stride /= LADDER;
        }
        self.minimise((Rung::Residual(loss), 1), FINE, observe);
    }

    /// Onto the manifolds with a few contacts.
    pub(super) fn glance(&mut self, observe: Observe<'_>) {
        let loss = self.system.problem.loss;
        self.system.resolution = 0.0;
        let mut widening = self.system.widening(&self.theta, self.stride());
        while widening > 1.0 {
            self.minimise((Rung::Residual(loss.widened(widening)), self.stride()), NARROW, observe);
            widening /= NARROWING;
        }
        self.system.set_resolution(&self.theta, self.stride());
        self.minimise((Rung::Residual(loss), self.stride()), NARROW, observe);
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
        let (theta, held) = (self.theta.clone(), &self.held.pivots);
        let learned = learn(&mut self.system, theta, held, &mut observer(Stage::Fine, observe));
        self.theta = learned.theta;
        self.termination.iterations += learned.linearizations;
        if learned.interrupted {
            self.termination.reason = StopReason::Interrupted;
        }
        for (k, sigma) in self.system.scale().iter().enumerate() {
            if self.scale[k] > 0.0 {
                self.scale[k] = *sigma;
            }
        }
        self.minimise((Rung::Residual(self.system.problem.loss), 1), FINE, observe);
    }

    /// From the coarse stage to where a few contacts see their walls, if they have any.
    pub(super) fn come_near(&mut self, observe: Observe<'_>) {
        if self.system.has_walls() {
            self.glance(observe);
            self.see_walls(observe);
        }
    }

    /// From the least gap of each contact to all walls that it may touch.
    fn polish(&mut self, observe: Observe<'_>) {
        self.see_walls(observe);
        if self.sees_walls() {
            if self.system.problem.noise.learned {
                self.system.noise_factor *= std::mem::replace(&mut self.system.wall_noise, 1.0);
            }
            self.minimise((Rung::Walls, 1), FINE_WALLS, observe);
        } else if self.system.has_walls() {
            self.narrow(observe);
        }
    }

    /// Whether contacts are asked for all walls that they may touch.
    pub(super) fn sees_walls(&self) -> bool {
        self.telling.is_some_and(|share| share > TELLING)
    }

    /// Learns how often walls are touched, and with some contacts finds where they say that is most likely.
    fn see_walls(&mut self, observe: Observe<'_>) {
        let converged = self.termination.reason == StopReason::Converged;
        let asked = converged && self.system.has_walls();
        // Noise learned from least gaps may be far too small: of many walls near, the least hardly scatters.
        self.system.wall_noise = (1.0 / self.system.noise_factor).max(1.0);
        self.telling = asked.then(|| {
            self.system.wall_statistics(&self.theta, self.system.stride(LOOKS[0]), false).telling(&self.system)
        });
        if !self.sees_walls() {
            return;
        }
        self.system.wall_noise *= NOISY;
        let gaps = self.theta.clone();
        for enough in LOOKS {
            let stride = self.system.stride(enough);
            // The fewer, the less they know.
            let settled = SETTLED * LOOKS[1] as f64 / enough as f64;
            for round in 1..=POLISHINGS {
                let learned = self.system.learn_walls(&self.theta, &self.scale, stride);
                self.telling = Some(learned.telling);
                if !self.sees_walls() {
                    // With noise declared much too small, touching nothing at all is likelier than any wall.
                    self.theta = gaps;
                    return;
                }
                // Steps of expectation–maximisation lead down; longer ones are looked at, since walls come and go.
                match learned.step {
                    Some(step) => {
                        self.theta += step;
                        self.termination.iterations += 1;
                        if observer(Stage::Fine, observe)(round, learned.cost).is_break() {
                            self.termination.reason = StopReason::Interrupted;
                        }
                    }
                    None => self.minimise((Rung::Walls, stride), NEAR_WALLS, observe),
                }
                if self.interrupted() {
                    return;
                }
                if learned.change < settled {
                    break;
                }
            }
        }
    }

    /// The parameters' covariance by what all walls say, and how many contacts say as much as one, if they were asked to the end and enough contacts have any.
    pub(super) fn wall_covariance(&self) -> Option<(DMatrix<f64>, f64)> {
        if !self.sees_walls() || self.interrupted() {
            return None;
        }
        let known = self.system.distance_information(&self.theta) + self.system.prior_information();
        let statistics = self.system.wall_statistics(&self.theta, 1, true);
        statistics.covariance(&known, &self.scale, &self.system.odds)
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
        let mut deviation = |i| {
            at.contact(i, Rung::Residual(Loss::Squared), &mut rows);
            rows.squared().sqrt()
        };
        let mut deviations: Vec<f64> = each.map(&mut deviation).collect();
        deviations.sort_unstable_by(f64::total_cmp);
        let ninth = deviations.get(deviations.len() * 9 / 10).copied().unwrap_or(0.0);
        (ninth / k).max(1.0)
    }
}
