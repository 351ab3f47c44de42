//! The report of a calibration from which the contacts with some fixtures are held out.

use super::report::{content, page, sockets, solve};

/// Where a socket is that no fitted contact touches is not known: no part of it is drawn.
#[test]
fn a_socket_of_unknown_place_is_not_drawn() {
    let mut problem = sockets();
    let placement = problem.fixtures[0].placement.clone();
    let is_held_out: Vec<bool> = problem.fixtures.iter().map(|fixture| fixture.placement == placement).collect();
    let all = problem.contacts.clone();
    problem.contacts = all.filtered(|i| !is_held_out[all.fixture(i)]);
    problem.held_out = all.filtered(|i| is_held_out[all.fixture(i)]);
    let (estimate, steps) = solve(&problem);
    let content = content(&page(&problem, &estimate, &steps));
    let parts = content["scene"]["fixtures"].as_array().expect("parts");
    assert_eq!(parts.len(), problem.fixtures.len());
    for ((part, fixture), is_held_out) in parts.iter().zip(&problem.fixtures).zip(is_held_out) {
        assert_eq!(part.is_null(), is_held_out, "{}: {part}", fixture.name);
    }
}
