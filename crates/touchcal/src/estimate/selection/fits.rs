//! Fits of a model: to all contacts, and without a group.

use nalgebra::DVector;

use super::candidates::{Model, with_model};
use super::groups::Groups;
use crate::contact::ContactLog;
use crate::estimate::calibrate::fit;
use crate::estimate::evaluate::{contact_distances, evaluate};
use crate::estimate::model::whitened_norms;
use crate::estimate::prediction::{new_contacts, with_fitted_places};
use crate::estimate::problem::Problem;
use crate::estimate::result::Observer;
use crate::estimate::untouched::without_distances_to_unknown_places;

/// A fit to all contacts.
pub(super) struct FitToAll {
    /// Distance (m) of each contact from its manifold.
    pub distances: Vec<f64>,
    /// Whether the robust loss rejects each contact.
    pub is_rejected: Vec<bool>,
}

/// Fits a model to all contacts; `None` if `observe` ends it.
pub(super) fn fit_to_all(problem: &Problem, model: &Model, observe: Observer<'_>) -> Option<FitToAll> {
    let posed = with_model(problem, model);
    let fitted = without_distances_to_unknown_places(&posed);
    let mut search = fit(&fitted, observe);
    if search.is_interrupted() {
        return None;
    }
    let (_, norms, _) = whitened_norms(&search.model, &search.theta, &mut search.caches);
    let least = problem.options.thresholds.rejected_weight;
    let is_rejected = norms.into_iter().map(|squared| problem.loss.weight(squared) < least).collect();
    let found = new_contacts(&search.model, &search.theta, problem.contacts.clone());
    Some(FitToAll { distances: contact_distances(&found, &DVector::zeros(0)), is_rejected })
}

/// Root mean square distance (m) of those contacts of group `g` that `is_scored`, by a fit of the
/// model to the contacts of all other groups; infinite if it has none. Places that no other contact
/// touches are fitted to these contacts. `None` if `observe` ends the fit.
pub(super) fn held_out_error(
    (problem, model): (&Problem, &Model),
    (groups, g): (&Groups, usize),
    is_scored: &[bool],
    observe: Observer<'_>,
) -> Option<f64> {
    let contacts = groups.contacts(&problem.contacts, |_, group| group != g);
    let others = Problem { contacts, held_out: ContactLog::default(), ..with_model(problem, model) };
    let fitted = without_distances_to_unknown_places(&others);
    let search = fit(&fitted, observe);
    if search.is_interrupted() {
        return None;
    }
    let left_out = groups.contacts(&problem.contacts, |i, group| group == g && is_scored[i]);
    let found = with_fitted_places(new_contacts(&search.model, &search.theta, left_out));
    let rms = found.map_or(f64::INFINITY, |found| evaluate(&found).all.rms);
    Some(if rms.is_finite() { rms } else { f64::INFINITY })
}
