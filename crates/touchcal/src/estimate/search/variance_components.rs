//! Noise and prior widths estimated from the data: empirical Bayes by expectation–maximisation.
//!
//! With the posterior of the linearized problem, mean `x` and covariance `S`, the expected squares
//! give the next standard deviations:
//!
//! - of the noise: `f² ← (Σ w‖r‖² + tr(H_c S)) / Σ w·rows`, with `H_c` the contacts' information;
//! - of a group of `n` parameters: `σ² ← (Σ (xᵢ² + Sᵢᵢ) + n₀ b²) / (n + n₀)`, with `b` the start
//!   and `n₀` its strength.
//!
//! Source: Dempster, Laird & Rubin, *Maximum likelihood from incomplete data via the EM algorithm*
//! (1977); for this linear-Gaussian case Bishop, *Pattern recognition and machine learning* (2006),
//! section 9.3.4, with the conjugate hyperprior that `n₀` stands for.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::state::SearchState;
use crate::estimate::model::{
    CalibrationModel, LinearizationPoint, Objective, PriorGroup, add_distances, add_priors, contact_equations,
};
use crate::estimate::result::{Observer, Progress, Stage};
use crate::parameter::Prior;
use crate::solver::{FreeParameters, NormalEquations, StopReason};

/// Added to the scaled information, so that what nothing determines stays where it is.
const REGULARIZATION: f64 = 1e-6;
/// Smallest factor of the noise: exact data.
const MIN_NOISE_FACTOR: f64 = 1e-9;

/// Estimates the variance components of the problem around the present parameters, which must be
/// near the minimum, and minimizes again. Does nothing if there are none.
pub(crate) fn estimate_variance_components(search: &mut SearchState<'_>, observe: Observer<'_>) {
    if !has_variance_components(&search.model) || search.is_interrupted() {
        return;
    }
    iterate(search, observe);
    let scale = search.model.layout.scale();
    search.free.rescale(&scale);
    let objective = Objective::Residual(search.model.problem.loss);
    let stride = stride(&search.model);
    let options = if stride == 1 { search.options().fine } else { search.options().anneal };
    search.minimize(objective, stride, options, observe);
}

fn has_variance_components(model: &CalibrationModel<'_>) -> bool {
    let is_component = |prior: &Prior| matches!(prior, Prior::VarianceComponent { .. });
    let of_prior = model.layout.parameters.iter().any(|parameter| is_component(&parameter.prior));
    !model.problem.contacts.is_empty() && (model.problem.noise.is_estimated || of_prior)
}

/// Difference of the indices of successive contacts from which the components are estimated. The
/// noise of one-sided contacts is estimated again with their contact modes: a subsample suffices.
fn stride(model: &CalibrationModel<'_>) -> usize {
    let is_estimated_again = model.has_one_sided_contacts() && model.problem.noise.is_estimated;
    if is_estimated_again { model.stride(model.problem.options.contact_mode.em_subsample[0]) } else { 1 }
}

/// Alternates between linearizations and expectation–maximisation on them.
fn iterate(search: &mut SearchState<'_>, observe: Observer<'_>) {
    let options = search.model.problem.options.variance_components;
    let groups = PriorGroup::variance_components(&search.model.layout);
    for iteration in 1..=options.max_linearizations {
        search.termination.iterations += 1;
        let linear = LinearizedProblem::new(search);
        let cost = linear.cost(&search.model);
        if observe(&Progress { stage: Stage::Fine, iteration, cost }).is_break() {
            search.termination.reason = StopReason::Interrupted;
            return;
        }
        let mut change: f64 = 0.0;
        let mut steps = 0;
        while steps < options.max_em_steps {
            let Some((mean, covariance)) = linear.posterior(&search.model, &search.free) else { break };
            change = 0.0;
            for group in &groups {
                let sigma = group.m_step(&mean, &covariance);
                for &k in &group.members {
                    change = change.max(search.model.layout.set_prior_sigma(k, sigma));
                }
            }
            if search.model.problem.noise.is_estimated {
                let factor = linear.noise_factor(&mean, &covariance);
                change = change.max((factor / search.model.noise.factor).ln().abs());
                search.model.noise.factor = factor.max(MIN_NOISE_FACTOR);
            }
            search.theta = mean;
            steps += 1;
            if change < options.tolerance {
                break;
            }
        }
        if change < options.tolerance && steps <= 1 {
            return;
        }
    }
}

/// The problem linearized at `theta`, its contacts whitened with noise factor `factor`.
struct LinearizedProblem {
    contacts: NormalEquations,
    distances: NormalEquations,
    theta: DVector<f64>,
    factor: f64,
}

impl LinearizedProblem {
    /// At the present parameters.
    fn new(search: &mut SearchState<'_>) -> Self {
        let (model, theta) = (&search.model, search.theta.clone());
        let objective = Objective::Residual(model.problem.loss);
        let contacts = contact_equations(model, &theta, (objective, stride(model)), &mut search.caches).complete();
        let mut distances = NormalEquations::new(theta.len());
        add_distances(&LinearizationPoint::new(model, &theta), &mut distances);
        LinearizedProblem { contacts, distances: distances.complete(), theta, factor: model.noise.factor }
    }

    /// The priors' normal equations at the point of linearization.
    fn priors(&self, model: &CalibrationModel<'_>) -> NormalEquations {
        let mut priors = NormalEquations::new(self.theta.len());
        add_priors(model, &self.theta, Objective::Residual(model.problem.loss), &mut priors);
        priors
    }

    /// The cost of contacts, distances and priors at the point of linearization.
    fn cost(&self, model: &CalibrationModel<'_>) -> f64 {
        self.contacts.cost + self.distances.cost + self.priors(model).cost
    }

    /// Mean and covariance of the parameters with the model's present standard deviations.
    fn posterior(&self, model: &CalibrationModel<'_>, free: &FreeParameters) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let share = (self.factor / model.noise.factor).powi(2);
        let mut normal = self.priors(model);
        normal.information += &self.contacts.information * share + &self.distances.information;
        normal.gradient += &self.contacts.gradient * share + &self.distances.gradient;
        let mut free = free.clone();
        free.rescale(&model.layout.scale());
        let mut scaled = free.scaled(&normal.information);
        for k in 0..scaled.nrows() {
            scaled[(k, k)] += REGULARIZATION;
        }
        let covariance = free.scaled(&Cholesky::new(scaled)?.inverse());
        Some((&self.theta - &covariance * &normal.gradient, covariance))
    }

    /// The noise factor with the greatest expected likelihood.
    fn noise_factor(&self, mean: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
        let step = mean - &self.theta;
        let product = &self.contacts.information * &step;
        let squares = self.contacts.squares + 2.0 * self.contacts.gradient.dot(&step) + step.dot(&product);
        let trace = self.contacts.information.dot(covariance);
        let variance = (squares.max(0.0) + trace) / self.contacts.rows.max(1.0);
        self.factor * variance.sqrt()
    }
}
