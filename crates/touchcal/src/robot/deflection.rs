//! How far a joint deflects under a torque.

/// Torque (N m, or N of a prismatic joint) from which it is clear at which side of its play a joint
/// rests: a smaller one holds it in between.
pub const BACKLASH_TORQUE: f64 = 0.5;

/// What deflects a joint: `c τ + b s(τ)` with the torque `τ` of gravity and load, the compliance
/// `c`, and half of the play `b`, at whose side `s(τ) = τ / √(τ² + τ₀²)` the joint rests; `τ₀` is
/// [`BACKLASH_TORQUE`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deflection {
    /// Compliance (rad/(N m)); 0 for a prismatic joint.
    pub compliance: f64,
    /// Half of the play (rad, or m for a prismatic joint).
    pub backlash: f64,
}

impl Deflection {
    /// Of a stiff joint without play.
    pub const NONE: Deflection = Deflection { compliance: 0.0, backlash: 0.0 };

    /// The deflection (rad or m) under `torque` (N m or N).
    pub fn at(self, torque: f64) -> f64 {
        self.compliance * torque + self.backlash * side_of_play(torque)
    }

    /// Its derivative by the torque.
    pub fn slope(self, torque: f64) -> f64 {
        self.compliance + self.backlash * play_slope(torque)
    }
}

/// Derivative (1/(N m) or 1/N) by the torque (N m or N) of the side of its play at which a joint
/// rests, `τ / √(τ² + τ₀²)` with `τ₀` of [`BACKLASH_TORQUE`].
pub fn play_slope(torque: f64) -> f64 {
    BACKLASH_TORQUE.powi(2) / torque.hypot(BACKLASH_TORQUE).powi(3)
}

/// The side of its play at which a joint rests under `torque` (N m or N): its sign, smooth about 0.
pub(super) fn side_of_play(torque: f64) -> f64 {
    torque / torque.hypot(BACKLASH_TORQUE)
}
