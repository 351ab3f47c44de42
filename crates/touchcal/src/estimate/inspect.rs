//! What a problem's contacts can determine, before it is solved.

use std::ops::ControlFlow;

use super::calibrate::{IDENTIFIABLE_BELOW, coarse, covariance, posterior, priors};
use super::identifiability::{Identifiability, held};
use super::outcome::{Progress, StopReason};
use super::problem::Problem;
use super::system::System;
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
    /// Number of contacts with each fixture, in order.
    pub per_fixture: Vec<usize>,
    /// Range of every moving joint, in order; none without contacts.
    pub ranges: Vec<JointRange>,
    /// Every parameter, in order.
    pub parameters: Vec<Expected>,
    /// What the data determine and what they do not.
    pub identifiability: Identifiability,
    /// Observability indices O1 to O5, see [`Identifiability::observability`].
    pub observability: [f64; 5],
    /// Why the coarse stage stopped: expectations far from its minimum mean little.
    pub reason: StopReason,
}

/// Says what a problem's contacts can determine, with the declared noise and no outliers.
///
/// The Jacobian is taken after the coarse stage: a nominal arm may be centimetres off, where a gap's derivative
/// says nothing about contacts. `observe` is called at each step and may end it.
pub fn inspect(problem: &Problem, observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>) -> Inspection {
    let mut system = System::new(problem);
    let plausible = system.scale();
    let minimum = coarse(&system, &plausible, observe);
    system.set_resolution(&minimum.theta, 1);
    let data = system.information(&minimum.theta, 1.0);
    let total = &data + priors(&system);
    let holding = held(&total, &system.parameters, &plausible);
    let mut scale = plausible.clone();
    for &k in &holding.pivots {
        scale[k] = 0.0;
    }
    let covariance = covariance(&total, &scale);
    let posterior = posterior(&data, &plausible);
    let unbounded = |k: usize| holding.pivots.contains(&k) || holding.participants.contains(&k);
    let expected = system.parameters.iter().enumerate().map(|(k, parameter)| {
        let bounded = parameter.prior_sigma.is_some() || !unbounded(k);
        let shrunk = posterior[(k, k)].max(0.0).sqrt() < IDENTIFIABLE_BELOW * plausible[k];
        Expected {
            parameter: parameter.clone(),
            sigma: bounded.then(|| covariance[(k, k)].max(0.0).sqrt()),
            identifiable: shrunk && bounded,
        }
    });
    let identifiability = Identifiability::new(&data, &system.parameters, &plausible);
    let contacts = &problem.contacts;
    let mut per_fixture = vec![0; problem.fixtures.len()];
    (0..contacts.len()).for_each(|i| per_fixture[contacts.fixture(i)] += 1);
    Inspection {
        per_fixture,
        ranges: ranges(problem),
        parameters: expected.collect(),
        observability: identifiability.observability(contacts.len()),
        identifiability,
        reason: minimum.termination.reason,
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
