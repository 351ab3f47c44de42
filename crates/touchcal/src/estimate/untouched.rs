//! Fixtures that no contact of the fit touches.

use std::borrow::Cow;

use super::problem::{PlacePrior, Problem};

/// Whether each fixture has a contact that is fitted.
pub(super) fn are_touched(problem: &Problem) -> Vec<bool> {
    let mut are_touched = vec![false; problem.fixtures.len()];
    (0..problem.contacts.len()).for_each(|i| are_touched[problem.contacts.fixture(i)] = true);
    are_touched
}

/// The problem without distances to fixtures of unknown place that no contact of the fit touches:
/// nothing says where they are, and a distance would pull the other fixture to where the search
/// starts with them. A copy if there are any.
pub(super) fn without_distances_to_unknown_places(problem: &Problem) -> Cow<'_, Problem> {
    let are_touched = are_touched(problem);
    let is_known = |f: usize| are_touched[f] || problem.fixtures[f].prior != PlacePrior::Flat;
    let is_of_known = |(a, b): (usize, usize)| is_known(a) && is_known(b);
    if problem.distances.iter().all(|distance| is_of_known(distance.between)) {
        return Cow::Borrowed(problem);
    }
    let mut fitted = problem.clone();
    fitted.distances.retain(|distance| is_of_known(distance.between));
    Cow::Owned(fitted)
}
