//! Simulated touching: what a wrong arm would log while it explores fixtures, and what was truly
//! the case.
//!
//! A [`Scenario`] says what may happen; [`simulate()`] draws a truth from a seed, lets an
//! arm under impedance control push the tool along an exploration command, and records it.
//! Quasi-static: at each command the tool rests where the springs' energy is least, gap ≥ 0.
//!
//! Nothing here knows the estimator or its manifolds; the parts' geometry is all they share.

mod equilibrium;
mod exploration;
mod inverse_kinematics;
mod parts;
mod preset;
mod recorder;
mod scenario;
mod simulate;
#[cfg(test)]
mod tests;
mod truth;

pub use equilibrium::Stiffness;
pub use exploration::Exploration;
pub use inverse_kinematics::follow;
pub use preset::{PartsError, Preset};
pub use recorder::{Recorder, WRENCH_DIGITS};
pub use scenario::{ArmErrors, Distribution, PlaceError, Scenario, Thermal, Touch};
pub use simulate::{Log, Seeds, SimulatedTrial, SimulationError, TrueRow, draw_truth, run, simulate};
pub use truth::Truth;
