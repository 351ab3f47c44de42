//! A gradient descent that did not end at a minimum that contacts agree with.

use serde::{Deserialize, Serialize};

/// How a gradient descent ended that diverged, was too short, or converged where contacts do not
/// fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DescentFailure {
    /// Steps taken.
    pub steps: usize,
    /// Share (0 to 1) by which another step lowers the mean distance of contacts; `None` where that
    /// distance is no finite number any more.
    pub decrease: Option<f64>,
}

impl DescentFailure {
    /// Name of its warning in files.
    pub const KIND: &str = "descent_failed";

    /// The defect in one English sentence without a full stop.
    pub fn message(&self) -> String {
        let steps = self.steps;
        match self.decrease {
            Some(decrease) => format!(
                "the gradient descent did not end at a minimum that contacts agree with: after {steps} steps another one lowers their mean distance by {:.1} %",
                100.0 * decrease
            ),
            None => format!(
                "the gradient descent diverged: after {steps} steps the mean distance of contacts is no finite number"
            ),
        }
    }

    /// The remedy in one English sentence without a full stop.
    pub fn advice(&self) -> &'static str {
        "take the default method (method = \"levenberg_marquardt\"), or more `steps` or a smaller `rate` of `descent`, before you change anything else: what follows from values holds only where the descent ended"
    }
}
