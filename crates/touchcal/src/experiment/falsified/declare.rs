//! Changes of a problem that has been posed.

use crate::contact::{ContactLog, Source};
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
pub(super) fn change_positions(problem: &mut Problem, mut change: impl FnMut(usize, &mut [f64])) {
    let contacts = &problem.contacts;
    let mut changed = ContactLog::new(contacts.dof());
    contacts.files().iter().for_each(|file| {
        changed.add_file(file);
    });
    changed.count_rows(contacts.rows_read());
    for i in 0..contacts.len() {
        let mut q = contacts.q(i).to_vec();
        change(i, &mut q);
        let Source { file, line } = contacts.source(i);
        changed.push(&q, contacts.fixture(i), Source { file, line });
        if let Some(load) = contacts.known_load(i) {
            changed.set_load(load);
        }
    }
    problem.contacts = changed;
}
