//! Stretches of a log that are there twice, such as a log and a copy of it with other digits.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::log::ContactLog;

/// Joint positions of this size are equal (rad or m): far below the noise of encoders.
const EQUAL: f64 = 1e-6;
/// Shortest stretch, in contacts that differ from the one before: noise repeats none so long.
const STRETCH: usize = 10;

/// Number of contacts in stretches whose joint positions are those of an earlier stretch, to 1e-6
/// rad (or m), contact after contact. A stretch has at least ten contacts in which the arm has
/// moved since the one before. The contacts are those of all `logs`, one log after the other; each
/// counts once.
pub fn repeated_contacts<'a>(logs: impl IntoIterator<Item = &'a ContactLog>) -> usize {
    let positions: Vec<&[f64]> = logs.into_iter().flat_map(|log| (0..log.len()).map(|i| log.q(i))).collect();
    // Stretches are found by contacts that are equal when rounded; of a copy, most are.
    let first = first_equals(&positions);
    let (mut repeated, mut stretch) = (0, Stretch::default());
    for (i, q) in positions.iter().enumerate() {
        // The contact itself is no earlier one.
        let next = stretch.of.map(|of| of + 1).filter(|&next| next < i && are_equal(positions[next], q));
        if next.is_none() {
            repeated += stretch.counted();
            stretch = Stretch::default();
        }
        stretch.of = next.or(Some(first[i] as usize).filter(|&same| same < i));
        if stretch.of.is_some() {
            stretch.contacts += 1;
            stretch.moved += usize::from(i == 0 || !are_equal(positions[i - 1], q));
        }
    }
    repeated + stretch.counted()
}

/// Words for the user: of `all` contacts so many are rows that were read before.
pub fn repeated_rows_note(repeated: usize, all: usize) -> String {
    format!(
        "{repeated} of {all} contacts are rows that were read before, in this log or another, and are counted once; \
         check which logs are named, and with which fixture, unless the arm was at rest"
    )
}

/// Appends a note to those of `contacts` if [`repeated_contacts`] finds any in `contacts` followed
/// by `held_out`.
pub fn note_repetition(contacts: &mut ContactLog, held_out: &ContactLog) {
    let repeated = repeated_contacts([&*contacts, held_out]);
    if repeated > 0 {
        contacts.note(format!(
            "{repeated} of {} contacts have, one after another, the joint positions of earlier ones to 1e-6 rad; \
             if a log is a copy of another, name only one of them: copies make uncertainties too small",
            contacts.len() + held_out.len()
        ));
    }
}

/// For each contact, the index of the first one with the same rounded positions: its own if there
/// is none before.
fn first_equals(positions: &[&[f64]]) -> Vec<u32> {
    // A sorted list takes a third of a hash map's memory.
    let mut order: Vec<(u64, u32)> = positions.iter().map(|q| rounded(q)).zip(0..).collect();
    order.sort_unstable();
    let mut first = vec![0; positions.len()];
    for equal in order.chunk_by(|(a, _), (b, _)| a == b) {
        equal.iter().for_each(|&(_, i)| first[i as usize] = equal[0].1);
    }
    first
}

/// Contacts that follow earlier ones.
#[derive(Default)]
struct Stretch {
    /// The earlier contact that the last one equals.
    of: Option<usize>,
    contacts: usize,
    /// Contacts that differ from the one before.
    moved: usize,
}

impl Stretch {
    fn counted(&self) -> usize {
        if self.moved >= STRETCH { self.contacts } else { 0 }
    }
}

fn are_equal(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < EQUAL)
}

fn rounded(q: &[f64]) -> u64 {
    let mut hasher = DefaultHasher::new();
    q.iter().for_each(|position| ((position / EQUAL).round() as i64).hash(&mut hasher));
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Source;

    /// A log of these positions of one joint.
    fn log(positions: impl IntoIterator<Item = f64>) -> ContactLog {
        let mut log = ContactLog::new(1);
        let file = log.add_file("log.csv");
        positions.into_iter().zip(1..).for_each(|(q, line)| log.push(&[q], 0, Source { line, file }));
        log
    }

    #[test]
    fn stretches_that_are_there_twice_are_counted() {
        let moving = |count: usize, from: f64| (0..count).map(move |k| from + 1e-3 * k as f64);
        let once = log(moving(40, 0.0));
        assert_eq!(repeated_contacts([&once]), 0);
        // A copy with other digits, behind others and in another log. Its second contact is
        // rounded otherwise.
        let digits = |(k, q): (usize, f64)| q + if k == 1 { 6e-7 } else { 1e-9 };
        let copy = log(moving(5, 1.0).chain(moving(12, 0.02).enumerate().map(digits)));
        assert_eq!(repeated_contacts([&once, &copy]), 12);
        // Three copies: each but the first.
        assert_eq!(repeated_contacts([&once, &once, &once]), 80);
        assert_eq!(repeated_contacts([&once, &log(moving(9, 0.0))]), 0);
        // Backwards, and an arm that rests at two places in turn.
        assert_eq!(repeated_contacts([&once, &log(moving(40, 0.0).collect::<Vec<_>>().into_iter().rev())]), 0);
        let resting = (0..8).flat_map(|k| [f64::from(k % 2); 20]);
        assert_eq!(repeated_contacts([&log(resting)]), 0);
    }
}
