//! The cost of a candidate contact that leaves the gate.

use crate::estimate::options::ContactModeOptions;

/// Least width (m) of the fade: where there is no noise, too.
const MIN_WIDTH: f64 = 1e-12;

/// A term of the cost with its first two derivatives by the distance (1, 1/m, 1/m²).
#[derive(Clone, Copy, Debug)]
pub(super) struct GateCost {
    /// The term (1), −1 to 0.
    pub cost: f64,
    /// First derivative by the distance (1/m).
    pub slope: f64,
    /// Second derivative by the distance (1/m²).
    pub curvature: f64,
}

/// What a candidate at `distance` (m) with noise of standard deviation `sigma` (m) adds to the
/// cost: −1 up to `gate_fade` standard deviations, 0 from `gate` on, a cubic between.
///
/// The distribution of free distances pushes candidates away from zero. Evenly spread free
/// distances have no preference, so on average they must be pushed back as much before they leave
/// the gate. The fade is smooth because active contacts come that far too, and the derivative of
/// their score counts.
pub(super) fn gate_cost(distance: f64, sigma: f64, options: &ContactModeOptions) -> GateCost {
    let width = ((options.gate - options.gate_fade) * sigma).max(MIN_WIDTH);
    let x = ((distance - options.gate_fade * sigma) / width).clamp(0.0, 1.0);
    let is_within = f64::from(u8::from(x > 0.0 && x < 1.0));
    GateCost {
        cost: x * x * (3.0 - 2.0 * x) - 1.0,
        slope: 6.0 * x * (1.0 - x) / width,
        curvature: is_within * 6.0 * (1.0 - 2.0 * x) / (width * width),
    }
}
