//! What is fixed of contact modes while a search takes its last steps.

use nalgebra::DVector;
use rayon::prelude::*;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use crate::estimate::contact_mode::FixedMode;
use crate::manifold::ContactCache;

/// Fixes, whatever the parameters, which surfaces bear the load of each contact, as at `theta`. The
/// last steps of a search need a likelihood that does not jump as surfaces begin or cease to bear.
pub(crate) fn fix_bearing(model: &mut CalibrationModel<'_>, theta: &DVector<f64>, caches: &mut [ContactCache]) {
    model.fixed_modes.clear();
    if (0..caches.len()).any(|i| model.has_load(i)) {
        model.fixed_modes = found(&LinearizationPoint::new(model, theta), caches);
    }
}

/// Fixes besides which contacts have candidates, so that the likelihood does not jump either as
/// contacts pass a rim.
pub(crate) fn fix_modes(model: &mut CalibrationModel<'_>, theta: &DVector<f64>, caches: &mut [ContactCache]) {
    model.fixed_modes.clear();
    let point = LinearizationPoint::new(model, theta);
    let mut modes = found(&point, caches);
    let (contacts, mut q) = (&model.problem.contacts, vec![0.0; point.dof()]);
    for (i, mode) in modes.iter_mut().enumerate() {
        let manifold = &model.problem.fixtures[contacts.fixture(i)].manifold;
        mode.is_distinct = Some(manifold.has_distinct_surfaces(&point.pose(i, &mut q)));
    }
    model.fixed_modes = modes;
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

fn found(point: &LinearizationPoint<'_>, caches: &mut [ContactCache]) -> Vec<FixedMode> {
    let model = point.model;
    let of_contact = |factor: &mut ContactFactor, (i, cache): (usize, &mut ContactCache)| {
        let mut bearing_normals = Vec::new();
        if model.is_one_sided(i) && model.has_load(i) {
            factor.evaluate_candidates(point, i, cache);
            bearing_normals.extend(factor.bearing_normals(point, i));
        }
        FixedMode { is_distinct: None, bearing_normals }
    };
    caches.par_iter_mut().enumerate().map_init(|| ContactFactor::new(point, false), of_contact).collect()
}
