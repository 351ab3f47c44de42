//! Contacts that were left out of a fit, with the arm and the places that the fit found.

use nalgebra::DVector;

use crate::contact::ContactLog;
use crate::estimate::evaluate::apply_estimate;
use crate::estimate::model::CalibrationModel;
use crate::estimate::problem::{Problem, WrenchTolerance};
use crate::estimate::untouched::are_touched;
use crate::parameter::kinematic_part;
use crate::robot;

/// The problem of `contacts` with the arm, the tool and the places that a fit of `model` found as
/// its parameters `theta` (SI); no parameter of the arm is estimated in it. Harmonics and gear
/// ratios are subtracted from joint positions; encoder errors of the fit's own log (drifts, trends,
/// walks) and errors of its measured wrench are not used. Fixtures that no contact of the fit
/// touches are as they are declared.
pub(crate) fn new_contacts(model: &CalibrationModel<'_>, theta: &DVector<f64>, contacts: ContactLog) -> Problem {
    let fit = model.problem;
    let mut new = Problem { contacts, held_out: ContactLog::default(), ..fit.clone() };
    let known = &model.layout.parameters;
    let (columns, values) = kinematic_part(known.iter().map(|parameter| parameter.id).zip(theta.iter().copied()));
    new.robot = robot::calibrated(&fit.robot, &columns, &values);
    (new.parameters, new.distances, new.joint_drift) = (Vec::new(), Vec::new(), false);
    new.wrench = WrenchTolerance::EXACT.with_noise_of(&fit.wrench);
    let are_touched = are_touched(fit.fixtures.len(), &fit.contacts);
    for (f, fixture) in new.fixtures.iter_mut().enumerate().filter(|(f, _)| are_touched[*f]) {
        fixture.base_from_fixture = Some(model.base_from_fixture[f]);
    }
    apply_estimate(&mut new, |name| {
        let k = known.iter().position(|parameter| parameter.name == name)?;
        Some(theta[k])
    });
    for (f, declared) in fit.fixtures.iter().enumerate().filter(|(f, _)| !are_touched[*f]) {
        new.fixtures[f] = declared.clone();
    }
    new
}
