//! Rows of a log that are grossly wrong, as by a glitch of an encoder.

use nalgebra::DVector;

use super::calibration_model::CalibrationModel;
use super::contact_factor::ContactFactor;
use super::linearization::LinearizationPoint;
use super::objective::Objective;

/// Ratio (1) of a row's distance to the measure above which the row is grossly wrong.
const MAX_RATIO: f64 = 6.0;
/// Least measure (1), in the scale of the envelope: half a millimetre or a degree for a peg in a
/// hole. Within an envelope all distances may be zero.
const MIN_MEASURE: f64 = 1.0;

/// Indices, ascending, of contacts among every `stride`-th that are grossly wrong: at `theta` they
/// are many times as far from the envelope of their manifold as all but a `share` (0 to 1) of the
/// contacts with the fixture, which is the largest share that can be grossly wrong.
pub(crate) fn gross_rows(
    model: &CalibrationModel<'_>,
    theta: &DVector<f64>,
    (stride, share): (usize, f64),
) -> Vec<usize> {
    let (point, contacts) = (LinearizationPoint::new(model, theta), &model.problem.contacts);
    let mut factor = ContactFactor::new(&point, false);
    let mut of_fixtures = vec![Vec::new(); model.problem.fixtures.len()];
    for i in (0..contacts.len()).step_by(stride) {
        factor.evaluate(&point, i, Objective::Envelope);
        of_fixtures[contacts.fixture(i)].push((i, factor.squared_norm().sqrt()));
    }
    let mut gross: Vec<usize> = of_fixtures.into_iter().flat_map(|contacts| grossly_wrong(contacts, share)).collect();
    gross.sort_unstable();
    gross
}

/// Indices of those of `contacts`, given with their distances, that are grossly wrong.
fn grossly_wrong(mut contacts: Vec<(usize, f64)>, share: f64) -> impl Iterator<Item = usize> {
    contacts.sort_unstable_by(|(_, a), (_, b)| a.total_cmp(b));
    let at = ((1.0 - share) * contacts.len() as f64) as usize;
    let measure = contacts.get(at).map_or(MIN_MEASURE, |(_, distance)| distance.max(MIN_MEASURE));
    contacts.into_iter().filter(move |(_, distance)| *distance > MAX_RATIO * measure).map(|(i, _)| i)
}
