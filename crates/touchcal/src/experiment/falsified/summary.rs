//! Sums over trials with false declarations.

use super::trial::FalsifiedRow;

/// Counts and errors over trials, summed trial by trial; the default is empty.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FalsifiedSummary {
    /// Number of trials added.
    pub trials: u64,
    /// Number of trials whose answer is honest ([`FalsifiedRow::honest`]).
    pub honest: u64,
    /// Number of trials whose answer is useful ([`FalsifiedRow::useful`]).
    pub useful: u64,
    /// Number of answers that were not refused: what is below is over these.
    pub answered: u64,
    degrees_of_freedom: u64,
    nees: f64,
    squared_error: f64,
    squared_sigma: f64,
}

impl FalsifiedSummary {
    /// Adds a trial. Their order changes rounding only.
    pub fn add(&mut self, row: &FalsifiedRow) {
        self.trials += 1;
        self.honest += u64::from(row.honest);
        self.useful += u64::from(row.useful);
        if row.is_answered() {
            self.answered += 1;
            self.degrees_of_freedom += row.degrees_of_freedom;
            self.nees += row.nees.unwrap_or(f64::INFINITY);
            self.squared_error += row.tool_error.powi(2);
            self.squared_sigma += row.tool_sigma.unwrap_or(0.0).powi(2);
        }
    }

    /// Sum of NEES over the sum of degrees of freedom, of answers that were not refused: about 1 if
    /// uncertainties are right. `None` without such answers.
    pub fn nees_per_parameter(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0).then(|| self.nees / self.degrees_of_freedom as f64)
    }

    /// Root mean square (m) of [`FalsifiedRow::tool_error`] of answers that were not refused.
    /// `None` without such answers.
    pub fn tool_error(&self) -> Option<f64> {
        (self.answered > 0).then(|| (self.squared_error / self.answered as f64).sqrt())
    }

    /// Root mean square (m) of [`FalsifiedRow::tool_sigma`] of answers that were not refused.
    /// `None` without such answers.
    pub fn tool_sigma(&self) -> Option<f64> {
        (self.answered > 0).then(|| (self.squared_sigma / self.answered as f64).sqrt())
    }
}
