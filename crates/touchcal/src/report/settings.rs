//! What was chosen for a calibration, and the units of the page.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::estimate::{Estimate, Method, Noise, NoiseSigma, Problem};
use crate::parameter::Unit;

/// Symbol of each unit in SI, to its factor, symbol and decimals for people.
pub(super) type Units = BTreeMap<&'static str, (f64, &'static str, usize)>;

/// As the terminal shows them.
pub(super) fn units() -> Units {
    Unit::ALL.into_iter().map(|unit| (unit.symbol(), unit.in_user_units())).collect()
}

/// The page's data of the method and the noise.
#[derive(Serialize)]
pub(super) struct Settings {
    method: &'static str,
    /// Declared, or initial values if it is estimated.
    declared: NoiseEntry,
    found: NoiseEntry,
    is_estimated: bool,
    /// Scatter of the contacts over the declared noise.
    factor: f64,
}

/// Standard deviations of encoders (rad) and contacts (m).
#[derive(Serialize)]
struct NoiseEntry {
    encoder: f64,
    contact: f64,
}

impl Settings {
    /// Those of `problem` and of its result.
    pub fn new(problem: &Problem, estimate: &Estimate) -> Self {
        let Noise { encoder, contact, is_estimated } = problem.noise;
        let declared = NoiseEntry { encoder, contact };
        let NoiseSigma { encoder, contact } = estimate.noise;
        Settings {
            method: match problem.method {
                Method::LevenbergMarquardt => "Levenberg–Marquardt",
                Method::GradientDescent(_) => "gradient descent",
            },
            declared,
            found: NoiseEntry { encoder, contact },
            is_estimated,
            factor: estimate.noise_factor,
        }
    }
}
