//! The entries of `estimate.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::estimate;

/// Whether a result may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The solver converged.
    Converged,
    /// It stopped before.
    NotConverged,
    /// The data cannot carry a result.
    NotUsable,
}

/// One estimated number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterEntry {
    /// Unique name, `joint_offset.joint_a1`.
    pub name: String,
    /// Its block, `joint_offset`.
    pub block: String,
    /// Its unit: `m`, `rad` or `1`.
    pub unit: String,
    /// Estimate.
    pub value: f64,
    /// Standard deviation; none where the data do not determine it.
    pub sigma: Option<f64>,
    /// Standard deviation of its prior, where it has one.
    pub prior_sigma: Option<f64>,
    /// Whether the data determine it.
    pub identifiable: bool,
}

/// A direction of the parameters that the data do not determine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NullDirection {
    /// The direction in a phrase, for people.
    pub description: String,
    /// Its components by parameter name; small ones are left out.
    pub direction: BTreeMap<String, f64>,
}

/// Distances from the contact manifolds, before and after calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Residuals {
    /// With the nominal arm.
    pub prefit: ResidualStats,
    /// With the calibrated arm.
    pub postfit: ResidualStats,
}

/// Distances from the contact manifolds, of all contacts and of each fixture's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualStats {
    /// Mean (mm); none without contacts, as the others.
    pub mean_mm: Option<f64>,
    /// Root mean square (mm).
    pub rms_mm: Option<f64>,
    /// Largest (mm).
    pub max_mm: Option<f64>,
    /// By fixture name.
    pub per_fixture: BTreeMap<String, FixtureResidual>,
}

/// Distances from the contact manifold, of one fixture's contacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixtureResidual {
    /// Number of contacts.
    pub contacts: usize,
    /// Mean (mm); none without contacts, as the others.
    pub mean_mm: Option<f64>,
    /// Root mean square (mm).
    pub rms_mm: Option<f64>,
    /// Largest (mm).
    pub max_mm: Option<f64>,
}

/// Counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactCounts {
    /// Rows read, in contact or not.
    pub read: u64,
    /// Contacts with a weight.
    pub used: u64,
    /// Contacts to which the loss gave none.
    pub rejected: u64,
}

/// Why the solver stopped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TerminationEntry {
    /// The criterion that was met.
    pub reason: String,
    /// What was measured for it.
    pub measured: Option<f64>,
    /// The value it was compared with.
    pub threshold: Option<f64>,
    /// Iterations made.
    pub iterations: usize,
}

/// What a warning means for the use of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The result must not be used.
    Unusable,
    /// The result may be used, with care.
    Caution,
}

/// A warning about the result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WarningEntry {
    /// Its kind, for programs: `too_few_contacts`.
    pub kind: String,
    /// Whether the result may be used in spite of it.
    pub severity: Severity,
    /// What is the matter, in a sentence for people.
    pub message: String,
    /// What to do about it.
    pub advice: String,
}

impl From<&estimate::Warning> for WarningEntry {
    fn from(warning: &estimate::Warning) -> Self {
        WarningEntry {
            kind: warning.kind().to_owned(),
            severity: match warning.severity() {
                estimate::Severity::Unusable => Severity::Unusable,
                estimate::Severity::Caution => Severity::Caution,
            },
            message: warning.message(),
            advice: warning.advice().to_owned(),
        }
    }
}
