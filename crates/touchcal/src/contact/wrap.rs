//! Recorders that wrap angles: a joint seems to turn by 360° from one contact to the next.

use std::f64::consts::TAU;

use super::log::ContactLog;
use crate::robot::{JointKind, Robot};

/// Largest motion (rad or m) of each joint from one contact to the next, but for whole turns, at
/// which a whole turn is one of the recorder: no arm turns one joint by 360° and the others hardly.
const STILL: f64 = 0.1;

/// Rounding (rad) of a whole turn in a file.
const ROUNDING: f64 = 1e-3;

/// A joint that seems to turn by whole turns at a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wrap {
    /// Index of the moving joint, base first.
    pub joint: usize,
    /// Number of the contact.
    pub contact: usize,
}

/// Continues the positions of joints that wrap, of the contacts of `log` from number `first` on,
/// and says where they do. Joints whose positions span more than a turn are not wrapped.
pub(super) fn unwrap(log: &mut ContactLog, first: usize, robot: &Robot) -> Vec<Wrap> {
    // A recorder that wraps angles keeps them within a turn.
    let within_a_turn = |joint: usize| {
        let each = || (first..log.len()).map(|i| log.q(i)[joint]);
        each().fold(f64::NEG_INFINITY, f64::max) - each().fold(f64::INFINITY, f64::min) < TAU + ROUNDING
    };
    let joints = robot.moving().enumerate();
    let turns: Vec<bool> = joints.map(|(k, joint)| joint.kind != JointKind::Prismatic && within_a_turn(k)).collect();
    // What is added to positions as they are recorded, and the last of these.
    let (mut change, mut before) = (vec![0.0; turns.len()], Vec::<f64>::new());
    let mut wraps = Vec::new();
    for (i, q) in log.positions_mut(first).enumerate() {
        let whole_turns = |joint: usize| match turns[joint] {
            true => TAU * ((q[joint] - before[joint]) / TAU).round(),
            false => 0.0,
        };
        let is_still = |joint: usize| (q[joint] - before[joint] - whole_turns(joint)).abs() < STILL;
        if (0..before.len()).all(is_still) {
            for joint in (0..before.len()).filter(|&joint| whole_turns(joint) != 0.0) {
                change[joint] -= whole_turns(joint);
                wraps.push(Wrap { joint, contact: first + i });
            }
        }
        before.clear();
        before.extend_from_slice(q);
        q.iter_mut().zip(&change).for_each(|(q, change)| *q += change);
    }
    wraps
}

/// Words for the user on where joints of the contacts wrap; `None` if they do not.
pub(super) fn wrap_note(wraps: &[Wrap], robot: &Robot, log: &ContactLog) -> Option<String> {
    let first = wraps.first()?;
    let joint = robot.moving().nth(first.joint)?.name.as_str();
    let row = log.source(first.contact).line;
    let more = match wraps.len() - 1 {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    Some(format!(
        "`{joint}` jumps by 360 deg at row {row}{more}, while no joint moves otherwise: taken as a recorder that wraps angles, and continued without the jump"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Source;
    use crate::io::urdf::{self, Ends};

    fn log(rows: &[[f64; 2]]) -> (Robot, ContactLog) {
        let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
        let mut log = ContactLog::new(7);
        for (row, [a, b]) in rows.iter().enumerate() {
            log.push(&[0.0, 0.0, *a, 0.0, 0.0, *b, 0.0], 0, Source { file: 0, line: row as u64 + 2 });
        }
        (robot, log)
    }

    fn positions(log: &ContactLog) -> Vec<[f64; 2]> {
        (0..log.len()).map(|i| [log.q(i)[2], log.q(i)[5]]).collect()
    }

    #[test]
    fn angles_that_a_recorder_wraps_are_continued() {
        let recorded = [[3.1, 0.0], [3.13, 0.01], [3.16 - TAU, 0.02], [3.2 - TAU, 0.03], [3.12, 0.04]];
        let (robot, mut contacts) = log(&recorded);
        let wraps = unwrap(&mut contacts, 0, &robot);
        assert_eq!(wraps, [Wrap { joint: 2, contact: 2 }, Wrap { joint: 2, contact: 4 }]);
        let expected = [[3.1, 0.0], [3.13, 0.01], [3.16, 0.02], [3.2, 0.03], [3.12, 0.04]];
        for (found, expected) in positions(&contacts).iter().flatten().zip(expected.as_flattened()) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        let note = wrap_note(&wraps, &robot, &contacts).expect("a note");
        assert!(note.starts_with("`joint_a3` jumps by 360 deg at row 4 and 1 more, while"), "{note}");
    }

    #[test]
    fn turns_of_the_arm_are_kept() {
        // Another joint moves too; half a turn; a joint that is elsewhere beyond a turn.
        let half = 3.1 - 0.5 * TAU;
        for recorded in [[[3.1, 0.0], [3.1 - TAU, 0.3]], [[3.1, 0.0], [half, 0.0]], [[-0.01, 0.0], [TAU + 0.01, 0.0]]] {
            let (robot, mut contacts) = log(&recorded);
            assert_eq!(unwrap(&mut contacts, 0, &robot), []);
            assert_eq!(positions(&contacts), recorded);
            assert_eq!(wrap_note(&[], &robot, &contacts), None);
        }
        let (robot, mut contacts) = log(&[[3.1, 0.0], [3.1 - TAU, 0.0]]);
        assert_eq!(unwrap(&mut contacts, 1, &robot), []);
    }
}
