//! What contradicts a problem's declarations before anything is fitted.

use nalgebra::DVector;

use super::outcome::Warning;
use super::score::{Score, score};
use super::system::System;

/// A distance between fixtures may be off by this share of itself, or by as much as the nominal arm scatters there.
const PLAUSIBLE: f64 = 0.5;

/// Fixtures that nothing touched, and distances that are far from what even the nominal arm measures: another unit, or another log.
pub(super) fn mistakes(system: &System<'_>) -> Vec<Warning> {
    let problem = system.problem;
    let mut touched = vec![false; problem.fixtures.len()];
    (0..problem.contacts.len()).for_each(|i| touched[problem.contacts.fixture(i)] = true);
    let untouched = problem.fixtures.iter().zip(&touched).filter(|(_, touched)| !**touched);
    let mut warnings: Vec<Warning> =
        untouched.map(|(fixture, _)| Warning::Untouched { fixture: fixture.name.clone() }).collect();
    if !problem.distances.is_empty() {
        let nominal = score(problem, &system.at(&DVector::zeros(system.parameters.len())));
        warnings.extend(contradicted(system, &touched, &nominal));
    }
    warnings
}

fn contradicted(system: &System<'_>, touched: &[bool], nominal: &Score) -> Vec<Warning> {
    let problem = system.problem;
    let mut warnings = Vec::new();
    for distance in &problem.distances {
        let (a, b) = distance.between;
        let place = |f: usize| system.base_from_fixture[f].translation.vector;
        let measured = (place(a) - place(b)).norm();
        let scatter = nominal.per_fixture[a].rms + nominal.per_fixture[b].rms;
        let allowed = (PLAUSIBLE * distance.distance).max(scatter);
        if touched[a] && touched[b] && (measured - distance.distance).abs() > allowed {
            let between = [a, b].map(|f| problem.fixtures[f].name.clone());
            warnings.push(Warning::DistanceContradicted { between, declared: distance.distance, measured });
        }
    }
    warnings
}
