//! What is known at the minimum: covariance, identifiability, and the uncertainty of the tool.

mod cramer_rao;
mod design_effect;
mod identifiability;
mod posterior;
mod predictive_check;
mod sandwich;
mod score_test;
mod tool_motion;
mod workspace;

pub use cramer_rao::cramer_rao;
pub(crate) use identifiability::{GaugeFix, gauge_fix};
pub(crate) use posterior::Posterior;
pub(crate) use predictive_check::predictive_check;
pub(crate) use sandwich::{Sandwich, curvature_and_squares, sandwich_covariance};
pub(crate) use score_test::{Derivatives, ScoreTest, score_test, unseen_changes};
pub(crate) use tool_motion::{ToolMotion, tool_jacobians};
pub(crate) use workspace::{
    ArmUncertainty, CalibratedTool, SAMPLED_POSITIONS, arm_uncertainty, tool_distance, tool_positions,
    workspace_uncertainty,
};
pub use workspace::{
    ToolUncertainty, configurations_within, distance_uncertainty, tool_uncertainty, workspace_configurations,
};
