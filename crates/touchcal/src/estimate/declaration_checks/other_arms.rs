//! Other arms than the described one, of which a log may be.

use super::coarse_fit::CoarseFit;
use crate::estimate::problem::{PlacePrior, Problem};
use crate::estimate::result::DeclarationMistake;
use crate::parameter::{Block, segment_strain, strain};
use crate::robot::segments;

/// Standard deviation (1) of the strains by which another arm differs.
const STRAIN_SIGMA: f64 = 0.1;
/// Least strain (1) of another arm: less is an error of this one.
const MIN_STRAIN: f64 = 0.02;
/// Standard deviations (m, rad) of places that were declared grossly wrong.
const GROSS: PlacePrior = PlacePrior::Gaussian { sigma: 0.05, sigma_angle: 10.0 * std::f64::consts::PI / 180.0 };
/// Standard deviations (m, rad) of the tool's place on the tip link of another arm, which may end
/// elsewhere.
const OTHER_TIP: PlacePrior = PlacePrior::Gaussian { sigma: 0.2, sigma_angle: std::f64::consts::PI };
/// What another parameter must gain in cost (1): the Bayesian information criterion with some tens
/// of measurements (Schwarz 1978).
const COST_OF_PARAMETER: f64 = 4.0;

/// By how much the cost (1) of another arm must be less than those of wrong places and of wrong
/// distances, which have similar effects.
const MIN_ADVANTAGE: f64 = 20.0;

/// Other arms of which the contacts may be, each with its coarse fit.
pub(super) fn other_arms(problem: &Problem) -> Vec<(DeclarationMistake, CoarseFit)> {
    let mut arms = strained_arms(problem);
    arms.extend(known_arms(problem));
    arms
}

/// Known arms of other lengths whose tip may be anywhere, each with its coarse fit.
pub(super) fn other_arms_with_another_tip(problem: &Problem) -> Vec<(DeclarationMistake, CoarseFit)> {
    let mut any_tip = problem.clone();
    any_tip.tool.prior = OTHER_TIP;
    // The last segment ends at the tip.
    let mut own = segments(&problem.robot);
    own.pop();
    any_tip.other_arms.retain(|arm| {
        let mut lengths = segments(arm).into_iter().zip(&own);
        lengths.any(|(other, own)| (other.length - own.length).abs() > MIN_STRAIN * own.length)
    });
    known_arms(&any_tip)
}

/// Those of `arms` that agree with the contacts better than wrong places of tool and fixtures, or
/// wrong distances, would.
pub(super) fn better_than_places(
    problem: &Problem,
    mut arms: Vec<(DeclarationMistake, CoarseFit)>,
) -> Vec<(DeclarationMistake, CoarseFit)> {
    if arms.is_empty() {
        return arms;
    }
    let max_iterations = problem.options.declaration_check.max_iterations;
    let without_distances = Problem { distances: Vec::new(), ..problem.clone() };
    let wrong = [with_free_places(problem), without_distances];
    let costs = wrong.into_iter().map(|problem| CoarseFit::minimum(problem, max_iterations).cost);
    let to_beat = costs.fold(f64::INFINITY, f64::min) - MIN_ADVANTAGE;
    arms.retain(|(_, fit)| fit.cost < to_beat);
    arms
}

/// The arm in another size, and with other lengths.
fn strained_arms(problem: &Problem) -> Vec<(DeclarationMistake, CoarseFit)> {
    let has = |block: Block| problem.parameters.iter().any(|parameter| parameter.id.block() == block);
    let mut strains = Vec::new();
    if !has(Block::SegmentStrain) {
        strains.push(segment_strain(&problem.robot));
        if !has(Block::Strain) {
            strains.push(vec![strain()]);
        }
    }
    let each = strains.into_iter().filter_map(|strains| {
        let (first, count) = (problem.parameters.len(), strains.len());
        let mut strained = problem.clone();
        strained.parameters.extend(strains.into_iter().map(|strain| strain.with_sigma(STRAIN_SIGMA)));
        let mut fit = CoarseFit::minimum(strained, problem.options.declaration_check.max_iterations);
        fit.cost += COST_OF_PARAMETER * count as f64;
        let values = fit.theta.rows(first, count);
        let segments = segments(&problem.robot).into_iter().enumerate();
        // A single strain is that of all segments.
        let lengths = segments
            .map(|(k, segment)| (segment.name, segment.length, segment.length * (1.0 + values[k.min(count - 1)])))
            .collect();
        let is_other = values.iter().any(|strain| strain.abs() > MIN_STRAIN);
        is_other.then_some((DeclarationMistake::ArmLengths { segments: lengths }, fit))
    });
    each.collect()
}

/// The arms that the problem knows besides its own, of as many joints.
fn known_arms(problem: &Problem) -> Vec<(DeclarationMistake, CoarseFit)> {
    let max_iterations = problem.options.declaration_check.max_iterations;
    let arms = problem.other_arms.iter().filter(|arm| arm.dof() == problem.robot.dof());
    let each = arms.map(|arm| {
        let robot = arm.clone().with_gravity(*problem.robot.gravity());
        let fit = CoarseFit::minimum(Problem { robot, ..problem.clone() }, max_iterations);
        (DeclarationMistake::OtherArm { name: arm.name().to_owned() }, fit)
    });
    each.collect()
}

/// The problem with places of tool and fixtures that may be grossly wrong.
fn with_free_places(problem: &Problem) -> Problem {
    let mut free = problem.clone();
    free.tool.prior = GROSS;
    free.fixtures
        .iter_mut()
        .filter(|fixture| fixture.base_from_fixture.is_some())
        .for_each(|fixture| fixture.prior = GROSS);
    free
}
