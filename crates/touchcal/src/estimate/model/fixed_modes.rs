//! What is fixed of contact modes while a search takes its last steps.

use nalgebra::DVector;
use rayon::prelude::*;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use crate::estimate::contact_mode::FixedMode;
use crate::manifold::ContactCache;

/// Fixes, whatever the parameters, which contacts have candidates and which surfaces bear their
/// loads, as at `theta`. The last steps of a search need a likelihood that does not jump as
/// contacts pass a rim, or as surfaces begin or cease to bear.
pub(crate) fn fix_modes(model: &mut CalibrationModel<'_>, theta: &DVector<f64>, caches: &mut [ContactCache]) {
    model.fixed_modes.clear();
    model.fixed_modes = found(&LinearizationPoint::new(model, theta), caches);
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
        if !(model.is_one_sided(i) && model.has_load(i)) {
            let manifold = &model.problem.fixtures[model.problem.contacts.fixture(i)].manifold;
            let is_distinct = manifold.has_distinct_surfaces(&point.pose(i, factor.joint_positions()));
            return FixedMode { is_distinct, bearing_normals: Vec::new() };
        }
        factor.evaluate_candidates(point, i, cache);
        FixedMode { is_distinct: factor.is_distinct(), bearing_normals: factor.bearing_normals(point, i).collect() }
    };
    caches.par_iter_mut().enumerate().map_init(|| ContactFactor::new(point, false), of_contact).collect()
}
