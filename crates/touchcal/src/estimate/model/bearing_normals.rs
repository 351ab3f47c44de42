//! Which surfaces bear the loads of contacts.

use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use crate::manifold::ContactCache;

/// Sets the surfaces that bear the load of each contact, by their normals, to those that do so at
/// `theta`. From then on they are fixed whatever the parameters: the last steps of a search need a
/// likelihood that does not jump as surfaces begin or cease to bear.
pub(crate) fn set_bearing_normals(model: &mut CalibrationModel<'_>, theta: &DVector<f64>, caches: &mut [ContactCache]) {
    model.bearing_normals.clear();
    if (0..caches.len()).any(|i| model.uses_load_of(i)) {
        model.bearing_normals = found(&LinearizationPoint::new(model, theta), caches);
    }
}

fn found(point: &LinearizationPoint<'_>, caches: &mut [ContactCache]) -> Vec<Vec<Vector3<f64>>> {
    let model = point.model;
    let of_contact = |factor: &mut ContactFactor, (i, cache): (usize, &mut ContactCache)| {
        if !(model.is_one_sided(i) && model.uses_load_of(i)) {
            return Vec::new();
        }
        factor.evaluate_bearing(point, i, cache);
        factor.normals().collect()
    };
    caches.par_iter_mut().enumerate().map_init(|| ContactFactor::new(point, false), of_contact).collect()
}
