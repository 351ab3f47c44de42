//! The result of one trial by one approach, as saved in a file.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use touchcal::estimate::{Estimate, Status};
use touchcal::experiment::{ToolError, Trial, random_positions, tool_error};
use touchcal::robot::Robot;

use super::saved;
use crate::failure::Failure;

/// Joint positions over the whole workspace at which arms are compared.
const WORKSPACE_POSES: usize = 1000;
/// Seed of those positions.
const WORKSPACE_SEED: u64 = 1;

/// Errors of an estimate: mean absolute ones, over the joints for the biases; `_95` is the 95 %
/// quantile over poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Fingerprint of all that the row depends on.
    pub settings: String,
    pub trial: String,
    pub approach: String,
    pub status: String,
    /// Kinds of the estimate's warnings, each once, those that forbid its use first.
    pub warnings: Vec<String>,
    pub strain_error: f64,
    pub bias_error_deg: f64,
    /// Errors before the calibration: the size of the true values.
    pub strain_before: f64,
    pub bias_before_deg: f64,
    pub hole: Tool,
    pub workspace: Tool,
    pub seconds: f64,
}

/// Errors of the tool's pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    pub mean_mm: f64,
    pub mm_95: f64,
    pub mean_deg: f64,
    pub deg_95: f64,
}

impl From<ToolError> for Tool {
    fn from(error: ToolError) -> Tool {
        Tool {
            mean_mm: 1e3 * error.mean_distance,
            mm_95: 1e3 * error.distance_95,
            mean_deg: error.mean_angle.to_degrees(),
            deg_95: error.angle_95.to_degrees(),
        }
    }
}

impl Row {
    /// Measures an estimate against the trial's truth.
    pub fn new(settings: String, trial: &Trial, approach: &str, estimate: &Estimate, seconds: f64) -> Row {
        let estimated = |column| estimate.parameters.iter().find(|p| p.parameter.id == column).map(|p| p.value);
        let error = trial.error(estimated);
        let before = trial.error(|_| None);
        let (hole, workspace) = tool_errors(trial, &estimate.robot);
        Row {
            settings,
            trial: trial.name.clone(),
            approach: approach.to_owned(),
            status: estimate.status.name().to_owned(),
            warnings: estimate.warning_kinds(),
            strain_error: error.strain,
            bias_error_deg: error.offset.to_degrees(),
            strain_before: before.strain,
            bias_before_deg: before.offset.to_degrees(),
            hole: hole.into(),
            workspace: workspace.into(),
            seconds,
        }
    }

    /// Whether the estimate is usable, with doubts or without.
    pub fn is_usable(&self) -> bool {
        self.status != Status::NotUsable.name()
    }

    /// The row saved at `path`, if it has these settings.
    pub fn load(path: &Path, settings: &str) -> Option<Row> {
        saved::load::<Row>(path).filter(|row| row.settings == settings)
    }

    /// Saves the row.
    pub fn save(&self, path: &Path) -> Result<(), Failure> {
        saved::save(path, self)
    }

    /// Path in `folder` of the row of a trial and an approach.
    pub fn path(folder: &Path, trial: &str, approach: &str) -> PathBuf {
        folder.join(saved::ROWS).join(format!("{trial}.{approach}.json"))
    }
}

/// Tool errors at the trial's contacts, and over the whole workspace.
fn tool_errors(trial: &Trial, estimate: &Robot) -> (ToolError, ToolError) {
    let truth = trial.true_robot();
    let contacts = &trial.contacts;
    let at_hole = tool_error(&truth, estimate, trial.tip_from_peg, (0..contacts.len()).map(|i| contacts.q(i)));
    let everywhere = random_positions(&trial.robot, WORKSPACE_POSES, WORKSPACE_SEED);
    let workspace = tool_error(&truth, estimate, trial.tip_from_peg, everywhere.iter().map(Vec::as_slice));
    (at_hole, workspace)
}
