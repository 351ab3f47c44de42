//! Noise and prior widths learned from the data: empirical Bayes by expectation–maximisation.
//!
//! With the posterior of the linearised problem, mean `x` and covariance `S`, the expected squares give the next widths:
//!
//! - of the noise: `f² ← (Σ w‖r‖² + tr(H_c S)) / Σ w·rows`, with `H_c` the contacts' information;
//! - of a group of `n` parameters: `σ² ← (Σ (xᵢ² + Sᵢᵢ) + n₀ b²) / (n + n₀)`, with `b` the start and `n₀` its strength.
//!
//! Source: Dempster, Laird & Rubin (1977); for this linear-Gaussian case Bishop, *Pattern recognition and machine learning* (2006),
//! section 9.3.4, with the conjugate hyperprior that `n₀` stands for.

use std::ops::ControlFlow;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::normal::NormalEquations;
use super::rows::Rung;
use super::system::System;

/// Linearizations; between them the problem counts as linear.
const LINEARIZATIONS: usize = 5;
/// Expectation–maximisation steps on one linearization.
const STEPS: usize = 12;
/// Relative change of all widths below which they have settled: far less than their own uncertainty.
const SETTLED: f64 = 3e-3;

pub(crate) struct LearnedWidths {
    pub theta: DVector<f64>,
    pub linearizations: usize,
    /// Whether `observe` ended it.
    pub interrupted: bool,
}

impl System<'_> {
    /// Whether any width is to be learned.
    pub fn learns(&self) -> bool {
        let contacts = self.problem.contacts.len();
        contacts > 0 && (self.problem.noise.learned || self.parameters.iter().any(|p| p.learned.is_some()))
    }
}

/// Learns the system's widths around `theta`, which must be near the minimum; returns the parameters that go with them. Parameters
/// `held` stay where they are. `observe` is called at each linearization and may end it.
pub(crate) fn learn(
    system: &mut System<'_>,
    mut theta: DVector<f64>,
    held: &[usize],
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> LearnedWidths {
    let groups = Group::all(system);
    let (mut linearizations, mut interrupted) = (0, false);
    while linearizations < LINEARIZATIONS {
        linearizations += 1;
        let contacts = system.contacts(&theta, Rung::Residual(system.problem.loss), 1).complete();
        let mut known = NormalEquations::new(theta.len());
        system.at(&theta).add_distances(&mut known);
        let linear = Linear { contacts, known: known.complete(), theta: theta.clone(), factor: system.noise_factor };
        interrupted = observe(linearizations, linear.cost(system)).is_break();
        if interrupted {
            break;
        }
        let mut change: f64 = 0.0;
        let mut steps = 0;
        while steps < STEPS {
            let Some((next, covariance)) = linear.posterior(system, held) else { break };
            change = groups.iter().map(|group| group.update(system, &next, &covariance)).fold(0.0, f64::max);
            if system.problem.noise.learned {
                change = change.max(linear.update_noise(system, &next, &covariance));
            }
            theta = next;
            steps += 1;
            if change < SETTLED {
                break;
            }
        }
        if change < SETTLED && steps <= 1 {
            break;
        }
    }
    LearnedWidths { theta, linearizations, interrupted }
}

/// The problem linearised at `theta`, its contacts whitened with noise factor `factor`.
struct Linear {
    contacts: NormalEquations,
    known: NormalEquations,
    theta: DVector<f64>,
    factor: f64,
}

impl Linear {
    /// The cost where it was linearised, of contacts, distances and priors.
    fn cost(&self, system: &System<'_>) -> f64 {
        let mut priors = NormalEquations::new(self.theta.len());
        system.add_priors(&self.theta, Rung::Residual(system.problem.loss), &mut priors);
        self.contacts.cost + self.known.cost + priors.cost
    }

    /// Mean and covariance of the parameters with the system's present widths.
    fn posterior(&self, system: &System<'_>, held: &[usize]) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let share = (self.factor / system.noise_factor).powi(2);
        let mut normal = NormalEquations::new(self.theta.len());
        system.add_priors(&self.theta, Rung::Residual(system.problem.loss), &mut normal);
        normal.information += &self.contacts.information * share + &self.known.information;
        normal.gradient += &self.contacts.gradient * share + &self.known.gradient;
        // Units of the plausible sizes keep metres and radians apart by no more than they are.
        let mut scale = system.scale();
        held.iter().for_each(|&k| scale[k] = 0.0);
        let mut scaled = normal.scaled_information(&scale);
        for k in 0..scale.len() {
            // What nothing determines stays where it is.
            scaled[(k, k)] += 1e-6;
        }
        let inverse = Cholesky::new(scaled)?.inverse();
        let covariance = DMatrix::from_fn(scale.len(), scale.len(), |i, j| scale[i] * inverse[(i, j)] * scale[j]);
        Some((&self.theta - &covariance * &normal.gradient, covariance))
    }

    fn update_noise(&self, system: &mut System<'_>, theta: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
        let step = theta - &self.theta;
        let moved = &self.contacts.information * &step;
        let squares = self.contacts.squares + 2.0 * self.contacts.gradient.dot(&step) + step.dot(&moved);
        let spread = self.contacts.information.dot(covariance);
        let variance = (squares.max(0.0) + spread) / self.contacts.rows.max(1.0);
        let factor = self.factor * variance.sqrt();
        let change = (factor / system.noise_factor).ln().abs();
        system.noise_factor = factor.max(1e-9);
        change
    }
}

/// Parameters that share a learned prior.
struct Group {
    members: Vec<usize>,
    start: f64,
    strength: f64,
}

impl Group {
    fn all(system: &System<'_>) -> Vec<Group> {
        let mut names: Vec<&str> = Vec::new();
        let mut groups: Vec<Group> = Vec::new();
        for (k, parameter) in system.parameters.iter().enumerate() {
            let (Some(learned), Some(start)) = (parameter.learned, parameter.prior_sigma) else { continue };
            if let Some(g) = names.iter().position(|name| *name == learned.group) {
                groups[g].members.push(k);
            } else {
                names.push(learned.group);
                groups.push(Group { members: vec![k], start, strength: learned.strength });
            }
        }
        groups
    }

    /// Takes the group's next width over; returns how much its logarithm changed.
    fn update(&self, system: &mut System<'_>, theta: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
        let squares: f64 = self.members.iter().map(|&k| theta[k] * theta[k] + covariance[(k, k)]).sum();
        let count = self.members.len() as f64 + self.strength;
        let sigma = ((squares + self.strength * self.start * self.start) / count).sqrt();
        let mut change: f64 = 0.0;
        for &k in &self.members {
            let before = system.parameters[k].prior_sigma.replace(sigma);
            change = change.max(before.map_or(0.0, |before| (sigma / before).ln().abs()));
        }
        change
    }
}
