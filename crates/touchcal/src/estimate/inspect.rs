//! What a problem's contacts can determine, before it is solved.

use std::ops::ControlFlow;

use super::calibrate::coarse;
use super::evaluate::evaluate;
use super::identifiability::Identifiability;
use super::knowledge::Knowledge;
use super::mistakes::mistakes;
use super::outcome::{Progress, StopReason, Warning};
use super::problem::Problem;
use super::score::Score;
use crate::robot::Parameter;

/// How well a parameter will be known.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Which parameter.
    pub parameter: Parameter,
    /// Standard deviation to expect (SI); none where neither data nor prior bound it.
    pub sigma: Option<f64>,
    /// Whether the data determine it.
    pub identifiable: bool,
}

/// The range of a joint's measured positions (rad or m).
#[derive(Clone, Debug, PartialEq)]
pub struct JointRange {
    /// Name of the joint.
    pub joint: String,
    /// Least position.
    pub least: f64,
    /// Greatest position.
    pub most: f64,
    /// Share of the joint's limits that this covers, where it has limits.
    pub share: Option<f64>,
}

/// The result of [`inspect`].
#[derive(Clone, Debug)]
pub struct Inspection {
    /// Range of every moving joint, in order; none without contacts.
    pub ranges: Vec<JointRange>,
    /// Every parameter, in order.
    pub parameters: Vec<Expected>,
    /// What the data determine and what they do not.
    pub identifiability: Identifiability,
    /// Observability indices O1 to O5, see [`Identifiability::observability`].
    pub observability: [f64; 5],
    /// What contradicts the problem's declarations.
    pub warnings: Vec<Warning>,
    /// How far from touching the nominal arm's contacts are.
    pub nominal: Score,
    /// Why the coarse stage stopped: expectations far from its minimum mean little.
    pub reason: StopReason,
}

/// Says what a problem's contacts can determine, with the declared noise and no outliers.
///
/// The Jacobian is taken after the coarse stage: a nominal arm may be centimetres off, where a gap's derivative
/// says nothing about contacts; with one-sided contacts, after a look at a few of them that comes near enough to see their walls. `observe` is called at each step and may end it.
pub fn inspect(problem: &Problem, observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>) -> Inspection {
    let mut search = coarse(problem, observe);
    search.come_near(observe);
    let system = &search.system;
    let (contacts, _) = system.statistics(&search.theta);
    let data = contacts + system.distance_information(&search.theta);
    let mut known = Knowledge::new(system, &data, &search.scale, &search.held);
    if let Some((covariance, _)) = search.wall_covariance() {
        known.covariance = covariance;
    }
    let expected = system.parameters.iter().enumerate().map(|(k, parameter)| Expected {
        parameter: parameter.clone(),
        sigma: known.sigma(k),
        identifiable: known.identifiable[k],
    });
    let parameters = expected.collect();
    Inspection {
        warnings: mistakes(system),
        nominal: evaluate(problem),
        ranges: ranges(problem),
        parameters,
        observability: known.identifiability.observability(problem.contacts.len()),
        identifiability: known.identifiability,
        reason: search.termination.reason,
    }
}

fn ranges(problem: &Problem) -> Vec<JointRange> {
    let contacts = &problem.contacts;
    if contacts.is_empty() {
        return Vec::new();
    }
    let each = problem.robot.moving().enumerate().map(|(i, joint)| {
        let positions = (0..contacts.len()).map(|c| contacts.q(c)[i]);
        let (least, most) = positions.fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)));
        let span = joint.limits.map(|limits| limits.upper - limits.lower).filter(|span| *span > 0.0);
        JointRange { joint: joint.name.clone(), least, most, share: span.map(|span| (most - least) / span) }
    });
    each.collect()
}
