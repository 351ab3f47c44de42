//! Simulated touching: the log of an arm with errors while it explores fixtures, and the true
//! errors.
//!
//! A [`Scenario`] holds the arm, its possible errors and the fixtures; [`simulate()`] draws a truth
//! from a seed, lets an arm under impedance control push the tool along an exploration command, and
//! records it. Quasi-static: at each command the tool rests where the springs' energy is least,
//! with all gaps at least 0.
//!
//! The simulator depends on neither the estimator nor its manifolds; it has the arm's kinematics,
//! the parameters and the geometry of parts in common with them.

mod arm_motion;
mod equilibrium;
mod exploration;
mod friction;
mod inverse_kinematics;
mod parts;
mod preset;
mod recorder;
mod scenario;
mod simulate;
mod simulation_error;
#[cfg(test)]
mod tests;
mod truth;

pub use equilibrium::Stiffness;
pub use exploration::Exploration;
pub use inverse_kinematics::follow;
pub use preset::{PartsError, Preset};
pub(crate) use recorder::random_walk;
pub use recorder::{Recorder, WRENCH_DIGITS};
pub use scenario::{ArmErrors, Distribution, MeasuredDistance, PlaceError, Scenario, Thermal, Touch};
pub use simulate::{Log, Seeds, SimulatedTrial, TrueRow, draw_truth, run, simulate};
pub use simulation_error::SimulationError;
pub use truth::Truth;
