//! The axis along which encoder offsets change linearly.

use crate::contact::ContactLog;
use crate::estimate::problem::{Problem, TrendVariable};

/// The axis along which encoder offsets change linearly: positions of contacts from −1 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TrendAxis {
    /// The number of the contact.
    Log,
    /// The temperature: its middle (°C), and half of its range (K).
    Temperature { middle: f64, half: f64 },
}

impl TrendAxis {
    /// That of a problem.
    pub fn new(problem: &Problem) -> TrendAxis {
        match problem.trend_variable {
            TrendVariable::Log => TrendAxis::Log,
            TrendVariable::Temperature => {
                let contacts = &problem.contacts;
                let temperatures = (0..contacts.len()).filter_map(|i| contacts.temperature(i));
                let range = temperatures.fold(None, |range: Option<(f64, f64)>, celsius| match range {
                    None => Some((celsius, celsius)),
                    Some((least, most)) => Some((least.min(celsius), most.max(celsius))),
                });
                let (least, most) = range.unwrap_or_default();
                TrendAxis::Temperature { middle: 0.5 * (least + most), half: 0.5 * (most - least) }
            }
        }
    }

    /// Position of contact `i`: −1 at the first or coldest, 1 at the last or warmest; 0 where
    /// temperatures are not known, or all the same.
    pub fn position(self, contacts: &ContactLog, i: usize) -> f64 {
        match self {
            TrendAxis::Log => position_in_log(contacts, i),
            TrendAxis::Temperature { middle, half } => match contacts.temperature(i) {
                Some(celsius) if half > 0.0 => (celsius - middle) / half,
                _ => 0.0,
            },
        }
    }
}

/// Position of contact `i` in the log: −1 for the first, 1 for the last.
pub(super) fn position_in_log(contacts: &ContactLog, i: usize) -> f64 {
    let last = contacts.len().saturating_sub(1).max(1);
    2.0 * i as f64 / last as f64 - 1.0
}
