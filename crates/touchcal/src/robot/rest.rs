//! Where compliant joints come to rest.

use super::gravity_torque::{Gravity, JointTorques};
use super::joint_load::JointLoad;
use super::joint_stage::JointStage;

/// Largest number of fixed-point iterations for the positions of deflected joints. Each reduces
/// the error by the factor `d' ∂τ/∂q` with the slope `d'` of the deflection, 1 % for compliances of
/// 1e-4 rad/(N m); they diverge above 1.
pub(super) const DEFLECTION_ITERATIONS: usize = 50;
/// Change of a position (rad, m) or a derivative from which an iteration has converged.
pub(super) const CONVERGED: f64 = 1e-13;

/// Joint positions of the arm at rest, `θᵢ = qᵢ − bᵢ + dᵢ(τᵢ(θ))`, and the torques there.
pub(super) fn come_to_rest(
    gravity: &Gravity,
    chain: (&[JointStage], &JointStage),
    (q, load): (&[f64], JointLoad<'_>),
    positions: &mut [f64],
    torques: &mut JointTorques,
) {
    for ((position, stage), q) in positions.iter_mut().zip(chain.0).zip(q) {
        *position = q - stage.offset;
    }
    for _ in 0..DEFLECTION_ITERATIONS {
        torques.update(gravity, load, chain, positions);
        let mut change = 0.0f64;
        for (i, (stage, q)) in chain.0.iter().zip(q).enumerate() {
            let at_rest = q - stage.offset + stage.deflection.at(torques.torque(i));
            change = change.max((at_rest - positions[i]).abs());
            positions[i] = at_rest;
        }
        if change <= CONVERGED {
            break;
        }
    }
}
