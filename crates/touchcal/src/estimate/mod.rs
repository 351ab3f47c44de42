//! The estimator: from a problem (arm, tool, fixtures, contacts) to parameters, their covariance,
//! and what the data cannot determine.

mod acceptance;
mod calibrate;
mod compare;
mod contact_mode;
mod declaration_checks;
mod effect_tests;
mod evaluate;
mod free_effects;
mod input_checks;
mod inspect;
mod model;
mod options;
mod prediction;
mod prior_tests;
mod problem;
mod result;
mod result_checks;
mod search;
mod selection;
mod summarize;
mod uncertainty;
mod untouched;

pub use crate::solver::{Loss, StopReason, Termination};
pub use acceptance::acceptance;
pub use calibrate::calibrate;
pub use compare::{Comparison, ParameterChange, compare};
pub use evaluate::{
    apply_estimate, apply_estimated_places, contact_distances, contact_poses, contact_residuals, evaluate,
};
pub use free_effects::calibrate_with_freed_effects;
pub use inspect::{Inspection, JointRange, inspect};
pub(crate) use model::parameter_count;
pub use options::{
    ContactModeOptions, DeclarationCheckOptions, EstimatorOptions, GradientDescent, IdentifiabilityOptions, Method,
    MultiStartOptions, Optimizer, SearchOptions, UnseenEffects, VarianceComponentOptions, WarningThresholds,
};
pub use prediction::{arm_fit, evaluate_held_out};
pub use problem::{
    DEFAULT_CONTACT, DEFAULT_DISTANCE_SIGMA, DEFAULT_ENCODER, Distance, EXACT_DISTANCE_SIGMA, Fixture, Noise,
    PLAUSIBLE_HARMONIC, PlacePrior, Problem, ShapeTolerance, Tool, TrendVariable, WrenchTolerance,
};
pub use result::{
    Acceptance, AcceptanceResult, Agreement, ArmFit, CommonStrain, CompetingMinimum, ContactCount, Contradiction,
    Decision, Declaration, DeclarationMistake, DeclaredLength, DeclaredValue, DescentFailure, DistanceSource,
    EffectTest, EffectValue, ErrorFrame, Estimate, Evaluation, FixtureDisplacement, FixtureDistance, FreedEffect,
    Identifiability, NoiseSigma, NullDirection, OmittedEffect, ParameterEstimate, ParameterPosterior, PosteriorEntry,
    PredictiveCheck, PriorTest, Progress, Scatter, Score, Severity, Spread, Stage, Status, TaskErrors, Verdict,
    Warning, WorkspaceUncertainty,
};
pub use selection::{
    BlockGain, ComparedModel, GroupKind, GroupMean, ModelChoice, SelectionError, SelectionObserver, SelectionProgress,
    select,
};
pub use uncertainty::{
    ToolUncertainty, configurations_within, cramer_rao, distance_uncertainty, tool_uncertainty,
    workspace_configurations,
};
