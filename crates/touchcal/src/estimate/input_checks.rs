//! Warnings about a problem before anything is fitted.

use nalgebra::{DVector, Vector3};

use super::evaluate::score;
use super::model::{CalibrationModel, LinearizationPoint};
use super::result::Warning;
use super::untouched::are_touched;
use crate::manifold::ResidualKind;

/// What contradicts the problem's declarations: fixtures without contacts, a tool drawn beside its
/// frame, and distances of sockets that even the nominal arm contradicts (another unit, or another
/// log).
pub(super) fn input_warnings(model: &CalibrationModel<'_>) -> Vec<Warning> {
    let problem = model.problem;
    let count = problem.fixtures.len();
    let [has_contacts, is_held_out] = [&problem.contacts, &problem.held_out].map(|log| are_touched(count, log));
    let without = (0..count).filter(|&f| !has_contacts[f] && !is_held_out[f]);
    let mut warnings: Vec<Warning> =
        without.map(|f| Warning::FixtureWithoutContacts { fixture: problem.fixtures[f].name.clone() }).collect();
    let middle = problem.fixtures.iter().find_map(|fixture| fixture.manifold.sketch().tool.aside());
    warnings.extend(middle.map(|middle| Warning::OriginOutsideTool { middle: middle.coords.into() }));
    if !problem.distances.is_empty() {
        warnings.extend(contradicted_distances(model, &has_contacts));
    }
    warnings
}

fn contradicted_distances(model: &CalibrationModel<'_>, has_contacts: &[bool]) -> Vec<Warning> {
    let problem = model.problem;
    let point = LinearizationPoint::new(model, &DVector::zeros(model.layout.len()));
    let nominal = score(&point);
    let places = mean_tool_positions(&point);
    let is_measured =
        |f: usize| has_contacts[f] && problem.fixtures[f].manifold.residual_kind() == ResidualKind::PointOffset;
    let mut warnings = Vec::new();
    for distance in &problem.distances {
        let (a, b) = distance.between;
        let measured = (places[a] - places[b]).norm();
        let scatter = nominal.per_fixture[a].rms + nominal.per_fixture[b].rms;
        let share = problem.options.thresholds.distance_contradiction;
        let allowed = (share * distance.distance).max(scatter);
        if is_measured(a) && is_measured(b) && (measured - distance.distance).abs() > allowed {
            let between = [a, b].map(|f| problem.fixtures[f].name.clone());
            warnings.push(Warning::DistanceContradicted { between, declared: distance.distance, measured });
        }
    }
    warnings
}

/// Mean position of the tool in base (m) in the contacts of each fixture.
fn mean_tool_positions(point: &LinearizationPoint<'_>) -> Vec<Vector3<f64>> {
    let (model, contacts) = (point.model, &point.model.problem.contacts);
    let mut sums = vec![(Vector3::zeros(), 0usize); model.problem.fixtures.len()];
    for i in 0..contacts.len() {
        let (sum, count) = &mut sums[contacts.fixture(i)];
        *sum += point.base_from_tool(i).translation.vector;
        *count += 1;
    }
    sums.into_iter().map(|(sum, count)| sum / count.max(1) as f64).collect()
}
