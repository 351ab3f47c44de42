//! Lengths and angles that are implausible as metres or radians.

use pyo3::PyResult;

use crate::error::unexpected;

/// Longest translation (m) of a tool or a fixture, and longest distance of two fixtures.
pub const REACH: f64 = 10.0;
/// Largest size (m) of a part that touches.
pub const PART: f64 = 2.0;
/// Largest standard deviation (m) of a place; what is known no better is free.
pub const PLACE_SIGMA: f64 = 0.5;
/// Largest gap (m) between a peg and its hole.
pub const GAP: f64 = 0.1;
/// Largest standard deviation (m) of a part's shape.
pub const SHAPE_SIGMA: f64 = 0.01;

/// Refuses a length beyond `most` (m).
pub fn length(what: impl Into<String>, metres: f64, most: f64) -> PyResult<()> {
    if metres <= most || metres.is_nan() {
        return Ok(());
    }
    Err(unexpected(what, format!("at most {most} m (lengths are metres)"), format!("{metres} m")))
}

/// Refuses an angle beyond `turns` whole turns.
pub fn angle(what: impl Into<String>, radians: f64, turns: f64) -> PyResult<()> {
    let most = turns * std::f64::consts::TAU;
    if radians.abs() <= most || radians.is_nan() {
        return Ok(());
    }
    Err(unexpected(what, format!("at most {most:.3} rad (angles are radians)"), format!("{radians} rad")))
}
