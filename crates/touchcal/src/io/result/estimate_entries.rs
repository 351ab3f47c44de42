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

impl Status {
    /// Name in files and for programs: `usable`, `doubtful`, `not_usable`.
    pub fn name(self) -> &'static str {
        estimate::Status::from(self).name()
    }
}

impl From<estimate::Status> for Status {
    fn from(status: estimate::Status) -> Self {
        match status {
            estimate::Status::Usable => Status::Usable,
            estimate::Status::Doubtful => Status::Doubtful,
            estimate::Status::NotUsable => Status::NotUsable,
        }
    }
}

impl From<Status> for estimate::Status {
    fn from(status: Status) -> Self {
        match status {
            Status::Usable => estimate::Status::Usable,
            Status::Doubtful => estimate::Status::Doubtful,
            Status::NotUsable => estimate::Status::NotUsable,
        }
    }
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
    /// What would determine it besides other contacts; `None` where nothing that is declared takes
    /// part, and in files of earlier versions.
    #[serde(default)]
    pub remedy: Option<String>,
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
    /// Key and table of a problem file that leave the effect out.
    pub declared_in: String,
    /// What to do about it.
    pub remedy: String,
    /// Score statistic (1), chi-squared distributed if the effect is zero.
    pub statistic: f64,
    /// Number of directions that were tested.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic as large by chance, corrected for the number of tests.
    pub p_value: f64,
    /// Values that the effect's parameters would take, in their SI units, by name.
    pub values: BTreeMap<String, EffectValueEntry>,
    /// Root mean square motion of the tool, in the poses of the task or over the workspace, if the
    /// effect were estimated (mm).
    pub displacement_mm: f64,
    /// Root mean square radius of the tool's reported 95 % region in the same poses (mm).
    pub radius_mm: f64,
}

/// The value that a parameter of an effect would take, or that something declared has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectValueEntry {
    /// One-step estimate of an effect, estimate less the declared value of something declared (SI).
    pub value: f64,
    /// Standard deviation of that estimate, or of the declared value (SI).
    pub sigma: f64,
}

impl EffectTestEntry {
    pub(super) fn numbers(&self) -> impl Iterator<Item = (String, f64)> {
        let values = self.values.values().flat_map(|entry| [entry.value, entry.sigma]);
        let all = [self.statistic, self.p_value, self.displacement_mm, self.radius_mm].into_iter().chain(values);
        all.map(move |value| (format!("effect_tests, {}", self.effect), value))
    }
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
            declared_in: test.effect.declared_in(),
            remedy: test.effect.remedy().to_owned(),
            statistic: test.statistic,
            degrees_of_freedom: test.degrees_of_freedom,
            p_value: test.p_value,
            values: values.collect(),
            displacement_mm: 1e3 * test.displacement,
            radius_mm: 1e3 * test.radius,
        }
    }
}

/// A test of something declared with a standard deviation: [`estimate::PriorTest`] in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriorTestEntry {
    /// What is declared: [`Declaration::name`](estimate::Declaration::name).
    pub name: String,
    /// What is declared, in words.
    pub description: String,
    /// Keys and table of a problem file that declare it.
    pub declared_in: String,
    /// What to do where contacts contradict it.
    pub remedy: String,
    /// Statistic (1), chi-squared distributed if what is declared is right.
    pub statistic: f64,
    /// Number of directions that were tested.
    pub degrees_of_freedom: usize,
    /// Probability of a statistic as large by chance, corrected for the number of tests.
    pub p_value: f64,
    /// Estimates less the declared values, and the standard deviations declared, by name (SI): see
    /// [`DeclaredValue`](estimate::DeclaredValue).
    pub values: BTreeMap<String, EffectValueEntry>,
    /// Root mean square motion of the tool between this result and the one with what is declared
    /// held exact (mm); `None` for noise, and where nothing changes the quantity.
    pub displacement_mm: Option<f64>,
}

impl PriorTestEntry {
    pub(super) fn numbers(&self) -> impl Iterator<Item = (String, f64)> {
        let values = self.values.values().flat_map(|entry| [entry.value, entry.sigma]);
        let all = [self.statistic, self.p_value].into_iter().chain(self.displacement_mm).chain(values);
        all.map(move |value| (format!("prior_tests, {}", self.name), value))
    }
}

impl From<&estimate::PriorTest> for PriorTestEntry {
    fn from(test: &estimate::PriorTest) -> Self {
        let entry = |entry: &estimate::DeclaredValue| {
            (entry.name.clone(), EffectValueEntry { value: entry.value, sigma: entry.sigma })
        };
        PriorTestEntry {
            name: test.declaration.name(),
            description: test.declaration.description(),
            declared_in: test.declaration.declared_in(),
            remedy: test.declaration.remedy().to_owned(),
            statistic: test.statistic,
            degrees_of_freedom: test.degrees_of_freedom,
            p_value: test.p_value,
            values: test.values.iter().map(entry).collect(),
            displacement_mm: test.displacement.map(|displacement| 1e3 * displacement),
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
    /// Ratio of the predictive check without the effect, with all others that are freed; `None`
    /// where there is none.
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

/// Consequence of a warning for the use of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The result must not be used.
    Unusable,
    /// Contacts contradict something, or are few: the result is doubtful.
    Doubtful,
    /// Worth knowing where the result is used; in files of earlier versions also doubts.
    Caution,
}

impl From<estimate::Severity> for Severity {
    fn from(severity: estimate::Severity) -> Self {
        match severity {
            estimate::Severity::Unusable => Severity::Unusable,
            estimate::Severity::Doubtful => Severity::Doubtful,
            estimate::Severity::Caution => Severity::Caution,
        }
    }
}

impl From<Severity> for estimate::Severity {
    fn from(severity: Severity) -> Self {
        match severity {
            Severity::Unusable => estimate::Severity::Unusable,
            Severity::Doubtful => estimate::Severity::Doubtful,
            Severity::Caution => estimate::Severity::Caution,
        }
    }
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
            severity: warning.severity().into(),
            message: warning.message(),
            advice: warning.advice().to_owned(),
        }
    }
}
