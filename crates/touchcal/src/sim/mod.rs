//! Simulated touching, for demonstrations and tests: what a wrong arm would log while it explores parts.
//!
//! Nothing here knows the estimator or its manifolds; the parts' geometry is all they share.

mod equilibrium;
mod insertion;
mod inverse_kinematics;

pub use equilibrium::Compliance;
pub use insertion::{Exploration, Insertion, InsertionLog, SimulationError};
pub use inverse_kinematics::follow;
