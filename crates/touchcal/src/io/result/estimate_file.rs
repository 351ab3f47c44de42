//! `estimate.json`: the result of a calibration, schema 2. Values in SI units and radians unless a
//! key says otherwise. Files of schema 1 are read too.

use std::path::Path;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::estimate_schema_1;
use crate::estimate::{DescentFailure, NoiseSigma, ParameterPosterior, PosteriorEntry};
use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place};
use crate::io::base::tool_pose::{self, of_seven};
use crate::parameter::Block;
use crate::se3::Pose;

pub use super::estimate_check_entries::{
    AcceptanceEntry, Decision, HeldOutEntry, PredictiveCheckEntry, ScatterEntry, TaskErrorsEntry,
};
pub use super::estimate_entries::{
    ContactCounts, EffectTestEntry, EffectValueEntry, FixtureResidual, FreedEffectEntry, NoiseEntry, NullDirection,
    ParameterEntry, PriorTestEntry, ResidualStats, Residuals, Severity, Status, TerminationEntry, WarningEntry,
};
pub use super::estimate_robot_entry::RobotEntry;
pub use super::estimate_tool_entries::{CompetingMinimumEntry, WorkspaceUncertaintyEntry};

/// The schema that this version writes; it reads schema 1 too.
pub const SCHEMA: u32 = 2;
/// Largest file read (bytes), 256 MiB.
pub const MAX_BYTES: u64 = 256 << 20;

/// Content of `estimate.json`: a calibration's result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimateFile {
    /// Schema of the file, always [`SCHEMA`]; files of schema 1 are converted when read.
    pub schema: u32,
    /// Whether the result may be used.
    pub status: Status,
    /// The estimated parameters, in the order of
    /// [`Estimate::parameters`](crate::estimate::Estimate::parameters).
    pub parameters: Vec<ParameterEntry>,
    /// Covariance matrix of the parameters (n × n), rows and columns in the order of `parameters`,
    /// entry (i, j) in the product of their units; rows and columns of fixed parameters are zero.
    pub covariance: Vec<Vec<f64>>,
    /// How well the tool is known across the workspace; `None` where contacts are measured by a
    /// projection, and in files of earlier versions.
    #[serde(default)]
    pub workspace_uncertainty: Option<WorkspaceUncertaintyEntry>,
    /// Number of directions of the parameters that the data determine.
    pub rank: usize,
    /// Condition number of the whitened Jacobian in units of the parameters' scales: largest over
    /// smallest singular value (1) of the directions that the data determine; `None` if there are
    /// none.
    pub condition: Option<f64>,
    /// Directions of the parameters that the data do not determine.
    pub null_space: Vec<NullDirection>,
    /// Distances of the contacts from their manifolds (mm), before and after calibration.
    pub residuals: Residuals,
    /// Numbers of rows and contacts.
    pub contacts: ContactCounts,
    /// Noise of the contacts, declared or estimated; files of earlier versions have none.
    #[serde(default)]
    pub noise: Option<NoiseEntry>,
    /// The reason why the solver stopped, with the value of its criterion.
    pub termination: TerminationEntry,
    /// Warnings about the result, those that forbid its use first.
    pub warnings: Vec<WarningEntry>,
    /// Minima that contacts do not rule out, the one with the least cost first; files of earlier
    /// versions have none.
    #[serde(default)]
    pub competing_minima: Vec<CompetingMinimumEntry>,
    /// Tests of effects that the model leaves out, the most significant first; files of earlier
    /// versions have none.
    #[serde(default)]
    pub effect_tests: Vec<EffectTestEntry>,
    /// Tests of what is declared with a standard deviation, the least p-value first; files of
    /// earlier versions have none.
    #[serde(default)]
    pub prior_tests: Vec<PriorTestEntry>,
    /// Names of effects and declarations that contacts cannot test, `friction` among them; files of
    /// earlier versions have none.
    #[serde(default)]
    pub untested: Vec<String>,
    /// Effects that were estimated in addition because contacts contradict that they are zero, in
    /// the order in which they were tried; files of earlier versions have none.
    #[serde(default)]
    pub freed_effects: Vec<FreedEffectEntry>,
    /// How far stretches of the log are from what the others predict; `None` where contacts are too
    /// few, of sampled manifolds, or the search has not converged, and in files of earlier
    /// versions.
    #[serde(default)]
    pub predictive_check: Option<PredictiveCheckEntry>,
    /// The result on contacts that were held out; `None` without any, and in files of earlier
    /// versions.
    #[serde(default)]
    pub held_out: Option<HeldOutEntry>,
    /// What is asked of the calibration, and whether it reaches that; `None` if nothing is asked,
    /// and in files of earlier versions.
    #[serde(default)]
    pub acceptance: Option<AcceptanceEntry>,
    /// What is assumed where the problem declares nothing, and other notes on its files; files of
    /// earlier versions have none.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The nominal arm; `None` in files of earlier versions.
    #[serde(default)]
    pub robot: Option<RobotEntry>,
    /// Nominal pose of the tool on the tip link, to which `tool` parameters are relative: x, y, z
    /// (m), qw, qx, qy, qz; `None` in files of earlier versions.
    #[serde(default)]
    pub tip_from_tool: Option<[f64; 7]>,
    /// Path and fingerprint of each file that was read, in the order of reading.
    pub inputs: Vec<Input>,
    /// Version of this crate that wrote the file.
    pub version: String,
    /// Time (UTC) at which the estimation ended, to the second, such as `2026-11-24T09:30:00Z`;
    /// `None` in files of earlier versions.
    #[serde(default)]
    pub created: Option<String>,
    /// Duration of the estimation (s).
    pub seconds: f64,
}

impl From<estimate_schema_1::EstimateFile1> for EstimateFile {
    fn from(old: estimate_schema_1::EstimateFile1) -> Self {
        EstimateFile {
            schema: SCHEMA,
            status: old.status,
            parameters: old.parameters.into_iter().map(estimate_schema_1::parameter).collect(),
            covariance: old.covariance,
            workspace_uncertainty: None,
            rank: old.rank,
            condition: old.condition,
            null_space: old.null_space.into_iter().map(NullDirection::from).collect(),
            residuals: old.residuals,
            contacts: old.contacts,
            noise: None,
            termination: old.termination,
            warnings: old.warnings.into_iter().map(WarningEntry::from).collect(),
            competing_minima: Vec::new(),
            effect_tests: Vec::new(),
            prior_tests: Vec::new(),
            untested: Vec::new(),
            freed_effects: Vec::new(),
            predictive_check: None,
            held_out: None,
            acceptance: None,
            notes: Vec::new(),
            robot: None,
            tip_from_tool: None,
            inputs: old.inputs,
            version: old.version,
            created: None,
            seconds: old.seconds,
        }
    }
}

impl EstimateFile {
    /// The expected error (root mean square) of the tool after and before the calibration, or that
    /// it is not known, as a phrase.
    pub fn tool_error(&self) -> String {
        let has_tool = self.parameters.iter().any(|entry| entry.block == Block::Tool.name());
        let known = self.workspace_uncertainty.as_ref();
        known.map_or_else(|| "the tool's expected error is not known".to_owned(), |tool| tool.message(has_tool))
    }

    /// The file's text, indented, with a final line break.
    ///
    /// # Errors
    /// [`IoError`] if a number is NaN or infinite, which JSON cannot hold, or the covariance is not
    /// square with a row for each parameter.
    pub fn to_json(&self) -> Result<String, IoError> {
        self.check("estimate.json")?;
        let json = serde_json::to_string_pretty(self).map_err(|error| syntax("estimate.json", &error))?;
        Ok(json + "\n")
    }

    /// Reads the text of a file of schema 1 or 2; `file` is its name for messages. Content of
    /// schema 1 is converted to schema 2.
    ///
    /// # Errors
    /// [`IoError`] if the text is no JSON, of another schema, a key is missing, unknown or of the
    /// wrong kind, a number is out of range, or the covariance is not square with a row for each
    /// parameter.
    pub fn from_json(text: &str, file: &str) -> Result<EstimateFile, IoError> {
        /// The key that says how to read the others.
        #[derive(Deserialize)]
        struct Head {
            schema: u64,
        }
        let head: Head = serde_json::from_str(text).map_err(|error| syntax(file, &error))?;
        let estimate: EstimateFile = match head.schema {
            1 => serde_json::from_str::<estimate_schema_1::EstimateFile1>(text).map(EstimateFile::from),
            2 => serde_json::from_str(text),
            other => {
                let place = Place::file(file).field("schema");
                return Err(IoError::unexpected(place, "schema 1 or 2", format!("{other}")));
            }
        }
        .map_err(|error| syntax(file, &error))?;
        estimate.check(file)?;
        Ok(estimate)
    }

    /// Reads an `estimate.json` of schema 1 or 2.
    ///
    /// # Errors
    /// As [`EstimateFile::from_json`], and if the file cannot be read, is larger than
    /// [`MAX_BYTES`], or is of a calibration whose writing was interrupted.
    pub fn read_file(path: &Path) -> Result<EstimateFile, IoError> {
        EstimateFile::read_with_input(path).map(|(file, _)| file)
    }

    /// The same, and the fingerprint of what was read.
    ///
    /// # Errors
    /// As [`read_file`](Self::read_file).
    pub fn read_with_input(path: &Path) -> Result<(EstimateFile, Input), IoError> {
        let (text, input) = bytes::read_text(path, MAX_BYTES)?;
        Ok((EstimateFile::from_json(&text, &input.path)?, input))
    }

    /// Checks that the nominal arm of the calibration is `expected`; `file` is its name for
    /// messages. Files of earlier versions do not say which arm it was, and pass.
    ///
    /// # Errors
    /// [`IoError`] if it is another arm.
    pub fn check_robot(&self, expected: &RobotEntry, file: &str) -> Result<(), IoError> {
        let Some(found) = self.robot.as_ref().filter(|found| !found.is_same_arm(expected)) else { return Ok(()) };
        Err(IoError::unexpected(Place::file(file).field("robot"), expected.words(), found.words()))
    }

    /// Checks that an estimated pose of the tool leads from `tip_from_tool`, that of another
    /// problem; `file` is the name of this file for messages. Files of earlier versions, and
    /// calibrations that did not estimate the tool, pass.
    ///
    /// # Errors
    /// [`IoError`] if it leads from another pose: the estimate would be applied to the wrong one.
    pub fn check_tool(&self, tip_from_tool: &Pose, file: &str) -> Result<(), IoError> {
        let is_estimated = self.parameters.iter().any(|entry| entry.block == Block::Tool.name());
        let Some(nominal) = self.tip_from_tool.filter(|_| is_estimated).map(of_seven) else { return Ok(()) };
        let whose = format!("as in the calibrated problem, since the estimate in {file} is relative to it");
        tool_pose::check_same(&nominal, tip_from_tool, &whose)
    }

    /// As [`Estimate::has_identifiability`](crate::estimate::Estimate::has_identifiability).
    pub fn has_identifiability(&self) -> bool {
        !self.warnings.iter().any(|warning| warning.kind == DescentFailure::KIND)
    }

    /// What the calibration knows of its parameters; `None` if it has no uncertainty, because
    /// contacts were measured by a projection.
    pub fn posterior(&self) -> Option<ParameterPosterior> {
        let entries = self.parameters.iter().map(|entry| PosteriorEntry {
            name: entry.name.clone(),
            value: entry.value,
            prior_sigma: entry.prior_sigma,
        });
        let size = self.parameters.len();
        let has_uncertainty = self.parameters.iter().any(|entry| entry.sigma.is_some());
        has_uncertainty.then(|| ParameterPosterior {
            entries: entries.collect(),
            covariance: DMatrix::from_fn(size, size, |i, j| self.covariance[i][j]),
            noise: self.noise.map(|NoiseEntry { encoder, contact }| NoiseSigma { encoder, contact }),
        })
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
            ("noise.encoder", self.noise.map(|noise| noise.encoder)),
            ("noise.contact", self.noise.map(|noise| noise.contact)),
        ];
        let single = single.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?)));
        let tool = self.workspace_uncertainty.iter().flat_map(WorkspaceUncertaintyEntry::numbers);
        let tool = tool.map(|(key, value)| (format!("workspace_uncertainty.{key}"), value));
        let tests = self.effect_tests.iter().flat_map(EffectTestEntry::numbers);
        let declared = self.prior_tests.iter().flat_map(PriorTestEntry::numbers);
        let minima = self.competing_minima.iter().flat_map(CompetingMinimumEntry::numbers);
        let minima = minima.map(|value| ("competing_minima".to_owned(), value));
        let predictive_check = self.predictive_check.iter().flat_map(PredictiveCheckEntry::numbers);
        let predictive_check = predictive_check.map(|value| ("predictive_check".to_owned(), value));
        let held_out = self.held_out.iter().flat_map(HeldOutEntry::numbers);
        let held_out = held_out.map(|value| ("held_out".to_owned(), value));
        let freed = self.freed_effects.iter().flat_map(|freed| {
            let all = [Some(freed.p_value), Some(freed.gain), freed.predictive_ratio].into_iter().flatten();
            all.map(move |value| (format!("freed_effects, {}", freed.effect), value))
        });
        let acceptance = self.acceptance.iter().flat_map(AcceptanceEntry::numbers);
        let acceptance = acceptance.map(|value| ("acceptance".to_owned(), value));
        parameters
            .chain(tests)
            .chain(declared)
            .chain(acceptance)
            .chain(minima)
            .chain(tool)
            .chain(freed)
            .chain(predictive_check)
            .chain(held_out)
            .chain(covariance)
            .chain(null)
            .chain(residuals)
            .chain(single)
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
