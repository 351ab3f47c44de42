//! Fixtures that no contact of the fit touches.

use std::borrow::Cow;

use super::problem::{PlacePrior, Problem};
use crate::contact::ContactLog;

/// Whether each of so many fixtures has a contact in the log.
pub(super) fn are_touched(fixtures: usize, log: &ContactLog) -> Vec<bool> {
    let mut are_touched = vec![false; fixtures];
    (0..log.len()).for_each(|i| are_touched[log.fixture(i)] = true);
    are_touched
}

/// The problem without distances to fixtures of unknown place that no contact of the fit touches:
/// nothing says where they are, and a distance would pull the other fixture to where the search
/// starts with them. A copy if there are any.
pub(super) fn without_distances_to_unknown_places(problem: &Problem) -> Cow<'_, Problem> {
    let are_touched = are_touched(problem.fixtures.len(), &problem.contacts);
    let is_known = |f: usize| are_touched[f] || problem.fixtures[f].prior != PlacePrior::Flat;
    let is_of_known = |(a, b): (usize, usize)| is_known(a) && is_known(b);
    if problem.distances.iter().all(|distance| is_of_known(distance.between)) {
        return Cow::Borrowed(problem);
    }
    let mut fitted = problem.clone();
    fitted.distances.retain(|distance| is_of_known(distance.between));
    Cow::Owned(fitted)
}
