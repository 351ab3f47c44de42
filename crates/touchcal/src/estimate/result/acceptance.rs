//! Whether a calibration reaches what is asked of it.

use serde::{Deserialize, Serialize};

/// What is asked of a calibration: that the tool is within a tolerance of where the calibrated arm
/// has it, in all poses of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Acceptance {
    /// Largest distance (m, > 0) of the tool's origin.
    pub distance: f64,
    /// Largest angle (rad, > 0) of the tool; `None` if angles do not count.
    pub angle: Option<f64>,
    /// Probability (above 0.5, below 1) with which a pass or a fail is to be right.
    pub confidence: f64,
    /// Frame in which errors of the tool count.
    pub frame: ErrorFrame,
    /// The poses of the task: joint positions (rad, or m for a prismatic joint; exactly one for
    /// each moving joint, base first). Without any there is no decision.
    pub positions: Vec<Vec<f64>>,
}

impl Acceptance {
    /// Fewest poses with the base aligned: one or two can be moved to where they should be.
    pub const MIN_ALIGNED: usize = 3;
}

/// Frame in which errors of the tool's pose count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ErrorFrame {
    /// The arm's base.
    #[default]
    Base,
    /// The arm's base after the rigid motion with the least sum of squared distances of the tool's
    /// positions over the poses: what remains when the base is located in its cell by the tool.
    BaseAligned,
}

impl ErrorFrame {
    /// Name in files: `base`, `base_aligned`.
    pub fn name(self) -> &'static str {
        match self {
            ErrorFrame::Base => "base",
            ErrorFrame::BaseAligned => "base_aligned",
        }
    }
}

/// The answer to an [`Acceptance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Decision {
    /// The tool is within the tolerance in all poses of the task, with the confidence asked for.
    Pass,
    /// The tool is beyond the tolerance in some pose of the task, with the confidence asked for.
    Fail,
    /// Neither is as probable as was asked for, or the result must not be used.
    Undecided,
}

impl Decision {
    /// Name in files: `pass`, `fail`, `undecided`.
    pub fn name(self) -> &'static str {
        match self {
            Decision::Pass => "pass",
            Decision::Fail => "fail",
            Decision::Undecided => "undecided",
        }
    }
}

/// Whether a calibration reaches what [`Acceptance`] asks of it, by the posterior of arm and tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AcceptanceResult {
    /// The decision.
    pub decision: Decision,
    /// Whether the result may be used.
    pub is_usable: bool,
    /// How far the tool may be off; `None` where the result must not be used, or has no
    /// uncertainty of the arm: contacts are measured by a projection, or nothing of the arm and of
    /// the tool's pose is estimated.
    pub errors: Option<TaskErrors>,
    /// Whether contacts that were held out agree with the calibration
    /// ([`Evaluation::agrees`](super::Evaluation::agrees)): if they do not, it does not pass.
    pub held_out_agrees: Option<bool>,
}

/// Errors of the calibrated tool over the poses of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskErrors {
    /// Probability (0 to 1) that the tool is within the tolerance in all poses. Where found scatter
    /// is larger than predicted ([`PredictiveCheck`](super::PredictiveCheck)), errors count as
    /// larger by the same ratio.
    pub probability: f64,
    /// Largest distance (m) over the poses that is not exceeded with the confidence asked for.
    pub distance: f64,
    /// Largest angle (rad) over the poses that is not exceeded with the confidence asked for.
    pub angle: f64,
    /// The pose with the largest variance: an index into [`Acceptance::positions`].
    pub worst_pose: usize,
    /// Name of the parameter whose exact value would take away most of the variance in that pose.
    pub parameter: String,
    /// The share (0 to 1) of the variance that it would take away.
    pub share: f64,
    /// Probability (0 to 1), as [`probability`](TaskErrors::probability), with the base aligned
    /// ([`ErrorFrame::BaseAligned`]); `None` of fewer than [`Acceptance::MIN_ALIGNED`] poses.
    pub aligned_probability: Option<f64>,
    /// Whether the place of some fixture in base is declared. Without one nothing locates the base.
    pub base_is_located: bool,
}

impl AcceptanceResult {
    /// The decision as a sentence, with what `asked` asks for.
    pub fn message(&self, asked: &Acceptance) -> String {
        let name = self.decision.name().to_uppercase();
        let Some(errors) = &self.errors else {
            let reason = match (self.is_usable, asked.positions.is_empty()) {
                (false, _) => "the calibration must not be used",
                (true, true) => "the task has no poses",
                (true, false) => "the calibration has no uncertainty of the arm or the tool",
            };
            return format!("{name}: {reason}");
        };
        let tolerance = in_millimetres(asked.distance, asked.angle);
        let bound = in_millimetres(errors.distance, asked.angle.map(|_| errors.angle));
        let aligned = match asked.frame {
            ErrorFrame::Base => "",
            ErrorFrame::BaseAligned => ", with the base aligned,",
        };
        let held_out = match self.held_out_agrees {
            Some(true) => "; contacts that were held out agree",
            Some(false) => ", but contacts that were held out contradict that",
            None => "",
        };
        format!(
            "{name}: the tool is within {tolerance} in all {} poses of the task{aligned} with a probability of {:.1} %; with {:.0} % the largest error is below {bound}{held_out}",
            asked.positions.len(),
            100.0 * errors.probability,
            100.0 * asked.confidence,
        )
    }

    /// What to do next, as a phrase, with what `asked` asks for.
    pub fn advice(&self, asked: &Acceptance) -> String {
        let of_warnings = || "follow the advice of the warnings, and calibrate again".to_owned();
        match (self.decision, &self.errors) {
            (_, None) if !self.is_usable => of_warnings(),
            (_, None) if asked.positions.is_empty() => "give poses of the task in [accept]".to_owned(),
            (_, None) => {
                "estimate parameters of the arm or the tool from the exact shapes of the parts by method = \"levenberg_marquardt\"".to_owned()
            }
            (Decision::Pass, _) if self.held_out_agrees.is_some() => {
                "use it until the arm, its tool or the temperature changes".to_owned()
            }
            (Decision::Pass, _) => {
                "confirm it with contacts that were not used: held_out = true in [[contacts]]".to_owned()
            }
            (Decision::Undecided, _) if self.held_out_agrees == Some(false) => of_warnings(),
            (_, Some(errors)) => errors.advice(asked),
        }
    }
}

impl TaskErrors {
    /// What would make the errors smaller, as a phrase.
    fn advice(&self, asked: &Acceptance) -> String {
        let aligned = self.aligned_probability.filter(|_| asked.frame == ErrorFrame::Base);
        match aligned {
            Some(aligned) if !self.base_is_located || aligned >= asked.confidence => format!(
                "{}declare the place of a fixture in base (base_from_fixture and its sigma_mm), or ask for frame = \"base_aligned\" if only poses relative to each other count: with the base aligned the probability is {:.1} %",
                if self.base_is_located { "" } else { "no fixture has a place in base, so nothing locates the base: " },
                100.0 * aligned
            ),
            _ => format!(
                "record contacts in more postures and at other places: an exact `{}` would take away {:.0} % of the variance in pose {}, the worst",
                self.parameter,
                100.0 * self.share,
                self.worst_pose + 1
            ),
        }
    }
}

fn in_millimetres(distance: f64, angle: Option<f64>) -> String {
    let angle = angle.map_or_else(String::new, |angle| format!(" and {:.3}°", angle.to_degrees()));
    format!("{:.3} mm{angle}", 1e3 * distance)
}
