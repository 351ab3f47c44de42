//! What contradicts a problem's declarations before anything is fitted.

use nalgebra::{DVector, Vector3};

use super::outcome::Warning;
use super::rows::At;
use super::score::score;
use super::system::System;

/// A distance between sockets may be off by this share of itself, or by as much as the nominal arm scatters there.
const PLAUSIBLE: f64 = 0.5;

/// Fixtures that nothing touched, a tool drawn beside its frame, and distances of sockets that are far from what even the nominal arm measures: another unit, or another log.
pub(super) fn mistakes(system: &System<'_>) -> Vec<Warning> {
    let problem = system.problem;
    let mut touched = vec![false; problem.fixtures.len()];
    (0..problem.contacts.len()).for_each(|i| touched[problem.contacts.fixture(i)] = true);
    let untouched = problem.fixtures.iter().zip(&touched).filter(|(_, touched)| !**touched);
    let mut warnings: Vec<Warning> =
        untouched.map(|(fixture, _)| Warning::Untouched { fixture: fixture.name.clone() }).collect();
    let aside = problem.fixtures.iter().find_map(|fixture| fixture.manifold.sketch().tool.aside());
    warnings.extend(aside.map(|middle| Warning::ToolAside { middle: middle.coords.into() }));
    if !problem.distances.is_empty() {
        warnings.extend(contradicted(system, &touched));
    }
    warnings
}

fn contradicted(system: &System<'_>, touched: &[bool]) -> Vec<Warning> {
    let problem = system.problem;
    let at = system.at(&DVector::zeros(system.parameters.len()));
    let nominal = score(problem, &at);
    let places = tool_places(system, &at);
    let is_seen = |f: usize| touched[f] && problem.fixtures[f].manifold.is_point();
    let mut warnings = Vec::new();
    for distance in &problem.distances {
        let (a, b) = distance.between;
        let measured = (places[a] - places[b]).norm();
        let scatter = nominal.per_fixture[a].rms + nominal.per_fixture[b].rms;
        let allowed = (PLAUSIBLE * distance.distance).max(scatter);
        if is_seen(a) && is_seen(b) && (measured - distance.distance).abs() > allowed {
            let between = [a, b].map(|f| problem.fixtures[f].name.clone());
            warnings.push(Warning::DistanceContradicted { between, declared: distance.distance, measured });
        }
    }
    warnings
}

/// Mean place of the tool in base (m) in the contacts of each fixture, wherever that is declared to be.
fn tool_places(system: &System<'_>, at: &At<'_>) -> Vec<Vector3<f64>> {
    let contacts = &system.problem.contacts;
    let mut sums = vec![(Vector3::zeros(), 0usize); system.problem.fixtures.len()];
    for i in 0..contacts.len() {
        let (sum, count) = &mut sums[contacts.fixture(i)];
        *sum += (system.base_from_fixture[contacts.fixture(i)] * at.fixture_from_tool(i)).translation.vector;
        *count += 1;
    }
    sums.into_iter().map(|(sum, count)| sum / count.max(1) as f64).collect()
}
