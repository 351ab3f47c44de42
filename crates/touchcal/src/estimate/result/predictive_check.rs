//! Predictive check of a result.

use serde::{Deserialize, Serialize};

/// How far stretches of the log are from what all others predict: a stretch is left out, the
/// parameters are estimated without it, and its residuals are compared with those predicted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictiveCheck {
    /// Scatter found over scatter predicted (1), over all stretches: about 1 if the model is right.
    pub ratio: f64,
    /// Probability (0 to 1) of a ratio as large by chance.
    pub p_value: f64,
    /// Factor (≥ 1) by which standard deviations were multiplied for it: between 1, where chance
    /// makes such ratios, and the ratio, where it does not.
    pub widening: f64,
    /// The ratio of each stretch, in the order of the log; 0 where it shares no direction with the
    /// others.
    pub stretches: Vec<f64>,
}
