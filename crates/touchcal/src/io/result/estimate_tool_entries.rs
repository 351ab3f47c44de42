//! Entries of `estimate.json` on where the tool is: how well that is known, and where else it may
//! be.

use serde::{Deserialize, Serialize};

use crate::estimate;
use crate::report::fixed;

/// How well the tool is known: [`estimate::WorkspaceUncertainty`] in the file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkspaceUncertaintyEntry {
    /// Standard deviation of the tool's position in base (mm), all three components together.
    pub position_mm: f64,
    /// Standard deviation of the tool's rotation vector (°), all three components together.
    pub angle_deg: f64,
    /// Standard deviation of the distance between two positions of the tool (mm).
    pub distance_mm: f64,
    /// Expected error of the nominal arm's tool: of its position in base (mm).
    pub nominal_position_mm: f64,
    /// Of its rotation (°).
    pub nominal_angle_deg: f64,
    /// Of the distance between two of its positions (mm).
    pub nominal_distance_mm: f64,
}

impl WorkspaceUncertaintyEntry {
    /// The expected errors as a phrase; the nominal tool's are with its declared pose, where that
    /// is estimated (`has_tool`).
    pub(super) fn message(&self, has_tool: bool) -> String {
        let pose = |mm, degrees| format!("{} mm, {}°", fixed(mm, 3), fixed(degrees, 3));
        let before = if has_tool { "before, with the tool as declared" } else { "before" };
        format!(
            "expected tool error in base {} ({before}: {}), between two positions {} mm (before: {} mm)",
            pose(self.position_mm, self.angle_deg),
            pose(self.nominal_position_mm, self.nominal_angle_deg),
            fixed(self.distance_mm, 3),
            fixed(self.nominal_distance_mm, 3)
        )
    }

    /// All numbers of the entry with their names.
    pub(super) fn numbers(&self) -> [(&'static str, f64); 6] {
        [
            ("position_mm", self.position_mm),
            ("angle_deg", self.angle_deg),
            ("distance_mm", self.distance_mm),
            ("nominal_position_mm", self.nominal_position_mm),
            ("nominal_angle_deg", self.nominal_angle_deg),
            ("nominal_distance_mm", self.nominal_distance_mm),
        ]
    }
}

impl From<estimate::WorkspaceUncertainty> for WorkspaceUncertaintyEntry {
    fn from(found: estimate::WorkspaceUncertainty) -> Self {
        WorkspaceUncertaintyEntry {
            position_mm: 1e3 * found.position,
            angle_deg: found.angle.to_degrees(),
            distance_mm: 1e3 * found.distance,
            nominal_position_mm: 1e3 * found.nominal_position,
            nominal_angle_deg: found.nominal_angle.to_degrees(),
            nominal_distance_mm: 1e3 * found.nominal_distance,
        }
    }
}

/// A minimum that contacts do not rule out: [`estimate::CompetingMinimum`] in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompetingMinimumEntry {
    /// Root mean square distance of the tool from where the result has it, in the poses of the task
    /// or over the workspace (mm).
    pub tool_distance_mm: f64,
    /// Cost of the least gaps over that at the result (1).
    pub cost_ratio: f64,
    /// Values of the parameters there (SI), in the order of the file's parameters.
    pub values: Vec<f64>,
}

impl CompetingMinimumEntry {
    /// All numbers of the entry, in the order of its fields.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        [self.tool_distance_mm, self.cost_ratio].into_iter().chain(self.values.iter().copied())
    }
}

impl From<&estimate::CompetingMinimum> for CompetingMinimumEntry {
    fn from(other: &estimate::CompetingMinimum) -> Self {
        CompetingMinimumEntry {
            tool_distance_mm: 1e3 * other.tool_distance,
            cost_ratio: other.cost_ratio,
            values: other.values.iter().copied().collect(),
        }
    }
}
