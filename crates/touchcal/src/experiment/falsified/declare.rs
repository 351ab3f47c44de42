//! Changes of a problem that has been posed.

use crate::estimate::Problem;
use crate::geometry::{Parts, PrismPair};
use crate::manifold::exact_manifold;
use crate::se3::{self, Twist};
use crate::sim::{PartsError, Scenario};

/// Declares each fixture so that its true pose is `declared · Exp(ξ)`, with `ξ` (m, rad) of
/// `displacement` for each.
pub(super) fn move_fixtures(problem: &mut Problem, mut displacement: impl FnMut() -> Twist) {
    for pose in problem.fixtures.iter_mut().filter_map(|fixture| fixture.base_from_fixture.as_mut()) {
        *pose *= se3::exp(&displacement()).inverse();
    }
}

/// Declares the tool so that its true pose on the tip link is `declared · Exp(displacement)`.
pub(super) fn move_tool(problem: &mut Problem, displacement: &Twist) {
    problem.tool.tip_from_tool *= se3::exp(displacement).inverse();
}

/// The peg of `parts` and its hole, wider (m a side) and deeper (m).
pub(super) fn with_hole(parts: &PrismPair, wider: f64, deeper: f64) -> Result<Parts, PartsError> {
    let hole = if wider == 0.0 { parts.hole().clone() } else { parts.hole().offset_mitred(wider)? };
    let pair = parts.with_hole(hole, parts.depth() + deeper)?;
    Ok(Parts::PegInHole(Box::new(pair)))
}

/// Encoder number `joint` reads too much by minus half of `change` (rad or m) at the first contact,
/// rising linearly to half of it at the last.
pub(super) fn encoder_drift(problem: &mut Problem, joint: usize, change: f64) {
    let last = problem.contacts.len().saturating_sub(1).max(1) as f64;
    change_positions(problem, |i, q| q[joint] += change * (i as f64 / last - 0.5));
}

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
