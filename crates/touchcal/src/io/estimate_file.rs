//! `estimate.json`: the result of a calibration, schema 1. Values in SI units and radians unless a
//! key says otherwise.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::bytes;
use super::error::{IoError, Place};
use crate::estimate::Warning;

/// The schema that this version writes and reads.
pub const SCHEMA: u32 = 1;
/// Largest file read (bytes).
pub const MAX_BYTES: u64 = 256 << 20;

/// A calibration's result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimateFile {
    /// Always [`SCHEMA`].
    pub schema: u32,
    /// Whether the result may be used.
    pub status: Status,
    /// What was estimated.
    pub parameters: Vec<ParameterEntry>,
    /// Covariance of the parameters, in their order and units; square.
    pub covariance: Vec<Vec<f64>>,
    /// How many directions of the parameters the data determine.
    pub rank: usize,
    /// Condition number of the scaled Jacobian; none where it is singular.
    pub condition: Option<f64>,
    /// Directions that the data do not determine.
    pub null_space: Vec<NullDirection>,
    /// Distances from touching.
    pub residuals: Residuals,
    /// Counts of rows and contacts.
    pub contacts: ContactCounts,
    /// Why the solver stopped.
    pub termination: TerminationEntry,
    /// What the user should know.
    pub warnings: Vec<WarningEntry>,
    /// Files that were read.
    pub inputs: Vec<InputEntry>,
    /// Version of this crate that wrote the file.
    pub version: String,
    /// Time the calibration took (s).
    pub seconds: f64,
}

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
    /// In words for people.
    pub words: String,
    /// Its components by parameter name, those that matter.
    pub direction: BTreeMap<String, f64>,
}

/// Distances from touching, before and after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Residuals {
    /// With the nominal arm.
    pub prefit: ResidualStats,
    /// With the calibrated arm.
    pub postfit: ResidualStats,
}

/// Distances from touching, over all contacts and over each fixture's.
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

/// Distances from touching of one fixture's contacts.
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
    /// Contacts that had a say.
    pub used: u64,
    /// Contacts that the loss left without one.
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

/// Something the user should know.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WarningEntry {
    /// Its kind, for programs: `too_few_contacts`.
    pub kind: String,
    /// What is the matter, in words for people.
    pub words: String,
    /// What to do about it.
    pub advice: String,
}

impl From<&Warning> for WarningEntry {
    fn from(warning: &Warning) -> Self {
        WarningEntry { kind: warning.kind().to_owned(), words: warning.message(), advice: warning.advice().to_owned() }
    }
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputEntry {
    /// Its path.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

impl From<&bytes::Input> for InputEntry {
    fn from(input: &bytes::Input) -> Self {
        InputEntry { path: input.path.clone(), sha256: input.sha256.clone() }
    }
}

impl EstimateFile {
    /// The file's text, indented, with a final line break.
    ///
    /// # Errors
    /// If a number is NaN or infinite, which JSON cannot hold, or the covariance does not fit the
    /// parameters.
    pub fn to_json(&self) -> Result<String, IoError> {
        self.check("estimate.json")?;
        let json = serde_json::to_string_pretty(self).map_err(|error| syntax("estimate.json", &error))?;
        Ok(json + "\n")
    }

    /// Reads the text of a file; `file` is its name for messages.
    ///
    /// # Errors
    /// If it is no JSON, of another schema, or a key is missing, unknown or of the wrong kind.
    pub fn from_json(text: &str, file: &str) -> Result<EstimateFile, IoError> {
        /// The key that says how to read the others.
        #[derive(Deserialize)]
        struct Head {
            schema: u64,
        }
        let head: Head = serde_json::from_str(text).map_err(|error| syntax(file, &error))?;
        if head.schema != u64::from(SCHEMA) {
            let place = Place::file(file).field("schema");
            return Err(IoError::unexpected(place, format!("schema {SCHEMA}"), format!("{}", head.schema)));
        }
        let estimate: EstimateFile = serde_json::from_str(text).map_err(|error| syntax(file, &error))?;
        estimate.check(file)?;
        Ok(estimate)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// As [`EstimateFile::from_json`], and if the file cannot be read.
    pub fn read_file(path: &Path) -> Result<EstimateFile, IoError> {
        let (text, input) = bytes::read_text(path, MAX_BYTES)?;
        EstimateFile::from_json(&text, &input.path)
    }

    fn check(&self, file: &str) -> Result<(), IoError> {
        let n = self.parameters.len();
        let place = |field: String| Place::file(file).field(field);
        if self.covariance.len() != n || self.covariance.iter().any(|row| row.len() != n) {
            let rows: Vec<usize> = self.covariance.iter().map(Vec::len).take(n.min(10) + 1).collect();
            let found = format!("{} rows of {rows:?}…", self.covariance.len());
            return Err(IoError::unexpected(place("covariance".to_owned()), format!("{n} rows of {n} numbers"), found));
        }
        match self.numbers().find(|(_, value)| !value.is_finite()) {
            Some((field, value)) => Err(IoError::unexpected(place(field), "a finite number", format!("{value}"))),
            None => Ok(()),
        }
    }

    /// Every number that is a measure or an estimate, with its key.
    fn numbers(&self) -> impl Iterator<Item = (String, f64)> {
        let parameters = self.parameters.iter().flat_map(|entry| {
            let sigmas = [("sigma", entry.sigma), ("prior_sigma", entry.prior_sigma)];
            let all = [("value", Some(entry.value))].into_iter().chain(sigmas);
            all.filter_map(|(key, value)| Some((format!("parameters `{}`, {key}", entry.name), value?)))
        });
        let covariance = self.covariance.iter().enumerate().flat_map(|(i, row)| {
            row.iter().enumerate().map(move |(k, value)| (format!("covariance[{i}][{k}]"), *value))
        });
        let null = self
            .null_space
            .iter()
            .flat_map(|null| null.direction.iter().map(|(name, value)| (format!("null_space, {name}"), *value)));
        let stats = [("prefit", &self.residuals.prefit), ("postfit", &self.residuals.postfit)];
        let residuals = stats.into_iter().flat_map(|(name, stats)| {
            let overall = [stats.mean_mm, stats.rms_mm, stats.max_mm].into_iter().flatten();
            let each = stats.per_fixture.values().flat_map(|f| [f.mean_mm, f.rms_mm, f.max_mm].into_iter().flatten());
            overall.chain(each).map(move |value| (format!("residuals.{name}"), value))
        });
        let single = [
            ("condition", self.condition),
            ("termination.measured", self.termination.measured),
            ("termination.threshold", self.termination.threshold),
            ("seconds", Some(self.seconds)),
        ];
        let single = single.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?)));
        parameters.chain(covariance).chain(null).chain(residuals).chain(single)
    }
}

fn syntax(file: &str, error: &serde_json::Error) -> IoError {
    let mut place = Place::file(file);
    let mut message = error.to_string();
    if error.line() > 0 {
        place.line = Some(error.line() as u64);
        place.column = Some(error.column() as u64);
        // The place is said once.
        if let Some(end) = message.rfind(" at line ") {
            message.truncate(end);
        }
    }
    IoError::syntax(place, message)
}
