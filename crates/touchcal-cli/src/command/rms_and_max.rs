//! A root mean square and a largest value in JSON.

use serde::Serialize;
use touchcal::experiment::RmsAndMax;

/// Root mean square and largest value, in the unit that the key names.
#[derive(Serialize)]
pub struct RmsAndMaxJson {
    rms: f64,
    max: f64,
}

impl RmsAndMaxJson {
    /// Of values in SI units, times the `factor` to the key's unit.
    pub fn new(found: RmsAndMax, factor: f64) -> Self {
        RmsAndMaxJson { rms: factor * found.rms, max: factor * found.max }
    }
}
