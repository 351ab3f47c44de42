//! Changes of a problem that has been posed.

use crate::estimate::Problem;
use crate::geometry::{Parts, PrismPair};
use crate::manifold::exact_manifold;
use crate::sim::{PartsError, Scenario};

/// Declares other shapes for each peg and hole.
pub(super) fn change_parts(
    problem: &mut Problem,
    scenario: &Scenario,
    changed: impl Fn(&PrismPair) -> Result<Parts, PartsError>,
) -> Result<(), PartsError> {
    for (fixture, touch) in problem.fixtures.iter_mut().zip(&scenario.touches) {
        if let Parts::PegInHole(parts) = &touch.parts {
            fixture.manifold = exact_manifold(&changed(parts)?).into();
        }
    }
    Ok(())
}

/// Changes the joint positions `q` (rad or m) of each contact: `change(i, q)`. Loads stay.
pub(super) fn change_positions(problem: &mut Problem, change: impl FnMut(usize, &mut [f64])) {
    problem.contacts = problem.contacts.with_positions(change);
}
