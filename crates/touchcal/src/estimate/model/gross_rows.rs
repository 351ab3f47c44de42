//! Rows of a log that are grossly wrong, as by a glitch of an encoder.

use nalgebra::DVector;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use super::objective::Objective;

/// Share of a fixture's contacts (1) that are not grossly wrong.
const MOST: f64 = 0.9;
/// Distance from the envelope over the one that [`MOST`] of the fixture's contacts do not exceed,
/// above which a row is grossly wrong.
const GROSS: f64 = 15.0;

/// Indices, ascending, of contacts among every `stride`-th that are grossly wrong: at `theta` they
/// are many times farther from the envelope of their manifold than most contacts with the fixture.
pub(crate) fn gross_rows(model: &CalibrationModel<'_>, theta: &DVector<f64>, stride: usize) -> Vec<usize> {
    let (point, contacts) = (LinearizationPoint::new(model, theta), &model.problem.contacts);
    let mut factor = ContactFactor::new(&point, false);
    let mut of_fixtures = vec![Vec::new(); model.problem.fixtures.len()];
    for i in (0..contacts.len()).step_by(stride) {
        factor.evaluate(&point, i, Objective::Envelope);
        of_fixtures[contacts.fixture(i)].push((i, factor.squared_norm().sqrt()));
    }
    let mut gross: Vec<usize> = of_fixtures.into_iter().flat_map(grossly_wrong).collect();
    gross.sort_unstable();
    gross
}

/// Indices of those of `contacts`, given with their distances, that are grossly wrong.
fn grossly_wrong(mut contacts: Vec<(usize, f64)>) -> impl Iterator<Item = usize> {
    contacts.sort_unstable_by(|(_, a), (_, b)| a.total_cmp(b));
    let of_most = contacts.get((MOST * contacts.len() as f64) as usize).map_or(0.0, |(_, distance)| *distance);
    contacts.into_iter().filter(move |(_, distance)| *distance > GROSS * of_most).map(|(i, _)| i)
}
