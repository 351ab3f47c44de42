//! Calibrations of problems with false declarations: whether their answers are honest.
//!
//! A simulated or recorded arm is calibrated with a problem in which something is declared that is
//! not so, such as the place of the hole. The answer is *honest* if it is refused (its status is
//! not usable), or if the errors of the arm's parameters lie within the reported covariance: their
//! NEES is below the 99.9 % quantile of χ². It is *useful* if it is honest and not refused.

mod declare;
mod draw;
mod excitation;
mod falsification;
mod kind;
mod quantity;
mod recorded;
mod summary;
mod trial;

pub use excitation::Excitation;
pub use falsification::{Displacement, Falsification};
pub use kind::{Declared, FalsifiedKind};
pub use quantity::Quantity;
pub use recorded::{falsified_recorded_trial, has_recorded};
pub use summary::FalsifiedSummary;
pub use trial::{FalsifiedError, FalsifiedOptions, FalsifiedRow, falsified_trial};
