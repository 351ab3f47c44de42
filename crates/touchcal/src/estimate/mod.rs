//! The estimator: from a problem (arm, tool, fixtures, contacts) to parameters, their covariance,
//! and what the data cannot determine.

mod calibrate;
mod contact_mode;
mod effect_tests;
mod evaluate;
mod input_checks;
mod inspect;
mod model;
mod options;
mod prediction;
mod problem;
mod result;
mod result_checks;
mod search;
mod summarize;
mod uncertainty;

pub use crate::solver::{Loss, StopReason, Termination};
pub use calibrate::calibrate;
pub use evaluate::{apply_estimated_places, contact_distances, contact_poses, evaluate};
pub use inspect::{Inspection, JointRange, inspect};
pub use options::{
    ContactModeOptions, EstimatorOptions, IdentifiabilityOptions, MultiStartOptions, SearchOptions,
    VarianceComponentOptions, WarningThresholds,
};
pub use prediction::{arm_fit, evaluate_held_out};
pub use problem::{
    DEFAULT_CONTACT, DEFAULT_DISTANCE_SIGMA, DEFAULT_ENCODER, Distance, Fixture, GradientDescent, Method, Noise,
    Optimizer, PlacePrior, Problem, ShapeTolerance, Tool,
};
pub use result::{
    ArmFit, CommonStrain, ContactCount, Contradiction, DistanceSource, EffectTest, EffectValue, Estimate, Evaluation,
    FixtureDistance, Identifiability, NoiseSigma, NullDirection, OmittedEffect, ParameterEstimate, ParameterPosterior,
    PosteriorEntry, Progress, Scatter, Score, Severity, Spread, Stage, Status, Verdict, Warning,
};
pub use uncertainty::{ToolUncertainty, cramer_rao, distance_uncertainty, tool_uncertainty, workspace_configurations};
