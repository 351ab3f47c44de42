//! A coarse fit: how well contacts agree with what a problem declares.

use std::ops::ControlFlow;

use nalgebra::DVector;

use crate::estimate::evaluate::score;
use crate::estimate::model::{CalibrationModel, LinearizationPoint, Objective, add_distances};
use crate::estimate::options::DeclarationCheckOptions;
use crate::estimate::problem::{Distance, Problem};
use crate::estimate::result::Agreement;
use crate::estimate::search::SearchState;
use crate::parameter::Block;
use crate::solver::{LevenbergMarquardtOptions, NormalEquations, minimize};

/// Linearizations after which a coarse fit is near its minimum, though not in it.
const EARLY: usize = 5;

/// Multiple (1) of the largest envelope of an agreement up to which contacts nearly agree: a peg
/// with worn edges that is turned in its hole has 1.05 of it.
const NEARLY: f64 = 1.5;
/// Share (1) of another fit's cost that is small: a fifth of that of a fit that is far better.
const SMALL_SHARE: f64 = 0.1;

/// A coarse fit of a problem with all its contacts.
pub(super) struct CoarseFit {
    /// The problem.
    pub problem: Problem,
    /// Parameters (SI) in the order of the problem's layout.
    pub theta: DVector<f64>,
    /// Cost (1): squared distances from envelopes, all contacts counting as ten, and squared
    /// deviations from priors, or where there are none from zero in plausible sizes, and from known
    /// distances.
    pub cost: f64,
    /// Root mean square of the envelopes' rows (1).
    pub envelope: f64,
    /// Largest deviation (1) of a parameter or a known distance, see [`Agreement::deviations`].
    pub deviations: f64,
}

impl CoarseFit {
    /// The minimum of the cost from zero, after at most `max_iterations`.
    pub fn minimum(problem: Problem, max_iterations: usize) -> CoarseFit {
        CoarseFit::minimum_below(problem, max_iterations, f64::INFINITY)
    }

    /// The minimum, or where the search was after [`EARLY`] linearizations if it then costs more
    /// than `early_cost`.
    pub fn minimum_below(problem: Problem, max_iterations: usize, early_cost: f64) -> CoarseFit {
        let mut search = SearchState::new(&problem);
        let options = LevenbergMarquardtOptions { max_iterations, ..problem.options.search.coarse };
        let (start, free) = (search.theta.clone(), search.free.clone());
        let linearize = |theta: &DVector<f64>| normal_equations(&mut search, theta);
        let mut observe = |iteration, cost| match iteration >= EARLY && cost > early_cost {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let minimum = minimize(linearize, start, &free, options, &mut observe);
        CoarseFit::at(problem, minimum.theta)
    }

    /// The fit with parameters `theta` (SI, in the order of the layout); gap biases count as zero,
    /// which envelopes do not have.
    pub fn at(problem: Problem, mut theta: DVector<f64>) -> CoarseFit {
        let mut search = SearchState::new(&problem);
        for (parameter, value) in search.model.layout.parameters.iter().zip(theta.iter_mut()) {
            if parameter.id.block() == Block::GapBias {
                *value = 0.0;
            }
        }
        let normal = normal_equations(&mut search, &theta);
        let point = LinearizationPoint::new(&search.model, &theta);
        let parameters = search.model.layout.parameters.iter().zip(theta.iter());
        let of_priors = parameters.map(|(parameter, value)| value / parameter.prior_sigma().unwrap_or(parameter.scale));
        let of_distances = problem.distances.iter().map(|distance| deviation(&point, distance));
        let deviations: Vec<f64> = of_priors.chain(of_distances).collect();
        let of_envelopes = normal.cost - deviations.iter().map(|deviation| deviation * deviation).sum::<f64>();
        let (cost, rows) = (normal.cost, normal.rows.max(f64::MIN_POSITIVE));
        let deviations = deviations.iter().fold(0.0, |most: f64, deviation| most.max(deviation.abs()));
        CoarseFit { problem, theta, cost, envelope: (of_envelopes.max(0.0) / rows).sqrt(), deviations }
    }

    /// Distances and deviations for people.
    pub fn agreement(&self) -> Agreement {
        let model = CalibrationModel::new(&self.problem);
        let distance = score(&LinearizationPoint::new(&model, &self.theta)).all.rms;
        Agreement { distance, deviations: self.deviations }
    }

    /// Whether contacts agree with the declarations as far as a coarse fit can tell.
    pub fn is_plausible(&self, options: &DeclarationCheckOptions) -> bool {
        self.envelope <= options.max_envelope && self.deviations <= options.max_deviations
    }

    /// Whether contacts are nearly so near the envelopes, as of worn parts, at a small share of
    /// `cost`.
    pub fn is_nearly_plausible_beside(&self, cost: f64, options: &DeclarationCheckOptions) -> bool {
        let is_near = self.envelope <= NEARLY * options.max_envelope && self.deviations <= options.max_deviations;
        is_near && self.cost < SMALL_SHARE * cost
    }

    /// Whether this fit costs so much less than `cost` that chance does not explain it.
    pub fn is_far_better_than(&self, cost: f64, options: &DeclarationCheckOptions) -> bool {
        self.cost + options.min_cost_difference < cost && options.min_cost_ratio * self.cost < cost
    }
}

/// Normal equations of the coarse stage, with known distances, and parameters without a prior
/// within their plausible sizes: offsets of any size would make up for another unit.
fn normal_equations(search: &mut SearchState<'_>, theta: &DVector<f64>) -> NormalEquations {
    let mut normal = search.normal_equations(theta, Objective::Envelope, 1);
    for (k, parameter) in search.model.layout.parameters.iter().enumerate() {
        if parameter.prior_sigma().is_none() && parameter.scale > 0.0 {
            let deviation = theta[k] / parameter.scale;
            normal.add_row(&[k], &[parameter.scale.recip()], deviation, 1.0);
            normal.cost += deviation * deviation;
        }
    }
    add_distances(&LinearizationPoint::new(&search.model, theta), &mut normal);
    normal.complete()
}

/// Deviation (1) of a known distance from what is declared, in standard deviations.
fn deviation(point: &LinearizationPoint<'_>, distance: &Distance) -> f64 {
    let (a, b) = distance.between;
    let [from, to] = [a, b].map(|f| point.fixtures[f].base_from_fixture.translation.vector);
    ((to - from).norm() - distance.distance) / distance.sigma
}
