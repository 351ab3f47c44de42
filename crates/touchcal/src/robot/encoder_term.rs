//! Errors of an encoder that depend on the position that it measures.

use serde::{Deserialize, Serialize};

/// A term of the error of a joint's encoder, measured less true position, as a function of the
/// measured position `q` (rad).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum EncoderTerm {
    /// `sin q`: a harmonic of once a turn.
    Sine,
    /// `cos q`: the other phase of it.
    Cosine,
}

impl EncoderTerm {
    /// All terms.
    pub const ALL: [EncoderTerm; 2] = [EncoderTerm::Sine, EncoderTerm::Cosine];

    /// Error of the position `q` (rad) that is measured, for an amplitude of 1.
    pub fn error(self, q: f64) -> f64 {
        match self {
            EncoderTerm::Sine => q.sin(),
            EncoderTerm::Cosine => q.cos(),
        }
    }

    /// Derivative of [`error`](EncoderTerm::error) by the position `q` (rad).
    pub fn slope(self, q: f64) -> f64 {
        match self {
            EncoderTerm::Sine => q.cos(),
            EncoderTerm::Cosine => -q.sin(),
        }
    }
}
