//! Entries of `estimate.json` that say whether the result is as good as it says.

use serde::{Deserialize, Serialize};

use crate::estimate;

/// How far stretches of the log are from what the others predict: [`estimate::PredictiveCheck`] in
/// the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictiveCheckEntry {
    /// Scatter found over scatter predicted (1).
    pub ratio: f64,
    /// Probability of a ratio as large by chance.
    pub p_value: f64,
    /// Factor by which standard deviations were multiplied for it.
    pub widening: f64,
    /// The ratio of each stretch, in the order of the log.
    pub stretches: Vec<f64>,
}

impl PredictiveCheckEntry {
    /// All numbers of the entry.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        [self.ratio, self.p_value, self.widening].into_iter().chain(self.stretches.iter().copied())
    }
}

impl From<&estimate::PredictiveCheck> for PredictiveCheckEntry {
    fn from(check: &estimate::PredictiveCheck) -> Self {
        let estimate::PredictiveCheck { ratio, p_value, widening, stretches } = check.clone();
        PredictiveCheckEntry { ratio, p_value, widening, stretches }
    }
}

/// Scatter of contacts found and predicted: [`estimate::Scatter`] in the file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScatterEntry {
    /// Root mean square distance found (mm).
    pub found_mm: f64,
    /// Root mean square distance predicted (mm).
    pub predicted_mm: f64,
    /// Found over predicted (1).
    pub ratio: f64,
    /// Range of the ratio that holds 99.9 % of what chance makes.
    pub by_chance: [f64; 2],
}

impl From<estimate::Scatter> for ScatterEntry {
    fn from(scatter: estimate::Scatter) -> Self {
        let estimate::Scatter { found, predicted, by_chance } = scatter;
        ScatterEntry { found_mm: 1e3 * found, predicted_mm: 1e3 * predicted, ratio: scatter.ratio(), by_chance }
    }
}

/// The result on contacts that were held out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldOutEntry {
    /// Number of contacts that were held out.
    pub contacts: usize,
    /// Their scatter; `None` if it cannot be predicted.
    pub scatter: Option<ScatterEntry>,
}

impl HeldOutEntry {
    /// All numbers of the entry.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        let of_scatter = |s: ScatterEntry| [s.found_mm, s.predicted_mm, s.ratio].into_iter().chain(s.by_chance);
        self.scatter.into_iter().flat_map(of_scatter)
    }
}

/// Whether a calibration reaches what is asked of it: [`estimate::Decision`] in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decision {
    /// The tool is within the tolerance in all poses of the task.
    Pass,
    /// The tool is beyond the tolerance in some pose of the task.
    Fail,
    /// Neither is as probable as was asked for, or the result must not be used.
    Undecided,
}

/// What is asked of a calibration, and whether it reaches that:
/// [`estimate::AcceptanceResult`] in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AcceptanceEntry {
    /// The decision.
    pub decision: Decision,
    /// Largest distance of the tool that is asked for (mm).
    pub tolerance_mm: f64,
    /// Largest angle that is asked for (degrees); `None` if angles do not count.
    pub tolerance_deg: Option<f64>,
    /// Probability with which a pass or a fail is to be right.
    pub confidence: f64,
    /// Number of poses of the task.
    pub poses: usize,
    /// Frame in which errors of the tool count: `base`, `base_aligned`.
    pub frame: String,
    /// How far the tool may be off; `None` where the result must not be used.
    pub errors: Option<TaskErrorsEntry>,
    /// The decision as a sentence.
    pub message: String,
    /// What to do next, as a phrase.
    pub advice: String,
}

/// Errors of the calibrated tool over the poses of a task: [`estimate::TaskErrors`] in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskErrorsEntry {
    /// Probability that the tool is within the tolerance in all poses.
    pub probability: f64,
    /// Largest distance over the poses that is not exceeded with the confidence asked for (mm).
    pub distance_mm: f64,
    /// Largest angle over the poses that is not exceeded with the confidence asked for (degrees).
    pub angle_deg: f64,
    /// Number of the pose with the largest variance, from 1.
    pub worst_pose: usize,
    /// Name of the parameter whose exact value would take away most of the variance in that pose.
    pub parameter: String,
    /// The share (0 to 1) of that variance that it would take away.
    pub share: f64,
    /// Probability that the tool is within the tolerance in all poses with the base aligned;
    /// `None` of fewer than three poses.
    pub aligned_probability: Option<f64>,
}

impl AcceptanceEntry {
    /// All numbers of the entry.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        let asked = [Some(self.tolerance_mm), self.tolerance_deg, Some(self.confidence)];
        let found = self.errors.iter().flat_map(|e| [e.probability, e.distance_mm, e.angle_deg, e.share]);
        let aligned = self.errors.iter().filter_map(|e| e.aligned_probability);
        asked.into_iter().flatten().chain(found).chain(aligned)
    }

    /// What `asked` asks for, and the answer.
    pub fn new(asked: &estimate::Acceptance, result: &estimate::AcceptanceResult) -> Self {
        AcceptanceEntry {
            decision: match result.decision {
                estimate::Decision::Pass => Decision::Pass,
                estimate::Decision::Fail => Decision::Fail,
                estimate::Decision::Undecided => Decision::Undecided,
            },
            tolerance_mm: 1e3 * asked.distance,
            tolerance_deg: asked.angle.map(f64::to_degrees),
            confidence: asked.confidence,
            poses: asked.positions.len(),
            frame: asked.frame.name().to_owned(),
            errors: result.errors.as_ref().map(|errors| TaskErrorsEntry {
                probability: errors.probability,
                distance_mm: 1e3 * errors.distance,
                angle_deg: errors.angle.to_degrees(),
                worst_pose: errors.worst_pose + 1,
                parameter: errors.parameter.clone(),
                share: errors.share,
                aligned_probability: errors.aligned_probability,
            }),
            message: result.message(asked),
            advice: result.advice(asked),
        }
    }
}
