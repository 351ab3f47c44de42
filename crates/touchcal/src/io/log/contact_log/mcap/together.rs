//! Wrenches at the times of joint states.

use std::collections::VecDeque;

use crate::se3::Wrench;

/// Wrenches further apart than this (ns) say nothing of what is between: 0.1 s.
pub(super) const GAP: i64 = 100_000_000;
/// How long (ns) a wrench is kept for joint states that come later, though they were earlier: 1 s.
const KEPT: i64 = 1_000_000_000;
/// Most joint states that wait for a wrench, and most wrenches kept.
const MOST: usize = 20_000;

/// A joint state that waits for the wrench after it.
pub(super) struct State {
    /// Its number in the file.
    pub(super) number: u64,
    /// When it was (ns).
    pub(super) time: i64,
    /// Joint positions (rad or m).
    pub(super) q: Vec<f64>,
    /// Joint torques (N m or N); empty where they are not read.
    pub(super) torques: Vec<f64>,
}

/// Joint states and wrenches, each in the order of time, on their way to each other.
#[derive(Default)]
pub(super) struct Together {
    states: VecDeque<State>,
    wrenches: VecDeque<(i64, Wrench)>,
    /// Joint states without a wrench near enough before and after.
    pub(super) alone: u64,
}

impl Together {
    /// Takes a wrench.
    pub(super) fn add_wrench(&mut self, time: i64, wrench: Wrench) {
        let old = |&(kept, _): &(i64, Wrench)| time.saturating_sub(kept) > KEPT;
        // One of the old ones stays: what comes may be between it and this one.
        while self.wrenches.get(1).is_some_and(old) || self.wrenches.len() >= MOST {
            self.wrenches.pop_front();
        }
        self.wrenches.push_back((time, wrench));
    }

    /// Takes a joint state.
    pub(super) fn add_state(&mut self, state: State) {
        if self.states.len() >= MOST {
            self.states.pop_front();
            self.alone += 1;
        }
        self.states.push_back(state);
    }

    /// The next joint state of which it is known what the wrench was.
    pub(super) fn next(&mut self) -> Option<(State, Wrench)> {
        let newest = self.wrenches.back()?.0;
        while self.states.front().is_some_and(|state| state.time <= newest) {
            let state = self.states.pop_front()?;
            match self.wrench_at(state.time) {
                Some(wrench) => return Some((state, wrench)),
                None => self.alone += 1,
            }
        }
        None
    }

    /// Joint states that found no wrench, those that still wait too.
    pub(super) fn finish(self) -> u64 {
        self.alone + self.states.len() as u64
    }

    /// On the line between the wrenches before and after.
    fn wrench_at(&self, time: i64) -> Option<Wrench> {
        let after = self.wrenches.partition_point(|(at, _)| *at < time);
        let (end, last) = self.wrenches.get(after)?;
        if *end == time {
            return Some(*last);
        }
        let (start, first) = self.wrenches.get(after.checked_sub(1)?)?;
        let gap = end.saturating_sub(*start);
        let share = time.saturating_sub(*start) as f64 / gap as f64;
        (gap <= GAP).then(|| std::array::from_fn(|k| first[k] + share * (last[k] - first[k])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn state(number: u64, milliseconds: i64) -> State {
        State { number, time: milliseconds * MS, q: Vec::new(), torques: Vec::new() }
    }

    fn settled(together: &mut Together) -> Vec<(u64, f64)> {
        std::iter::from_fn(|| together.next()).map(|(state, wrench)| (state.number, wrench[2])).collect()
    }

    #[test]
    fn wrenches_are_interpolated_whichever_comes_first() {
        let mut together = Together::default();
        for (number, at) in [(1, 5), (2, 10), (3, 12), (4, 20), (5, 27)] {
            together.add_state(state(number, at));
        }
        assert_eq!(settled(&mut together), []);
        together.add_wrench(10 * MS, [1.0; 6]);
        assert_eq!(settled(&mut together), [(2, 1.0)]);
        together.add_wrench(20 * MS, [3.0; 6]);
        assert_eq!(settled(&mut together), [(3, 1.4), (4, 3.0)]);
        together.add_wrench(30 * MS, [0.0; 6]);
        together.add_wrench(31 * MS, [9.0; 6]);
        together.add_state(state(6, 28));
        assert_eq!(settled(&mut together), [(5, 3.0 - 0.7 * 3.0), (6, 3.0 - 0.8 * 3.0)]);
        // The first was before all wrenches.
        assert_eq!(together.finish(), 1);
    }

    #[test]
    fn nothing_is_made_up_across_gaps_and_memory_is_bounded() {
        let mut together = Together::default();
        together.add_wrench(0, [0.0; 6]);
        together.add_state(state(1, 50));
        together.add_wrench(101 * MS, [1.0; 6]);
        assert_eq!(settled(&mut together), []);
        for number in 0..3 * MOST as u64 {
            together.add_state(state(number, 200));
        }
        assert!(together.states.len() <= MOST);
        assert_eq!(together.finish(), 3 * MOST as u64 + 1);
    }
}
