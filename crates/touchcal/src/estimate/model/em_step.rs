//! One iteration of expectation–maximisation for contact modes.

use nalgebra::DVector;

use super::calibration_model::CalibrationModel;
use super::declared_factors::{add_distances, add_priors, prior_information};
use super::layout::PriorGroup;
use super::linearization::LinearizationPoint;
use super::mode_statistics::{ContactModeStatistics, Curvature, InformativeShare, contact_mode_statistics};
use super::objective::Objective;
use crate::estimate::contact_mode::{ContactCounts, ContactModePrior, PseudoCounts};
use crate::manifold::ContactCache;
use crate::solver::{FreeParameters, NormalEquations, first_step};

/// Most fixed-point iterations for the width of a group of parameters from one evaluation of the
/// contacts, and the relative change (1) of a width from which on there are no more.
const WIDTH_ITERATIONS: usize = 20;
const WIDTH_TOLERANCE: f64 = 1e-3;

/// The outcome of an iteration.
pub(crate) struct EmStep {
    /// How many one-sided contacts are informative.
    pub informative_share: InformativeShare,
    /// Mean relative change of the odds (1), or that of the noise if it is larger.
    pub change: f64,
    /// Cost (1) before the iteration.
    pub cost: f64,
    /// Newton step of the parameters (SI), if it is short enough to be taken without a line search;
    /// where later widths make it long, the last that was short.
    pub step: Option<DVector<f64>>,
    /// Newton decrement (1) of the longest of such steps.
    pub short_decrement: f64,
}

/// Which contacts an iteration uses, and what bounds the odds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expectation<'b> {
    /// The contacts whose number is a multiple of this are used.
    pub stride: usize,
    /// Those of [`no_contact_bounds`](super::no_contact_bounds).
    pub no_contact_bounds: &'b [f64],
}

/// Updates the model's contact odds, noise of candidate contacts and prior widths of groups of
/// parameters at `theta`.
pub(crate) fn em_step(
    model: &mut CalibrationModel<'_>,
    theta: &DVector<f64>,
    free: &FreeParameters,
    expectation: Expectation<'_>,
    caches: &mut [ContactCache],
) -> EmStep {
    let options = &model.problem.options;
    let mut statistics = contact_mode_statistics(model, theta, (expectation.stride, Curvature::Complete), caches);
    let informative_share = statistics.informative_share(model);
    let priors = maximize_priors(model, &statistics, expectation);
    let noise = maximize_noise(model, &statistics);
    let change =
        mean_change(&statistics, &model.mode_priors, &priors).max((noise / model.noise.mode_factor).ln().abs());
    add_distances(&LinearizationPoint::new(model, theta), &mut statistics.derivatives);
    let short_decrement = options.contact_mode.em_step_length.powi(2) * statistics.active();
    let posterior = LinearizedPosterior { theta, data: &statistics.derivatives, free, short_decrement };
    let (cost, step) = posterior.step(model);
    (model.mode_priors, model.noise.mode_factor) = (priors, noise);
    let step = maximize_widths(model, &posterior, step);
    EmStep { informative_share, change, cost, step, short_decrement }
}

/// The posterior of the parameters in the problem linearized at `theta`, with the odds and the
/// noise before this iteration and a model's widths of priors. Unlike that of variance components
/// its mean is a damped Newton step away, since candidates enter and leave the gate farther off.
struct LinearizedPosterior<'e> {
    theta: &'e DVector<f64>,
    /// Sums over contacts and distances, upper triangle.
    data: &'e NormalEquations,
    free: &'e FreeParameters,
    short_decrement: f64,
}

impl LinearizedPosterior<'_> {
    /// The cost at `theta`, and the Newton step from there if it is short.
    fn step(&self, model: &CalibrationModel<'_>) -> (f64, Option<DVector<f64>>) {
        let mut normal = self.data.clone();
        add_priors(model, self.theta, Objective::ContactModes, &mut normal);
        let normal = normal.complete();
        let short = |(step, decrement): (DVector<f64>, f64)| (decrement < self.short_decrement).then_some(step);
        (normal.cost, first_step(&normal, self.free).and_then(short))
    }
}

/// Sets the widths of groups of parameters, one group after the other, to those with the greatest
/// expected likelihood. `step` is the Newton step with the widths before; a new one follows each
/// change of a width if it is short. Returns the last short one.
fn maximize_widths(
    model: &mut CalibrationModel<'_>,
    posterior: &LinearizedPosterior<'_>,
    mut step: Option<DVector<f64>>,
) -> Option<DVector<f64>> {
    let data = posterior.data.clone().complete().information;
    let of_gaps = PriorGroup::directional_gap_biases(&model.layout, &model.problem.options);
    for group in of_gaps.iter().chain(&PriorGroup::variance_components(&model.layout)) {
        for _ in 0..WIDTH_ITERATIONS {
            let covariance = posterior.free.covariance(&(&data + prior_information(model)));
            let mean = step.as_ref().map_or_else(|| posterior.theta.clone(), |step| posterior.theta + step);
            let sigma = group.m_step(&mean, &covariance);
            let changes = group.members.iter().map(|&k| model.layout.set_prior_sigma(k, sigma));
            let change = changes.fold(0.0, f64::max);
            if step.is_some() {
                step = posterior.step(model).1.or(step);
            }
            if change < WIDTH_TOLERANCE {
                break;
            }
        }
    }
    step
}

/// The contact mode priors with the greatest expected likelihood, over-relaxed. Without the bounds
/// rows that are no contacts, far from any surface, let more and more contacts count as touching
/// nothing.
fn maximize_priors(
    model: &CalibrationModel<'_>,
    statistics: &ContactModeStatistics,
    expectation: Expectation<'_>,
) -> Vec<Vec<ContactModePrior>> {
    let options = &model.problem.options.contact_mode;
    let candidates: f64 = statistics.counts.iter().flatten().map(ContactCounts::candidates).sum();
    let gate = (options.gate * statistics.sigma_sum / candidates.max(1.0)).max(f64::MIN_POSITIVE);
    let of_fixture = |(f, bound): (usize, &f64)| {
        let (counts, before) = (&statistics.counts[f], &model.mode_priors[f]);
        let sum = |of: fn((f64, f64)) -> f64| counts.iter().map(|counts| of(counts.contacts())).sum::<f64>();
        let no_contact = (sum(|(_, none)| none).max(1.0) / sum(|(some, _)| some).max(1.0)).min(*bound);
        let kinds = counts.chunks(model.regions(f)).zip(before.chunks(model.regions(f)));
        let of_kind = |(counts, before): (&[ContactCounts], &[ContactModePrior])| -> Vec<ContactModePrior> {
            let more = PseudoCounts::new(counts, options.odds_strength);
            counts.iter().zip(before).map(|(counts, before)| counts.m_step(before, gate, no_contact, &more)).collect()
        };
        kinds.flat_map(of_kind).collect()
    };
    expectation.no_contact_bounds.iter().enumerate().map(of_fixture).collect()
}

/// The noise factor of candidate contacts with the greatest expected likelihood.
fn maximize_noise(model: &CalibrationModel<'_>, statistics: &ContactModeStatistics) -> f64 {
    let strength = model.problem.options.contact_mode.noise_strength;
    let before = model.noise.mode_factor;
    let degrees_of_freedom = (statistics.active() - model.layout.len() as f64).max(0.0) + strength;
    before * ((statistics.squared_distance + strength / before.powi(2)) / degrees_of_freedom).sqrt()
}

/// Mean relative change of the odds, weighted by active contacts.
fn mean_change(
    statistics: &ContactModeStatistics,
    before: &[Vec<ContactModePrior>],
    after: &[Vec<ContactModePrior>],
) -> f64 {
    let (mut sum, mut count) = (0.0, 1.0);
    let priors = before.iter().flatten().zip(after.iter().flatten());
    for (counts, (before, after)) in statistics.counts.iter().flatten().zip(priors) {
        for (active, (before, after)) in counts.active().iter().zip(before.odds.iter().zip(&after.odds)) {
            sum += active * (after / before).ln().abs();
            count += active;
        }
    }
    sum / count
}
