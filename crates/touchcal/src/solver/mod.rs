//! Nonlinear least squares: normal equations, Levenberg–Marquardt, robust losses, Adam.
//!
//! The module is independent of robots and contacts.

mod adam;
mod free_parameters;
mod levenberg_marquardt;
mod loss;
mod normal_equations;
mod termination;

pub(crate) use adam::AdamMoments;
pub use adam::{Adam, AdamStep};
pub(crate) use free_parameters::FreeParameters;
pub use levenberg_marquardt::LevenbergMarquardtOptions;
pub(crate) use levenberg_marquardt::{KINK_TOLERANCE, first_step, minimize};
pub use loss::Loss;
pub(crate) use normal_equations::{DampedInformation, NormalEquations};
pub use termination::{StopReason, Termination};
