//! What contradicts a problem's declarations before anything is fitted.

use nalgebra::DVector;

use super::outcome::Warning;
use super::problem::Problem;
use super::score::{Score, score};
use super::system::System;

/// A distance between fixtures may be off by this share of itself, or by as much as the nominal arm scatters there.
const PLAUSIBLE: f64 = 0.5;

/// Fixtures that nothing touched, and distances that are far from what even the nominal arm measures: another unit, or another log.
pub(super) fn mistakes(system: &System<'_>) -> Vec<Warning> {
    let problem = system.problem;
    let nominal = score(problem, &system.at(&DVector::zeros(system.parameters.len())));
    let untouched = problem.fixtures.iter().zip(&nominal.per_fixture).filter(|(_, spread)| spread.count == 0);
    let untouched = untouched.map(|(fixture, _)| Warning::Untouched { fixture: fixture.name.clone() });
    untouched.chain(contradicted(system, problem, &nominal)).collect()
}

fn contradicted<'a>(
    system: &'a System<'_>,
    problem: &'a Problem,
    nominal: &'a Score,
) -> impl Iterator<Item = Warning> + 'a {
    problem.distances.iter().filter_map(|distance| {
        let (a, b) = distance.between;
        let place = |f: usize| system.base_from_fixture[f].translation.vector;
        let (first, second) = (&nominal.per_fixture[a], &nominal.per_fixture[b]);
        let measured = (place(a) - place(b)).norm();
        let allowed = (PLAUSIBLE * distance.distance).max(first.rms + second.rms);
        let touched = first.count > 0 && second.count > 0;
        (touched && (measured - distance.distance).abs() > allowed).then(|| Warning::DistanceContradicted {
            between: [a, b].map(|f| problem.fixtures[f].name.clone()),
            declared: distance.distance,
            measured,
        })
    })
}
