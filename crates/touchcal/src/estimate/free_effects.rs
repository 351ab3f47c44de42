//! Estimation of the effects that a model leaves out and contacts contradict.

use std::cell::Cell;
use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::calibrate::calibrate;
use super::problem::{DEFAULT_DISTANCE_SIGMA, Distance, PlacePrior, Problem, ShapeTolerance, WrenchTolerance};
use super::result::{Estimate, FreedEffect, Observer, OmittedEffect, Status, Warning};
use crate::parameter::{
    Block, DEFAULT_WALK_SIGMA, Parameter, joint_compliance, joint_harmonic, joint_origin, joint_trend, joint_walk,
    segment_strain,
};
use crate::solver::StopReason;

/// Prior standard deviation (1) of a segment's strain, which has no prior of its own.
const SEGMENT_STRAIN_SIGMA: f64 = 5e-3;

/// Standard deviation (m) of edges that are declared exact and that contacts contradict: these are
/// off by a tenth of a millimetre or more.
const WORN_EDGE_SIGMA: f64 = 0.2e-3;

/// Effects of the arm that are estimated together where none can be tested; errors of joint origins
/// include those of the segments' lengths.
const TOGETHER: [OmittedEffect; 5] = [
    OmittedEffect::JointCompliance,
    OmittedEffect::JointOrigin,
    OmittedEffect::JointHarmonic,
    OmittedEffect::JointTrend,
    OmittedEffect::JointWalk,
];

/// Calibrates as [`calibrate`] does. Then adds all effects that the model leaves out and contacts
/// contradict, as parameters with priors, and calibrates again, until there are no more. Edges are
/// no parameters: they get a standard deviation, which intervals allow for.
///
/// All are added at once: contacts often show one effect as several, and the result then has the
/// uncertainty of which it is. Where the first calibration has nothing to test effects with, as
/// where errors are so much larger than declared that contacts have no likelihood, those of the arm
/// are estimated together, and added if they differ from zero (Wald, *Tests of statistical
/// hypotheses concerning several parameters when the number of observations is large* (1943)).
/// Where there are no such effects, or the result with these effects is not usable, and noise is
/// larger than declared, noise is estimated instead if that makes the result usable. Where that
/// does not help either, those of the arm are estimated together after all: the first calibration
/// may have ended beside the right minimum, where tests show nothing. Effects that would make a
/// usable result not usable are not added: its intervals allow for these effects.
///
/// Returns the problem with these parameters, and its estimate; [`Estimate::freed_effects`] has the
/// effects, of each round those with the least p-value first, each with the prediction of a
/// calibration that has all but this one. `observe` is called at each step of all calibrations; if
/// it ends one, the result is the last one before, as interrupted.
pub fn calibrate_with_freed_effects(problem: &Problem, observe: Observer<'_>) -> (Problem, Estimate) {
    let is_interrupted = Cell::new(false);
    let observe: Observer<'_> = &mut |progress| {
        let flow = if is_interrupted.get() { ControlFlow::Break(()) } else { observe(progress) };
        is_interrupted.set(flow.is_break());
        flow
    };
    let declared = problem;
    let mut problem = declared.clone();
    let mut estimate = calibrate(declared, observe);
    let mut freed: Vec<FreedEffect> = Vec::new();
    while let Some(extended) = first_usable(&problem, &estimate, &freed, observe).filter(|_| !is_interrupted.get()) {
        freed.extend(extended.effects);
        (problem, estimate) = (extended.problem, extended.estimate);
    }
    if freed.len() > 1 {
        predict_without_each(declared, &mut freed, observe);
    }
    if is_interrupted.get() {
        estimate.termination.reason = StopReason::Interrupted;
        estimate.status = Status::NotUsable;
    }
    estimate.freed_effects = freed;
    (problem, estimate)
}

/// Sets the predictive ratio of each effect to that of a calibration with all the others.
fn predict_without_each(declared: &Problem, freed: &mut [FreedEffect], observe: Observer<'_>) {
    for k in 0..freed.len() {
        let others = freed.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, freed)| freed);
        freed[k].predictive_ratio = ratio(&calibrate(&with_effects(declared, others), observe));
    }
}

/// A problem with effects that it left out before, and its estimate.
struct ExtendedProblem {
    effects: Vec<FreedEffect>,
    problem: Problem,
    estimate: Estimate,
}

/// Where effects that a problem leaves out may show.
#[derive(Clone, Copy)]
enum Evidence {
    /// Score tests.
    Tests,
    /// A warning that noise is larger than declared.
    Noise,
    /// An estimate of all effects of the arm together.
    JointFit,
}

impl Evidence {
    /// The effects that it shows; of tests those that are not `freed`. None of noise, or in a joint
    /// fit, where the result is usable, or a declaration is mistaken.
    fn effects(
        self,
        problem: &Problem,
        estimate: &Estimate,
        freed: &[FreedEffect],
        observe: Observer<'_>,
    ) -> Vec<FreedEffect> {
        let is_refused = !estimate.status.is_usable() && !is_mistaken(estimate);
        match self {
            Evidence::Tests => tested_suspects(problem, estimate, freed),
            Evidence::Noise if is_refused => Vec::from_iter(suspected_noise(problem, estimate)),
            Evidence::JointFit if is_refused && freed.is_empty() => suspects_of_joint_fit(problem, estimate, observe),
            Evidence::Noise | Evidence::JointFit => Vec::new(),
        }
    }
}

/// The problem extended by the first of the sets of effects, in the order in which they are likely,
/// whose result is usable. If there is none: by the first effects of the arm and of places, if
/// `estimate` is not usable either; never by a larger noise, which must explain everything.
fn first_usable(
    problem: &Problem,
    estimate: &Estimate,
    freed: &[FreedEffect],
    observe: Observer<'_>,
) -> Option<ExtendedProblem> {
    let order = if estimate.effect_tests.is_empty() {
        [Evidence::Tests, Evidence::JointFit, Evidence::Noise]
    } else {
        [Evidence::Tests, Evidence::Noise, Evidence::JointFit]
    };
    let mut refused = None;
    for evidence in order {
        let effects = evidence.effects(problem, estimate, freed, observe);
        let Some(first) = effects.first() else { continue };
        let is_noise = first.effect == OmittedEffect::Noise;
        let problem = with_effects(problem, &effects);
        let with = ExtendedProblem { estimate: calibrate(&problem, observe), effects, problem };
        if with.estimate.status.is_usable() {
            return Some(with);
        }
        if !is_noise {
            refused.get_or_insert(with);
        }
    }
    // The intervals of a usable result allow for what could be added.
    refused.filter(|_| !estimate.status.is_usable())
}

/// The effects that contacts contradict and that were not freed yet, the most significant first.
fn tested_suspects(problem: &Problem, estimate: &Estimate, freed: &[FreedEffect]) -> Vec<FreedEffect> {
    let threshold = problem.options.thresholds.effect_p_value;
    let effects = estimate.effect_tests.iter().map(|test| (test.effect.clone(), test.p_value, test.statistic));
    let is_exact = |shape: &ShapeTolerance| shape.clearance == 0.0 || shape.depth == 0.0;
    let shapes = problem.fixtures.iter().filter(|fixture| is_exact(&fixture.tolerance));
    let shapes = shapes.filter_map(|fixture| {
        let effect = OmittedEffect::Shape { fixture: fixture.name.clone() };
        let test = estimate.prior_tests.iter().find(|test| test.declaration.name() == effect.name())?;
        Some((effect, test.p_value, test.statistic))
    });
    let suspects = effects.chain(shapes).filter(|(_, p_value, _)| *p_value < threshold);
    let new = suspects.filter(|(effect, ..)| freed.iter().all(|freed| freed.effect != *effect));
    let mut new: Vec<FreedEffect> = new
        .map(|(effect, p_value, statistic)| FreedEffect {
            effect,
            p_value,
            gain: 0.5 * statistic,
            predictive_ratio: ratio(estimate),
        })
        .collect();
    new.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    new
}

/// Whether something is declared in another unit, order or sense, which no effect makes up for.
fn is_mistaken(estimate: &Estimate) -> bool {
    estimate.warnings.iter().any(|warning| matches!(warning, Warning::MistakenDeclaration { .. }))
}

/// Noise that a warning says is larger than declared. With a factor `f` on the standard deviations
/// of `n` contacts their log-likelihood gains `n (f² − 1 − ln f²) / 2`.
fn suspected_noise(problem: &Problem, estimate: &Estimate) -> Option<FreedEffect> {
    let is_larger = |warning: &Warning| {
        matches!(
            warning,
            Warning::NoiseExceeded { declared: true, .. } | Warning::NoiseContradicted { declared: true, .. }
        )
    };
    if problem.noise.is_estimated || !estimate.warnings.iter().any(is_larger) {
        return None;
    }
    let squared = estimate.noise_factor.powi(2);
    let gain = 0.5 * estimate.contacts.used as f64 * (squared - 1.0 - squared.ln());
    let p_value = ChiSquared::new(1.0).ok()?.sf(2.0 * gain);
    Some(FreedEffect { effect: OmittedEffect::Noise, p_value, gain, predictive_ratio: ratio(estimate) })
}

/// [`PredictiveCheck::ratio`](super::PredictiveCheck::ratio) of an estimate.
fn ratio(estimate: &Estimate) -> Option<f64> {
    estimate.predictive_check.as_ref().map(|check| check.ratio)
}

/// The effects of the arm that differ from zero where all that are not estimated yet are estimated
/// together, the most significant first; none if that calibration must not be used either.
fn suspects_of_joint_fit(problem: &Problem, without: &Estimate, observe: Observer<'_>) -> Vec<FreedEffect> {
    let own = problem.parameters.len();
    let has = |block: Block| problem.parameters.iter().any(|parameter| parameter.id.block() == block);
    let parameters = |effect: &OmittedEffect| with_effect(problem, effect).parameters.split_off(own);
    let new = TOGETHER.iter().map(|effect| (effect, parameters(effect)));
    let effects: Vec<(&OmittedEffect, Vec<Parameter>)> =
        new.filter(|(_, parameters)| !parameters.iter().any(|parameter| has(parameter.id.block()))).collect();
    let all = problem.parameters.iter().chain(effects.iter().flat_map(|(_, parameters)| parameters));
    let together = problem.clone().with_parameters(all.cloned().collect());
    let estimate = calibrate(&together, observe);
    if !estimate.status.is_usable() {
        return Vec::new();
    }
    let count = effects.len() as f64;
    let each = effects.iter().filter_map(|(effect, parameters)| {
        let statistic = wald_statistic(&estimate, parameters)?;
        let p_value = ChiSquared::new(parameters.len() as f64).ok()?.sf(statistic) * count;
        let effect = (*effect).clone();
        Some(FreedEffect { effect, p_value, gain: 0.5 * statistic, predictive_ratio: ratio(without) })
    });
    let threshold = problem.options.thresholds.effect_p_value;
    let mut suspects: Vec<FreedEffect> = each.filter(|suspect| suspect.p_value < threshold).collect();
    suspects.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    suspects
}

/// `θᵀ P⁻¹ θ` (1) with the estimates `θ` of `parameters` and their covariance `P`. `None` if `P` is
/// not positive definite.
fn wald_statistic(estimate: &Estimate, parameters: &[Parameter]) -> Option<f64> {
    let index = |parameter: &Parameter| estimate.parameters.iter().position(|entry| entry.parameter.id == parameter.id);
    let which = parameters.iter().map(index).collect::<Option<Vec<usize>>>()?;
    let values = DVector::from_iterator(which.len(), which.iter().map(|&k| estimate.parameters[k].value));
    let covariance = DMatrix::from_fn(which.len(), which.len(), |i, j| estimate.covariance[(which[i], which[j])]);
    Some(values.dot(&covariance.cholesky()?.solve(&values)))
}

/// The problem with effects as parameters.
fn with_effects<'a>(problem: &Problem, effects: impl IntoIterator<Item = &'a FreedEffect>) -> Problem {
    effects.into_iter().fold(problem.clone(), |problem, freed| with_effect(&problem, &freed.effect))
}

/// The problem with an effect as parameters.
fn with_effect(problem: &Problem, effect: &OmittedEffect) -> Problem {
    let mut freed = problem.clone();
    let robot = &problem.robot;
    let with_sigma = |parameters: Vec<Parameter>, sigma: f64| -> Vec<Parameter> {
        parameters.into_iter().map(|parameter| parameter.with_sigma(sigma)).collect()
    };
    match effect {
        OmittedEffect::JointCompliance => freed.parameters.extend(joint_compliance(robot)),
        OmittedEffect::SegmentStrain => {
            freed.parameters.extend(with_sigma(segment_strain(robot), SEGMENT_STRAIN_SIGMA));
        }
        OmittedEffect::JointOrigin => freed.parameters.extend(joint_origin(robot)),
        OmittedEffect::JointHarmonic => freed.parameters.extend(joint_harmonic(robot)),
        OmittedEffect::JointTrend => freed.parameters.extend(joint_trend(robot)),
        OmittedEffect::JointWalk => freed.parameters.extend(joint_walk(robot, DEFAULT_WALK_SIGMA)),
        OmittedEffect::Wrench => freed.wrench = WrenchTolerance::DEFAULT.with_noise_of(&freed.wrench),
        OmittedEffect::Noise => freed.noise.is_estimated = true,
        OmittedEffect::ToolPlace => freed.tool.prior = PlacePrior::DEFAULT_TOOL,
        OmittedEffect::Shape { fixture } => {
            let named = freed.fixtures.iter_mut().filter(|other| other.name == *fixture);
            let default = |sigma: f64, default: f64| if sigma == 0.0 { default } else { sigma };
            named.for_each(|fixture| {
                let ShapeTolerance { clearance, depth, edge_radius } = fixture.tolerance;
                let defaults = ShapeTolerance::DEFAULT.of(fixture.manifold.as_ref());
                fixture.tolerance = ShapeTolerance {
                    clearance: default(clearance, defaults.clearance),
                    depth: default(depth, defaults.depth),
                    edge_radius: default(edge_radius, defaults.edge_radius),
                };
            });
        }
        OmittedEffect::EdgeRadius { fixture } => {
            let named = freed.fixtures.iter_mut().filter(|other| other.name == *fixture);
            named.for_each(|fixture| fixture.tolerance.edge_radius = WORN_EDGE_SIGMA);
        }
        OmittedEffect::Distance { between: [a, b] } => {
            let is_named = |distance: &&mut Distance| {
                let (first, second) = distance.between;
                problem.fixtures[first].name == *a && problem.fixtures[second].name == *b
            };
            let named = freed.distances.iter_mut().filter(is_named);
            named.for_each(|distance| distance.sigma = distance.sigma.max(DEFAULT_DISTANCE_SIGMA));
        }
        OmittedEffect::FixturePlace { fixture } => {
            let named = freed.fixtures.iter_mut().filter(|other| other.name == *fixture);
            named.for_each(|fixture| fixture.prior = PlacePrior::DEFAULT_FIXTURE);
        }
    }
    freed
}
