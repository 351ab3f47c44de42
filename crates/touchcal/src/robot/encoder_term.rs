//! Errors of a joint's measured position that depend on that position.

use serde::{Deserialize, Serialize};

/// Largest number of Newton steps for a measured position; a few are enough where the error changes
/// by much less than the position does.
const STEPS: usize = 50;
/// Step (rad, m) from which a measured position has converged, of positions up to 1; a share of
/// larger ones.
const CONVERGED: f64 = 1e-14;

/// A term of the error of a joint's encoder, measured less true position, as a function of the
/// measured position `q` (rad, or m for a prismatic joint).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum EncoderTerm {
    /// `sin q`: a harmonic of once a turn.
    Sine,
    /// `cos q`: the other phase of it.
    Cosine,
    /// `sin 2q`: a harmonic of twice a turn.
    SecondSine,
    /// `cos 2q`: the other phase of it.
    SecondCosine,
    /// `−q`: the gear between encoder and joint has another ratio, so that the true position is
    /// `(1 + amplitude) q`.
    GearRatio,
}

impl EncoderTerm {
    /// All terms.
    pub const ALL: [EncoderTerm; 5] = [
        EncoderTerm::Sine,
        EncoderTerm::Cosine,
        EncoderTerm::SecondSine,
        EncoderTerm::SecondCosine,
        EncoderTerm::GearRatio,
    ];
    /// The orders of the harmonics, as numbers of periods in a turn, each with its sine and cosine.
    pub const HARMONICS: [(u32, [EncoderTerm; 2]); 2] =
        [(1, [EncoderTerm::Sine, EncoderTerm::Cosine]), (2, [EncoderTerm::SecondSine, EncoderTerm::SecondCosine])];

    /// Error where the position `q` (rad, m) is measured, for an amplitude of 1.
    pub fn error(self, q: f64) -> f64 {
        match self {
            EncoderTerm::Sine => q.sin(),
            EncoderTerm::Cosine => q.cos(),
            EncoderTerm::SecondSine => (2.0 * q).sin(),
            EncoderTerm::SecondCosine => (2.0 * q).cos(),
            EncoderTerm::GearRatio => -q,
        }
    }

    /// Derivative of [`error`](EncoderTerm::error) by the position `q` (rad, m).
    pub fn slope(self, q: f64) -> f64 {
        match self {
            EncoderTerm::Sine => q.cos(),
            EncoderTerm::Cosine => -q.sin(),
            EncoderTerm::SecondSine => 2.0 * (2.0 * q).cos(),
            EncoderTerm::SecondCosine => -2.0 * (2.0 * q).sin(),
            EncoderTerm::GearRatio => -1.0,
        }
    }
}

/// Error of an encoder, measured less true position, where it measures `q` (rad, m), from its terms
/// and their amplitudes.
pub fn encoder_error(terms: &[(EncoderTerm, f64)], q: f64) -> f64 {
    terms.iter().map(|(term, amplitude)| amplitude * term.error(q)).sum()
}

/// Subtracts from joint positions `q` the errors of their encoders at the `measured` positions
/// (rad, or m for a prismatic joint): index of the moving joint, base first, term, and its
/// amplitude. Panics if a joint is beyond `q` or `measured`.
pub fn subtract_encoder_errors(errors: &[(usize, EncoderTerm, f64)], measured: &[f64], q: &mut [f64]) {
    errors.iter().for_each(|&(joint, term, amplitude)| q[joint] -= amplitude * term.error(measured[joint]));
}

/// The position that an encoder with these terms and amplitudes measures at the true position `q`
/// (rad, m), by Newton's method, to 1e-14. `None` if the error changes as fast as the position
/// there, so that there is no inverse.
pub fn measured_position(terms: &[(EncoderTerm, f64)], q: f64) -> Option<f64> {
    let mut measured = q;
    for _ in 0..STEPS {
        let slope: f64 = terms.iter().map(|(term, amplitude)| amplitude * term.slope(measured)).sum();
        if slope.is_nan() || slope >= 1.0 {
            return None;
        }
        let step = (measured - encoder_error(terms, measured) - q) / (1.0 - slope);
        measured -= step;
        if step.abs() <= CONVERGED * measured.abs().max(1.0) {
            return Some(measured);
        }
    }
    None
}
