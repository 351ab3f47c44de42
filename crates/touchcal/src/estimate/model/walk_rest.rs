//! What estimated random walks of encoders leave out.

use std::f64::consts::{PI, SQRT_2};

use super::calibration_model::CalibrationModel;
use crate::parameter::{Parameter, ParameterId, joint_walk_rest};

/// The model with further half-waves of its random walks behind its parameters, and the index and
/// standard deviation (rad) of each. `None` if it estimates no random walks.
pub(crate) fn with_walk_rest<'p>(own: &CalibrationModel<'p>) -> Option<(CalibrationModel<'p>, Vec<(usize, f64)>)> {
    let walks = own.layout.parameters.iter().filter_map(|parameter| match parameter.id {
        ParameterId::JointWalk(joint, k) => Some((joint, parameter.prior_sigma()? * k as f64 * PI / SQRT_2)),
        _ => None,
    });
    let walks: Vec<(usize, f64)> = walks.collect();
    let (_, sigma) = *walks.first()?;
    let is_walking = |parameter: &Parameter| matches!(parameter.id, ParameterId::JointWalk(joint, _) if walks.iter().any(|(of, _)| *of == joint));
    let rest = joint_walk_rest(&own.problem.robot, sigma).into_iter().filter(is_walking);
    let rest: Vec<Parameter> = rest.collect();
    let first = own.layout.len();
    let sigmas = rest.iter().enumerate().filter_map(|(k, parameter)| Some((first + k, parameter.prior_sigma()?)));
    let sigmas = sigmas.collect();
    Some((own.extended(rest), sigmas))
}

/// The model [`with_walk_rest`] and the errors of its parameters, if there is one, else the model
/// itself.
pub(crate) fn extended_or_own<'a, 'b: 'a, 'p>(
    own: &'a CalibrationModel<'p>,
    extended: Option<&'b (CalibrationModel<'p>, Vec<(usize, f64)>)>,
) -> (&'a CalibrationModel<'p>, &'b [(usize, f64)]) {
    extended.map_or((own, &[]), |(model, errors)| (model, errors.as_slice()))
}
