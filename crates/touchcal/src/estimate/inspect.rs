//! What a problem's contacts can determine, before it is solved.

use serde::{Deserialize, Serialize};

use super::declaration_checks::declaration_warning;
use super::evaluate::evaluate;
use super::input_checks::input_warnings;
use super::model::{distance_information, set_resolution, whitened_norms};
use super::problem::Problem;
use super::result::{Identifiability, Observer, ParameterEstimate, Score, Warning};
use super::result_checks::data_warnings;
use super::search::{SearchState, approach_contact_modes, coarse, sandwich};
use super::uncertainty::{Posterior, arm_uncertainty};
use super::untouched::without_distances_to_unknown_places;
use crate::solver::StopReason;

/// Range of a moving joint's measured positions over all contacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointRange {
    /// Name of the joint.
    pub joint: String,
    /// Least measured position (rad, or m for a prismatic joint).
    pub least: f64,
    /// Greatest measured position (rad, or m for a prismatic joint).
    pub greatest: f64,
    /// `greatest − least` over the width of the joint's limits (1; above 1 if positions exceed
    /// them). `None` without limits or if these have no width.
    pub share: Option<f64>,
}

/// What the contacts of a problem can determine: the result of [`inspect`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Inspection {
    /// Measured range of every moving joint, from base to tip; empty without contacts.
    pub ranges: Vec<JointRange>,
    /// Every parameter with the standard deviation that a calibration is expected to reach (SI), in
    /// the order of [`Estimate::parameters`](super::Estimate::parameters); each `value` is 0. With
    /// contacts that are measured by their distance from a projection each `sigma` is `None`, as in
    /// [`calibrate`](super::calibrate()).
    pub parameters: Vec<ParameterEstimate>,
    /// What the data determine and what they do not.
    pub identifiability: Identifiability,
    /// Observability indices O1 to O5 (1), in this order, of all contacts, see
    /// [`Identifiability::observability`].
    pub observability: [f64; 5],
    /// Contradictions between the problem's declarations and its contacts:
    /// [`Warning::MistakenDeclaration`], [`Warning::FixtureWithoutContacts`],
    /// [`Warning::OriginOutsideTool`] and [`Warning::DistanceContradicted`]; and what the contacts
    /// do not determine: [`Warning::TooFewContacts`], [`Warning::ArmUndetermined`] and
    /// [`Warning::Unobservable`]; and [`Warning::NoUncertainty`]. In this order; empty if there are
    /// none.
    pub warnings: Vec<Warning>,
    /// Distances (m) of the contacts from their manifolds by the nominal arm, as of
    /// [`evaluate`](super::evaluate()).
    pub nominal: Score,
    /// Why the search before the inspection stopped: unless converged, the expected standard
    /// deviations are unreliable.
    pub reason: StopReason,
}

/// Computes what a problem's contacts can determine, with the declared noise and without outliers,
/// before the problem is solved. No standard deviation is expected of contacts that are measured by
/// their distance from a projection: its error is not noise.
///
/// The Jacobian is taken after the coarse stage: a nominal arm may be centimetres off, where the
/// derivative of a gap is not that at contact; with one-sided contacts, at the contact modes of a
/// subsample, with the noise and the correlation of errors estimated there. `observe` is called at
/// each step; if it breaks, the search ends there and [`Inspection::reason`] is
/// [`StopReason::Interrupted`]. Without contacts, known distances are the only data. Panics if a
/// contact or distance has a fixture that is not in [`Problem::fixtures`].
pub fn inspect(problem: &Problem, observe: Observer<'_>) -> Inspection {
    let fitted = without_distances_to_unknown_places(problem);
    let problem = &*fitted;
    let mut search = SearchState::new(problem);
    coarse(&mut search, observe);
    let mut warnings: Vec<Warning> = declaration_warning(&search).into_iter().collect();
    warnings.extend(input_warnings(&search.model));
    let stride = search.stride();
    set_resolution(&mut search.model, &search.theta, stride);
    approach_contact_modes(&mut search, observe);
    let (contacts, _, rows) = whitened_norms(&search.model, &search.theta, &mut search.caches);
    let rows = rows.iter().map(|&rows| usize::from(rows)).sum::<usize>() + problem.distances.len();
    let data = contacts + distance_information(&search.model, &search.theta);
    let mut posterior = Posterior::new(&search.model, &data, &search.free, &search.fixed);
    let layout = &search.model.layout;
    let arm = arm_uncertainty(problem, &layout.parameters, &posterior.covariance_from_scales, &layout.scale());
    warnings.extend(data_warnings(&search, rows, arm));
    let has_uncertainty = problem.has_uncertainty();
    if !has_uncertainty {
        warnings.push(Warning::NoUncertainty);
    }
    if let Some(covariance) = sandwich(&mut search).and_then(|(sandwich, _)| sandwich.covariance) {
        posterior.covariance = covariance;
    }
    let parameters = search.model.layout.parameters.iter().enumerate().map(|(k, parameter)| ParameterEstimate {
        parameter: parameter.clone(),
        value: 0.0,
        sigma: posterior.sigma(k).filter(|_| has_uncertainty),
        identifiable: posterior.identifiable[k],
    });
    Inspection {
        parameters: parameters.collect(),
        warnings,
        nominal: evaluate(problem),
        ranges: joint_ranges(problem),
        observability: posterior.identifiability.observability(problem.contacts.len()),
        identifiability: posterior.identifiability,
        reason: search.termination.reason,
    }
}

fn joint_ranges(problem: &Problem) -> Vec<JointRange> {
    let contacts = &problem.contacts;
    if contacts.is_empty() {
        return Vec::new();
    }
    let each = problem.robot.moving().enumerate().map(|(i, joint)| {
        let positions = (0..contacts.len()).map(|c| contacts.q(c)[i]);
        let (least, greatest) = positions.fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)));
        let span = joint.limits.map(|limits| limits.upper - limits.lower).filter(|span| *span > 0.0);
        let share = span.map(|span| (greatest - least) / span);
        JointRange { joint: joint.name.clone(), least, greatest, share }
    });
    each.collect()
}
