//! Which surfaces bear the loads of contacts.

use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use crate::manifold::ContactCache;

/// Sets the surfaces that bear the load of each contact, by their normals, to those that do so at
/// `theta`. From then on these surfaces are fixed, whatever the parameters: the last steps of a
/// search need a likelihood that does not jump as surfaces begin or cease to bear.
pub(crate) fn set_bearing_normals(model: &mut CalibrationModel<'_>, theta: &DVector<f64>, caches: &mut [ContactCache]) {
    model.bearing_normals.clear();
    if (0..caches.len()).any(|i| model.has_load(i)) {
        model.bearing_normals = found(&LinearizationPoint::new(model, theta), caches);
    }
}

/// Share (0 to 1) of contacts in which no candidate bears the load, among every `stride`-th that
/// has candidates and whose load is known; `None` without such contacts.
pub(crate) fn unborne_share(model: &CalibrationModel<'_>, theta: &DVector<f64>, stride: usize) -> Option<f64> {
    let point = LinearizationPoint::new(model, theta);
    let has_load = |i: &usize| model.is_one_sided(*i) && model.has_load(*i);
    let mut factor = ContactFactor::new(&point, false);
    let mut is_unborne = |i: usize| {
        let count = factor.evaluate_candidates(&point, i, &mut ContactCache::default()).count;
        (count > 0).then(|| factor.bearing_normals(&point, i).next().is_none())
    };
    let each = (0..model.problem.contacts.len()).step_by(stride).filter(has_load).filter_map(&mut is_unborne);
    let (unborne, all) = each.fold((0, 0), |(unborne, all), is_unborne| (unborne + usize::from(is_unborne), all + 1));
    (all > 0).then(|| unborne as f64 / all as f64)
}

fn found(point: &LinearizationPoint<'_>, caches: &mut [ContactCache]) -> Vec<Vec<Vector3<f64>>> {
    let model = point.model;
    let of_contact = |factor: &mut ContactFactor, (i, cache): (usize, &mut ContactCache)| {
        if !(model.is_one_sided(i) && model.has_load(i)) {
            return Vec::new();
        }
        factor.evaluate_candidates(point, i, cache);
        factor.bearing_normals(point, i).collect()
    };
    caches.par_iter_mut().enumerate().map_init(|| ContactFactor::new(point, false), of_contact).collect()
}
