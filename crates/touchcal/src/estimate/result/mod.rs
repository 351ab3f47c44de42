//! What an estimation ends with: values, never log text.

mod estimate;
mod identifiability;
mod progress;
mod score;
mod warning;

pub use estimate::{ContactCount, Estimate, ParameterEstimate, Status, Verdict};
pub use identifiability::{Identifiability, NullDirection};
pub(crate) use progress::Observer;
pub use progress::{Progress, Stage};
pub use score::{Score, Spread};
pub use warning::{Severity, Warning};
