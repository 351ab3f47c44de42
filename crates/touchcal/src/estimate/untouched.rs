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

/// Whether anything says where each fixture is: a contact of the fit, or what is declared of its
/// place. The place of one of which nothing does is no parameter.
pub(super) fn are_placed(problem: &Problem) -> Vec<bool> {
    let are_touched = are_touched(problem.fixtures.len(), &problem.contacts);
    let each = are_touched.iter().zip(&problem.fixtures);
    each.map(|(is_touched, fixture)| *is_touched || fixture.prior != PlacePrior::Flat).collect()
}

/// The problem without distances to fixtures of unknown place that no contact of the fit touches:
/// nothing says where they are, and a distance would pull the other fixture to where the search
/// starts with them. A copy if there are any.
pub(super) fn without_distances_to_unknown_places(problem: &Problem) -> Cow<'_, Problem> {
    let are_placed = are_placed(problem);
    let is_of_known = |(a, b): (usize, usize)| are_placed[a] && are_placed[b];
    if problem.distances.iter().all(|distance| is_of_known(distance.between)) {
        return Cow::Borrowed(problem);
    }
    let mut fitted = problem.clone();
    fitted.distances.retain(|distance| is_of_known(distance.between));
    Cow::Owned(fitted)
}
