//! The entries of `estimate.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::estimate;

/// Whether a calibration's result may be used: [`estimate::Status`] in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The result may be used; `converged` in files of earlier versions.
    #[serde(alias = "converged")]
    Usable,
    /// The result may be used; warnings say what contacts contradict.
    Doubtful,
    /// The result must not be used: the solver did not converge (`not_converged` in files of
    /// earlier versions), or a warning forbids it.
    #[serde(alias = "not_converged")]
    NotUsable,
}

/// An estimated parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterEntry {
    /// Unique name, such as `joint_offset.joint_a1`.
    pub name: String,
    /// Name of the parameter's block, such as `joint_offset`.
    pub block: String,
    /// Unit of the parameter: `m`, `rad`, `rad/(N m)` or `1`.
    pub unit: String,
    /// Estimate, in the parameter's unit; 0 where the parameter was fixed.
    pub value: f64,
    /// Standard deviation, in the parameter's unit; `None` if neither data nor prior bound the
    /// parameter, or contacts are measured by a projection.
    pub sigma: Option<f64>,
    /// Standard deviation of the prior, in the parameter's unit, the estimated one of a variance
    /// component; `None` for a flat prior.
    pub prior_sigma: Option<f64>,
    /// Whether the data determine the parameter, see
    /// [`ParameterEstimate::identifiable`](estimate::ParameterEstimate::identifiable).
    pub identifiable: bool,
}

/// A direction of the parameters that the data do not determine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NullDirection {
    /// The direction as a phrase.
    pub description: String,
    /// Components by parameter name, in units of the parameters' scales, the largest ±1; those
    /// below a thousandth are left out.
    pub direction: BTreeMap<String, f64>,
}

/// Distances of the contacts from their manifolds, before and after calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Residuals {
    /// Distances (mm) with the nominal arm.
    pub prefit: ResidualStats,
    /// Distances (mm) with the calibrated arm.
    pub postfit: ResidualStats,
}

/// Distances of contacts from their manifolds, over all contacts and for each fixture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualStats {
    /// Mean distance (mm); `None` without contacts.
    pub mean_mm: Option<f64>,
    /// Root mean square distance (mm); `None` without contacts.
    pub rms_mm: Option<f64>,
    /// Largest distance (mm); `None` without contacts.
    pub max_mm: Option<f64>,
    /// Distances of each fixture's contacts, by fixture name; every fixture has an entry.
    pub per_fixture: BTreeMap<String, FixtureResidual>,
}

/// Distances of one fixture's contacts from its manifold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixtureResidual {
    /// Number of the fixture's contacts.
    pub contacts: usize,
    /// Mean distance (mm); `None` without contacts.
    pub mean_mm: Option<f64>,
    /// Root mean square distance (mm); `None` without contacts.
    pub rms_mm: Option<f64>,
    /// Largest distance (mm); `None` without contacts.
    pub max_mm: Option<f64>,
}

/// Numbers of rows and contacts that were read, used and rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactCounts {
    /// Rows read from the logs, in contact or not.
    pub read: u64,
    /// Contacts that the estimate uses; used and rejected contacts are all contacts.
    pub used: u64,
    /// Contacts rejected by the robust loss.
    pub rejected: u64,
}

/// Standard deviations of the measurement noise: [`estimate::NoiseSigma`] in the file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseEntry {
    /// Of each revolute joint's measured position (rad).
    pub encoder: f64,
    /// Of each residual row apart from the encoders (m).
    pub contact: f64,
}

/// The criterion that stopped the solver, and its value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TerminationEntry {
    /// Name of the reason why the solver stopped: [`StopReason::name`](estimate::StopReason::name).
    pub reason: String,
    /// Value of the criterion at the end, dimensionless: the Newton decrement, or with gradient
    /// descent the share of the loss that a further step would remove, see
    /// [`Termination::measured`](estimate::Termination::measured); `None` if not finite.
    pub measured: Option<f64>,
    /// Value of the criterion (1) up to which the solver counts as converged; `None` if not finite.
    pub threshold: Option<f64>,
    /// Number of linearizations in all stages, or of steps of gradient descent.
    pub iterations: usize,
}

/// A score test of an effect that the model leaves out: [`estimate::EffectTest`] in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectTestEntry {
    /// Name of the effect: [`OmittedEffect::name`](estimate::OmittedEffect::name).
    pub effect: String,
    /// The effect as a sentence.
    pub description: String,
    /// Score statistic (1), chi-squared distributed if the effect is zero.
    pub statistic: f64,
    /// Number of directions that were tested.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic as large by chance, corrected for the number of tests.
    pub p_value: f64,
    /// Values that the effect's parameters would take, in their SI units, by name.
    pub values: BTreeMap<String, EffectValueEntry>,
    /// Root mean square motion of the tool over the workspace if the effect were estimated (mm).
    pub displacement_mm: f64,
    /// Root mean square radius of the tool's reported 95 % region over the workspace (mm).
    pub radius_mm: f64,
}

/// The value that a parameter of an effect would take.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectValueEntry {
    /// One-step estimate (SI).
    pub value: f64,
    /// Standard deviation of that estimate (SI).
    pub sigma: f64,
}

impl From<&estimate::EffectTest> for EffectTestEntry {
    fn from(test: &estimate::EffectTest) -> Self {
        let values = test
            .values
            .iter()
            .map(|entry| (entry.name.clone(), EffectValueEntry { value: entry.value, sigma: entry.sigma }));
        EffectTestEntry {
            effect: test.effect.name(),
            description: test.effect.description(),
            statistic: test.statistic,
            degrees_of_freedom: test.degrees_of_freedom,
            p_value: test.p_value,
            values: values.collect(),
            displacement_mm: 1e3 * test.displacement,
            radius_mm: 1e3 * test.radius,
        }
    }
}

/// An effect that was estimated in addition: [`estimate::FreedEffect`] in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FreedEffectEntry {
    /// Name of the effect: [`OmittedEffect::name`](estimate::OmittedEffect::name).
    pub effect: String,
    /// Corrected probability that what contacts show of it is chance.
    pub p_value: f64,
    /// What the log-likelihood gains by the effect, to second order.
    pub gain: f64,
    /// Ratio of the predictive check without the effect; `None` where there is none.
    pub predictive_ratio: Option<f64>,
}

impl From<&estimate::FreedEffect> for FreedEffectEntry {
    fn from(freed: &estimate::FreedEffect) -> Self {
        FreedEffectEntry {
            effect: freed.effect.name(),
            p_value: freed.p_value,
            gain: freed.gain,
            predictive_ratio: freed.predictive_ratio,
        }
    }
}

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

impl ScatterEntry {
    /// All numbers of the entry.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
        [self.found_mm, self.predicted_mm, self.ratio].into_iter().chain(self.by_chance)
    }
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
}

impl AcceptanceEntry {
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
            errors: result.errors.as_ref().map(|errors| TaskErrorsEntry {
                probability: errors.probability,
                distance_mm: 1e3 * errors.distance,
                angle_deg: errors.angle.to_degrees(),
                worst_pose: errors.worst_pose + 1,
                parameter: errors.parameter.clone(),
                share: errors.share,
            }),
            message: result.message(asked),
            advice: result.advice(),
        }
    }
}

/// Consequence of a warning for the use of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The result must not be used.
    Unusable,
    /// Contacts contradict something: the result is doubtful.
    Doubtful,
    /// Worth knowing where the result is used; in files of earlier versions also doubts.
    Caution,
}

/// A warning about the result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WarningEntry {
    /// Kind of the warning as an identifier, such as `too_few_contacts`:
    /// [`Warning::kind`](estimate::Warning::kind).
    pub kind: String,
    /// Whether the result may be used in spite of the warning.
    pub severity: Severity,
    /// Description of the problem: [`Warning::message`](estimate::Warning::message).
    pub message: String,
    /// What to do about it, in a sentence or phrase:
    /// [`Warning::advice`](estimate::Warning::advice), or the tool's estimated pose to be declared.
    pub advice: String,
}

impl From<&estimate::Warning> for WarningEntry {
    fn from(warning: &estimate::Warning) -> Self {
        WarningEntry {
            kind: warning.kind().to_owned(),
            severity: match warning.severity() {
                estimate::Severity::Unusable => Severity::Unusable,
                estimate::Severity::Doubtful => Severity::Doubtful,
                estimate::Severity::Caution => Severity::Caution,
            },
            message: warning.message(),
            advice: warning.advice().to_owned(),
        }
    }
}
