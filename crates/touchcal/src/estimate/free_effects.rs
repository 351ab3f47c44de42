//! Estimation of the effects that a model leaves out and contacts contradict.

use super::calibrate::calibrate;
use super::problem::{PlacePrior, Problem, WrenchTolerance};
use super::result::{Estimate, FreedEffect, Observer, OmittedEffect};
use crate::parameter::{Parameter, joint_compliance, joint_harmonic, joint_origin, joint_trend, segment_strain};
use crate::solver::StopReason;

/// Prior standard deviations of what has no prior of its own: 0.5 % of a segment's length, 0.05°.
const SEGMENT_STRAIN_SIGMA: f64 = 5e-3;
const HARMONIC_SIGMA: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// Calibrates as [`calibrate`] does. Then lets in what the model leaves out, one effect after the
/// other, those with the least p-value first, as long as contacts contradict that one is zero; an
/// effect is kept if the search converges with it and stretches of the log are predicted better from
/// the others than without it ([`FreedEffect::gain`]).
///
/// Returns the problem with the kept effects as parameters, with priors, and its estimate;
/// [`Estimate::freed_effects`] has all that were tried. `observe` is called at each step of all
/// calibrations and may end them.
pub fn calibrate_with_freed_effects(problem: &Problem, observe: Observer<'_>) -> (Problem, Estimate) {
    let mut problem = problem.clone();
    let mut estimate = calibrate(&problem, observe);
    let mut tried: Vec<FreedEffect> = Vec::new();
    while let Some((effect, p_value)) = next_suspect(&problem, &estimate, &tried) {
        let freed = with_effect(&problem, &effect);
        let found = calibrate(&freed, observe);
        let nll = |estimate: &Estimate| estimate.prediction.as_ref().map(|prediction| prediction.nll);
        let gain = nll(&estimate).zip(nll(&found)).map(|(before, after)| before - after);
        let is_kept = found.termination.reason == StopReason::Converged && gain.is_none_or(|gain| gain > 0.0);
        tried.push(FreedEffect { effect, p_value, gain, is_kept });
        let is_interrupted = found.termination.reason == StopReason::Interrupted;
        if is_kept || is_interrupted {
            (problem, estimate) = (freed, found);
        }
        if is_interrupted {
            break;
        }
    }
    estimate.freed_effects = tried;
    (problem, estimate)
}

/// The most significant effect that contacts contradict and that was not tried, with its p-value.
fn next_suspect(problem: &Problem, estimate: &Estimate, tried: &[FreedEffect]) -> Option<(OmittedEffect, f64)> {
    let threshold = problem.options.thresholds.effect_p_value;
    let suspects = estimate.effect_tests.iter().filter(|test| test.p_value < threshold);
    let mut new = suspects.filter(|test| tried.iter().all(|freed| freed.effect != test.effect));
    new.next().map(|test| (test.effect.clone(), test.p_value))
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
        OmittedEffect::JointHarmonic => freed.parameters.extend(with_sigma(joint_harmonic(robot), HARMONIC_SIGMA)),
        OmittedEffect::JointTrend => freed.parameters.extend(joint_trend(robot)),
        OmittedEffect::Wrench => freed.wrench = WrenchTolerance::DEFAULT,
        OmittedEffect::ToolPlace => freed.tool.prior = PlacePrior::DEFAULT_TOOL,
        OmittedEffect::FixturePlace { fixture } => {
            let named = freed.fixtures.iter_mut().filter(|other| other.name == *fixture);
            named.for_each(|fixture| fixture.prior = PlacePrior::DEFAULT_FIXTURE);
        }
    }
    freed
}
