//! Estimation of the effects that a model leaves out and contacts contradict.

use super::calibrate::calibrate;
use super::problem::{PlacePrior, Problem, WrenchTolerance};
use super::result::{Estimate, FreedEffect, Observer, OmittedEffect};
use crate::parameter::{
    DEFAULT_WALK_SIGMA, Parameter, joint_compliance, joint_harmonic, joint_origin, joint_trend, joint_walk,
    segment_strain,
};
use crate::solver::StopReason;

/// Prior standard deviations of what has no prior of its own: 0.5 % of a segment's length, 0.05°.
const SEGMENT_STRAIN_SIGMA: f64 = 5e-3;
const HARMONIC_SIGMA: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// Calibrates as [`calibrate`] does. Then lets in all effects that the model leaves out and
/// contacts contradict, as parameters with priors, and calibrates again, until there are no more.
///
/// All are let in at once: contacts often show one effect as several, and the result then has the
/// uncertainty of which it is. Returns the problem with these parameters, and its estimate;
/// [`Estimate::freed_effects`] has the effects, of each round those with the least p-value first.
/// `observe` is called at each step of all calibrations and may end them.
pub fn calibrate_with_freed_effects(problem: &Problem, observe: Observer<'_>) -> (Problem, Estimate) {
    let mut problem = problem.clone();
    let mut estimate = calibrate(&problem, observe);
    let mut freed: Vec<FreedEffect> = Vec::new();
    loop {
        let suspects = suspects(&problem, &estimate, &freed);
        if suspects.is_empty() || estimate.termination.reason == StopReason::Interrupted {
            break;
        }
        problem = suspects.iter().fold(problem, |problem, suspect| with_effect(&problem, &suspect.effect));
        freed.extend(suspects);
        estimate = calibrate(&problem, observe);
    }
    estimate.freed_effects = freed;
    (problem, estimate)
}

/// The effects that contacts contradict and that were not let in yet, the most significant first.
fn suspects(problem: &Problem, estimate: &Estimate, freed: &[FreedEffect]) -> Vec<FreedEffect> {
    let threshold = problem.options.thresholds.effect_p_value;
    let suspects = estimate.effect_tests.iter().filter(|test| test.p_value < threshold);
    let new = suspects.filter(|test| freed.iter().all(|freed| freed.effect != test.effect));
    let each = new.map(|test| FreedEffect {
        effect: test.effect.clone(),
        p_value: test.p_value,
        gain: 0.5 * test.statistic,
        predictive_ratio: estimate.predictive_check.as_ref().map(|check| check.ratio),
    });
    each.collect()
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
        OmittedEffect::JointWalk => freed.parameters.extend(joint_walk(robot, DEFAULT_WALK_SIGMA)),
        OmittedEffect::Wrench => freed.wrench = WrenchTolerance::DEFAULT,
        OmittedEffect::ToolPlace => freed.tool.prior = PlacePrior::DEFAULT_TOOL,
        OmittedEffect::FixturePlace { fixture } => {
            let named = freed.fixtures.iter_mut().filter(|other| other.name == *fixture);
            named.for_each(|fixture| fixture.prior = PlacePrior::DEFAULT_FIXTURE);
        }
    }
    freed
}
