//! What an estimation ends with: values, never log text.

mod acceptance;
mod arm_fit;
mod competing_minimum;
mod declaration_mistake;
mod descent_failure;
mod effect_test;
mod estimate;
mod evaluation;
mod identifiability;
mod posterior;
mod predictive_check;
mod prior_test;
mod progress;
mod score;
mod status;
mod warning;
mod warning_text;
mod workspace_uncertainty;

pub use acceptance::{Acceptance, AcceptanceResult, Decision, ErrorFrame, TaskErrors};
pub use arm_fit::{ArmFit, FixtureDisplacement};
pub use competing_minimum::CompetingMinimum;
pub use declaration_mistake::{Agreement, DeclarationMistake, DeclaredLength};
pub use descent_failure::DescentFailure;
pub use effect_test::{EffectTest, EffectValue, FreedEffect, OmittedEffect};
pub use estimate::{ContactCount, Estimate, NoiseSigma, ParameterEstimate, Verdict};
pub use evaluation::{CommonStrain, Contradiction, DistanceSource, Evaluation, FixtureDistance, Scatter};
pub use identifiability::{Identifiability, NullDirection};
pub use posterior::{ParameterPosterior, PosteriorEntry};
pub use predictive_check::PredictiveCheck;
pub use prior_test::{Declaration, DeclaredValue, PriorTest};
pub(crate) use progress::Observer;
pub use progress::{Progress, Stage};
pub use score::{Score, Spread};
pub use status::{Severity, Status};
pub use warning::Warning;
pub use workspace_uncertainty::WorkspaceUncertainty;
