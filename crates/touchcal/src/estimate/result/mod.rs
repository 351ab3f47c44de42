//! What an estimation ends with: values, never log text.

mod declaration_mistake;
mod effect_test;
mod estimate;
mod identifiability;
mod progress;
mod score;
mod warning;

pub use declaration_mistake::{Agreement, DeclarationMistake, DeclaredLength};
pub use effect_test::{EffectTest, EffectValue, OmittedEffect};
pub use estimate::{ContactCount, Estimate, ParameterEstimate, Status, Verdict};
pub use identifiability::{Identifiability, NullDirection};
pub(crate) use progress::Observer;
pub use progress::{Progress, Stage};
pub use score::{Score, Spread};
pub use warning::{Severity, Warning};
