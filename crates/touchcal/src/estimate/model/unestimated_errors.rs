//! What is in error and not estimated: edges, and what estimated random walks of encoders leave
//! out. Least gaps, which count where contacts have no marginal likelihood, do not depend on edges.

use std::f64::consts::{PI, SQRT_2};

use super::calibration_model::CalibrationModel;
use crate::estimate::problem::Problem;
use crate::parameter::{Parameter, ParameterId, edge_radius, joint_walk_rest};

/// The model with the radii of uncertain edges and further half-waves of its random walks behind
/// its parameters, and the index and standard deviation (SI) of each. `None` if it has neither.
pub(crate) fn with_unestimated_errors<'p>(
    own: &CalibrationModel<'p>,
) -> Option<(CalibrationModel<'p>, Vec<(usize, f64)>)> {
    let errors: Vec<Parameter> = uncertain_edges(own.problem).chain(walk_rest(own)).collect();
    let first = own.layout.len();
    let sigmas = errors.iter().enumerate().filter_map(|(k, parameter)| Some((first + k, parameter.prior_sigma()?)));
    let sigmas: Vec<(usize, f64)> = sigmas.collect();
    (!sigmas.is_empty()).then(|| (own.extended(errors), sigmas))
}

/// The model [`with_unestimated_errors`] and these errors, if there are any, else the model itself.
pub(crate) fn extended_or_own<'a, 'b: 'a, 'p>(
    own: &'a CalibrationModel<'p>,
    extended: Option<&'b (CalibrationModel<'p>, Vec<(usize, f64)>)>,
) -> (&'a CalibrationModel<'p>, &'b [(usize, f64)]) {
    extended.map_or((own, &[]), |(model, errors)| (model, errors.as_slice()))
}

/// The radius of the edges of each fixture where these have a tolerance.
pub(crate) fn uncertain_edges(problem: &Problem) -> impl Iterator<Item = Parameter> + '_ {
    let uncertain = problem.fixtures.iter().enumerate().filter(|(_, fixture)| fixture.has_uncertain_edges());
    uncertain.map(|(f, fixture)| edge_radius(&fixture.name, f).with_sigma(fixture.tolerance.edge_radius))
}

/// Further half-waves of the random walks that are estimated.
fn walk_rest(own: &CalibrationModel<'_>) -> Vec<Parameter> {
    let walks = own.layout.parameters.iter().filter_map(|parameter| match parameter.id {
        ParameterId::JointWalk(joint, k) => Some((joint, parameter.prior_sigma()? * k as f64 * PI / SQRT_2)),
        _ => None,
    });
    let walks: Vec<(usize, f64)> = walks.collect();
    let Some(&(_, sigma)) = walks.first() else { return Vec::new() };
    let is_walking = |parameter: &Parameter| matches!(parameter.id, ParameterId::JointWalk(joint, _) if walks.iter().any(|(of, _)| *of == joint));
    joint_walk_rest(&own.problem.robot, sigma).into_iter().filter(is_walking).collect()
}
