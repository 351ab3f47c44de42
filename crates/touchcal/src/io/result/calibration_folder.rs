//! A calibration's folder: `calibrated.urdf`, `correction.json`, `estimate.json` and `report.html`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use jiff::{Timestamp, Unit};
use serde::{Deserialize, Serialize};

use crate::estimate::{Estimate, Fixture, Problem, Progress, Score, Spread, Status, Warning, apply_estimate};
use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, Place};
use crate::io::base::manifest::MANIFEST;
use crate::io::base::result_folder::{self, ResultFile, ResultKind};
use crate::io::base::tool_pose::{as_declared, seven};
use crate::io::problem::loaded::Loaded;
use crate::io::result::correction_file;
use crate::io::result::estimate_file::{
    self, AcceptanceEntry, CompetingMinimumEntry, ContactCounts, EffectTestEntry, EstimateFile, FixtureResidual,
    FreedEffectEntry, HeldOutEntry, NoiseEntry, NullDirection, ParameterEntry, PredictiveCheckEntry, PriorTestEntry,
    ResidualStats, Residuals, RobotEntry, TerminationEntry, WarningEntry,
};
use crate::io::result::export::Export;
use crate::io::result::offsets_yaml;
use crate::io::robot::urdf;
use crate::report::{self, Report, WarningText};
use crate::robot::{Robot, split_offsets};

/// Name of the calibrated robot's URDF.
pub const CALIBRATED: &str = "calibrated.urdf";
/// Name of the file of the estimate.
pub const ESTIMATE: &str = "estimate.json";
/// Name of the file of what a URDF cannot say about joint positions.
pub const CORRECTION: &str = "correction.json";
/// Name of the report, an HTML page.
pub const REPORT: &str = "report.html";
/// The file for Foxglove and Rerun.
const MCAP: &str = "calibration.mcap";
/// The files for a driver that takes encoder offsets.
const DRIVER: [&str; 2] = ["driver/robot.urdf", "driver/joint_offsets.yaml"];
/// All of them.
const NAMES: [&str; 11] = [
    CALIBRATED,
    CORRECTION,
    ESTIMATE,
    REPORT,
    MCAP,
    DRIVER[0],
    DRIVER[1],
    Export::Ur.file_name(),
    Export::Dh.file_name(),
    Export::Xacro.file_name(),
    Export::Ros2Control.file_name(),
];

/// A finished calibration.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solved {
    /// Result of the estimator.
    pub estimate: Estimate,
    /// Distances (m) of the contacts from their manifolds with the nominal arm, see
    /// [`evaluate`](crate::estimate::evaluate()).
    pub prefit: Score,
    /// Progress of the estimator, one entry per step, in order; empty if it was not observed.
    pub steps: Vec<Progress>,
    /// When the estimation ended.
    pub ended: Timestamp,
    /// Duration of the estimation (s, ≥ 0).
    pub seconds: f64,
}

/// Paths of the files that were written for a calibration.
pub struct Written {
    /// Path of the calibrated URDF.
    pub urdf: PathBuf,
    /// Path of `correction.json`; `None` if the URDF says all about joint positions.
    pub correction: Option<PathBuf>,
    /// Path of `estimate.json`.
    pub estimate: PathBuf,
    /// Path of `report.html`.
    pub report: PathBuf,
    /// Paths of the URDF without encoder offsets `[0]` and of the YAML file of the offsets `[1]`,
    /// which belong together; `None` unless they were [`Wanted`] and written.
    pub driver: Option<[PathBuf; 2]>,
    /// Path of the MCAP file for Foxglove and Rerun; `None` unless it was [`Wanted`] and written.
    pub mcap: Option<PathBuf>,
    /// The files for other programs that were [`Wanted`].
    pub exports: Vec<WrittenExport>,
}

/// A file for another program that was written.
pub struct WrittenExport {
    /// Its format.
    pub export: Export,
    /// Its path.
    pub path: PathBuf,
    /// What of the calibration it lacks ([`ExportText::left_out`]).
    ///
    /// [`ExportText::left_out`]: crate::io::ExportText::left_out
    pub left_out: Vec<String>,
}

/// What a calibration's folder has besides URDF, estimate and report.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Files for a driver that takes encoder offsets.
    pub driver: bool,
    /// `calibration.mcap`, for Foxglove and Rerun (cargo feature `mcap`; without effect without
    /// it).
    pub mcap: bool,
    /// Files for other programs; a format that is named twice is written once.
    pub exports: Vec<Export>,
}

/// Paths of all files that a calibration may write into `folder`, whether or not they exist: URDF,
/// estimate, report, MCAP file, the two files for a driver in `folder/driver`, the files for
/// other programs ([`Export`]), and the manifest.
pub fn paths(folder: &Path) -> Vec<PathBuf> {
    NAMES.iter().chain([&MANIFEST]).map(|name| folder.join(name)).collect()
}

/// Checks that `folder` has no file that a calibration would replace and that touchcal did not
/// write.
///
/// # Errors
/// [`IoError`] with the path of such a file.
pub fn check_folder(folder: &Path) -> Result<(), IoError> {
    result_folder::check(folder, ResultKind::Calibration, &NAMES, former_names(folder))
}

/// Writes `calibrated.urdf`, `estimate.json`, `report.html`, `correction.json` if joints need
/// corrections that no URDF can say ([`correction_file`]), and what else is `wanted` into `folder`,
/// in place of a former calibration; `file` is what [`estimate_file()`] made of `solved`.
/// Missing folders are made. `touchcal.json` lists the files and says whether all are written: if
/// writing is interrupted, the folder may hold files of two calibrations, which
/// [`urdf::read_file`] and [`EstimateFile::read_file`] refuse.
///
/// There are no files for a driver if the nominal chain has other joints than the calibrated one.
///
/// # Errors
/// [`IoError`] if one of the files cannot be made (see [`calibrated_urdf`],
/// [`EstimateFile::to_json`], [`page`], [`Export::of`]) or written, as
/// [`check_folder`], and if another run is writing into the folder.
pub fn write(
    folder: &Path,
    loaded: &Loaded,
    solved: &Solved,
    file: &EstimateFile,
    wanted: &Wanted,
) -> Result<Written, IoError> {
    let mut files = vec![
        for_robots(CALIBRATED, calibrated_urdf(loaded, &solved.estimate)?, solved.estimate.status),
        ResultFile::new(ESTIMATE, file.to_json()?),
        ResultFile::new(REPORT, page(loaded, solved, file)?),
    ];
    let of_driver = if wanted.driver { driver_files(loaded, &solved.estimate)? } else { None };
    let driver = of_driver.is_some().then(|| DRIVER.map(|name| folder.join(name)));
    files.extend(of_driver.into_iter().flatten());
    #[cfg(feature = "mcap")]
    if wanted.mcap {
        files.push(ResultFile::new(
            MCAP,
            crate::io::result::calibration_mcap::to_bytes(&loaded.problem, &solved.estimate)?,
        ));
    }
    let mcap = (wanted.mcap && cfg!(feature = "mcap")).then(|| folder.join(MCAP));
    let robot = calibrated(loaded, &solved.estimate);
    let errors: Vec<_> = solved.estimate.encoder_errors().collect();
    let of_joints = correction_file::text([&robot, &loaded.problem.robot], &errors, solved.estimate.status)?;
    let correction = of_joints.is_some().then(|| folder.join(CORRECTION));
    files.extend(of_joints.map(|text| ResultFile::new(CORRECTION, text)));
    let mut exports = Vec::new();
    for export in Export::ALL.into_iter().filter(|export| wanted.exports.contains(export)) {
        let name = export.file_name();
        let made = export.of(&robot, loaded)?;
        files.push(for_robots(name, made.text, solved.estimate.status));
        exports.push(WrittenExport { export, path: folder.join(name), left_out: made.left_out });
    }
    result_folder::write(folder, ResultKind::Calibration, &files, former_names(folder))?;
    let [urdf, estimate, report] = [CALIBRATED, ESTIMATE, REPORT].map(|name| folder.join(name));
    Ok(Written { urdf, correction, estimate, report, driver, mcap, exports })
}

/// A file that robots and their programs read. That of a result that must not be used says so in a
/// comment at its beginning, if its format has comments.
fn for_robots(name: &'static str, text: String, status: Status) -> ResultFile {
    const WORDS: &str = "NOT USABLE: do not use this calibration, see report.html";
    let declaration = match text.find("?>") {
        Some(end) if text.starts_with("<?xml") => end + "?>".len(),
        _ => 0,
    };
    let (head, rest) = text.split_at(declaration);
    let text = match name.rsplit('.').next() {
        _ if status != Status::NotUsable => text,
        Some("yaml") => format!("# {WORDS}\n{text}"),
        Some("urdf" | "xacro") => format!("{head}\n<!-- {WORDS} -->\n{}", rest.trim_start()),
        _ => text,
    };
    ResultFile::new(name, text)
}

/// The files that a calibration of a version without manifest has, if `folder` holds a calibration.
fn former_names(folder: &Path) -> &'static [&'static str] {
    let is_calibration = EstimateFile::read_file(&folder.join(ESTIMATE)).is_ok();
    if is_calibration { &NAMES } else { &[] }
}

/// What a driver that takes encoder offsets needs instead of `calibrated.urdf`: the URDF without
/// the offsets and the offsets ([`split_offsets`]), in this order. `None` if the nominal chain has
/// other joints than the calibrated one.
fn driver_files(loaded: &Loaded, estimate: &Estimate) -> Result<Option<[ResultFile; 2]>, IoError> {
    let Some((robot, offsets)) = split_offsets(&calibrated(loaded, estimate), &loaded.problem.robot) else {
        return Ok(None);
    };
    let [urdf, yaml] = DRIVER;
    let text = urdf::rewrite(&loaded.urdf, &robot)?;
    let offsets = offsets_yaml::text(&robot, &offsets);
    Ok(Some([for_robots(urdf, text, estimate.status), for_robots(yaml, offsets, estimate.status)]))
}

/// The text of `calibrated.urdf`: that of the URDF that was read, with the calibrated joint origins
/// and compliances. A tool that is the tip link itself ([`Problem::tool_is_tip`]) moves that link.
///
/// # Errors
/// As [`urdf::rewrite`], such as if a joint of the calibrated robot is not in the text.
pub fn calibrated_urdf(loaded: &Loaded, estimate: &Estimate) -> Result<String, IoError> {
    urdf::rewrite(&loaded.urdf, &calibrated(loaded, estimate))
}

/// The text of `report.html`, with the warnings and inputs of `file`.
///
/// # Errors
/// [`IoError::Syntax`] if the report's data cannot be serialized.
pub fn page(loaded: &Loaded, solved: &Solved, file: &EstimateFile) -> Result<String, IoError> {
    let warning = |entry: &WarningEntry| WarningText {
        severity: entry.severity.into(),
        message: entry.message.clone(),
        advice: entry.advice.clone(),
    };
    let input = |entry: &Input| report::Input { path: entry.path.clone(), sha256: entry.sha256.clone() };
    let report = Report {
        problem: &loaded.problem,
        estimate: &solved.estimate,
        prefit: &solved.prefit,
        steps: &solved.steps,
        created: file.created.as_deref(),
        warnings: &file.warnings.iter().map(warning).collect::<Vec<_>>(),
        inputs: &file.inputs.iter().map(input).collect::<Vec<_>>(),
    };
    report.html().map_err(|error| IoError::syntax(Place::file(REPORT), error.to_string()))
}

/// Gives `problem` what a calibration found beside its arm, as [`apply_estimate`] does, for an arm
/// that was read from the `calibrated.urdf` of that calibration: a tool that is the tip link itself
/// ([`Problem::tool_is_tip`]) is left, because the URDF contains its motion. Parameters that
/// `found` lacks count as 0.
pub fn apply_written(problem: &mut Problem, found: &EstimateFile) {
    let nominal = Some(problem.tool.tip_from_tool).filter(|_| problem.tool_is_tip());
    let entry = |name: &str| found.parameters.iter().find(|entry| entry.name == name);
    apply_estimate(problem, |name| entry(name).map(|entry| entry.value));
    problem.tool.tip_from_tool = nominal.unwrap_or(problem.tool.tip_from_tool);
}

/// The calibrated arm as it is written: a tool that is the tip link moves that link.
fn calibrated(loaded: &Loaded, estimate: &Estimate) -> Robot {
    let motion = estimate.tool_motion().filter(|_| loaded.problem.tool_is_tip());
    motion.and_then(|motion| estimate.robot.with_tip_moved(&motion)).unwrap_or_else(|| estimate.robot.clone())
}

/// The content of `estimate.json` for a finished calibration, in the order of
/// [`Estimate::parameters`]. Infinite values of condition and termination become `None`; other
/// numbers that are not finite are refused by [`EstimateFile::to_json`].
pub fn estimate_file(loaded: &Loaded, solved: &Solved) -> EstimateFile {
    let Solved { estimate, prefit, ended, seconds, .. } = solved;
    let size = estimate.parameters.len();
    let fixtures = &loaded.problem.fixtures;
    let acceptance = estimate.acceptance.as_ref().zip(loaded.problem.acceptance.as_ref());
    EstimateFile {
        schema: estimate_file::SCHEMA,
        status: estimate.status.into(),
        parameters: parameters(estimate),
        covariance: (0..size).map(|i| (0..size).map(|j| estimate.covariance[(i, j)]).collect()).collect(),
        workspace_uncertainty: estimate.workspace_uncertainty.map(Into::into),
        rank: estimate.identifiability.rank,
        condition: finite(estimate.identifiability.condition),
        null_space: null_space(estimate),
        residuals: Residuals { prefit: stats(prefit, fixtures), postfit: stats(&estimate.postfit, fixtures) },
        contacts: ContactCounts {
            read: estimate.contacts.read,
            used: estimate.contacts.used as u64,
            rejected: estimate.contacts.rejected as u64,
        },
        noise: Some(NoiseEntry { encoder: estimate.noise.encoder, contact: estimate.noise.contact }),
        termination: TerminationEntry {
            reason: estimate.termination.reason.name().to_owned(),
            measured: finite(estimate.termination.measured),
            threshold: finite(estimate.termination.threshold),
            iterations: estimate.termination.iterations,
        },
        warnings: warnings(estimate),
        competing_minima: estimate.competing_minima.iter().map(CompetingMinimumEntry::from).collect(),
        effect_tests: estimate.effect_tests.iter().map(EffectTestEntry::from).collect(),
        prior_tests: estimate.prior_tests.iter().map(PriorTestEntry::from).collect(),
        untested: estimate.untested.clone(),
        freed_effects: estimate.freed_effects.iter().map(FreedEffectEntry::from).collect(),
        acceptance: acceptance.map(|(result, asked)| AcceptanceEntry::new(asked, result)),
        predictive_check: estimate.predictive_check.as_ref().map(PredictiveCheckEntry::from),
        held_out: estimate
            .held_out
            .as_ref()
            .map(|found| HeldOutEntry { contacts: found.score.all.count, scatter: found.scatter.map(Into::into) }),
        notes: loaded.problem.contacts.notes().to_vec(),
        robot: Some(RobotEntry::of(&loaded.problem.robot)),
        tip_from_tool: Some(seven(&loaded.problem.tool.tip_from_tool)),
        inputs: loaded.inputs.clone(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        created: to_the_second(ended),
        seconds: *seconds,
    }
}

fn parameters(estimate: &Estimate) -> Vec<ParameterEntry> {
    let each = estimate.parameters.iter().map(|entry| ParameterEntry {
        name: entry.parameter.name.clone(),
        block: entry.parameter.id.block().name().to_owned(),
        unit: entry.parameter.unit.symbol().to_owned(),
        value: entry.value,
        sigma: entry.sigma,
        prior_sigma: entry.parameter.prior_sigma(),
        identifiable: entry.identifiable,
    });
    each.collect()
}

fn null_space(estimate: &Estimate) -> Vec<NullDirection> {
    let name = |k: usize| estimate.parameters[k].parameter.name.clone();
    let each = estimate.identifiability.null_space.iter().map(|null| NullDirection {
        description: null.description.clone(),
        remedy: null.remedy.clone(),
        direction: null.direction.iter().map(|&(k, part)| (name(k), part)).collect(),
    });
    each.collect()
}

fn warnings(estimate: &Estimate) -> Vec<WarningEntry> {
    let entry = |warning: &Warning| match warning {
        Warning::ToolNotInRobot { tip_from_tool } => {
            WarningEntry { advice: format!("it is tip_from_tool = {}", as_declared(tip_from_tool)), ..warning.into() }
        }
        _ => warning.into(),
    };
    estimate.warnings.iter().map(entry).collect()
}

/// Distances of `score` (m) in mm, for a file. `fixtures` has one entry for each of
/// `score.per_fixture`, in order; surplus entries of the longer one are ignored. Statistics without
/// contacts are `None`.
pub fn stats(score: &Score, fixtures: &[Fixture]) -> ResidualStats {
    let [mean_mm, rms_mm, max_mm] = millimetres(&score.all);
    let each = fixtures.iter().zip(&score.per_fixture).map(|(fixture, spread)| {
        let [mean_mm, rms_mm, max_mm] = millimetres(spread);
        (fixture.name.clone(), FixtureResidual { contacts: spread.count, mean_mm, rms_mm, max_mm })
    });
    ResidualStats { mean_mm, rms_mm, max_mm, per_fixture: each.collect::<BTreeMap<_, _>>() }
}

fn millimetres(spread: &Spread) -> [Option<f64>; 3] {
    [spread.mean, spread.rms, spread.max].map(|value| finite(1e3 * value).filter(|_| spread.count > 0))
}

/// The time (UTC) as text; `None` in the last half second of the year 9999.
fn to_the_second(time: &Timestamp) -> Option<String> {
    Some(time.round(Unit::Second).ok()?.to_string())
}

/// JSON has no infinities.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
