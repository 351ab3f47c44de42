//! Files of a simulation: the logs, the calibration problem that they pose, and the true
//! parameters.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use super::read::ScenarioFile;
use super::write::{Lines, SCENARIO, TextFile, file_name, fixture_text, robot_text, scenario_text, tool_text};
use crate::estimate::{Distance, EXACT_DISTANCE_SIGMA, ShapeTolerance};
use crate::experiment;
use crate::geometry::Parts;
use crate::io::base::error::{IoError, Place};
use crate::io::base::result_folder::{self, ResultFile, ResultKind};
use crate::io::base::tool_pose::seven;
use crate::io::robot::urdf;
use crate::parameter::Block;
use crate::robot::segments;
use crate::sim::{Log, MeasuredDistance, Scenario, Seeds, SimulatedTrial, Touch, Truth, WRENCH_DIGITS};

/// Name of the problem file in the folder of a simulation.
pub const PROBLEM: &str = "problem.toml";
/// Name of the file of the true parameters in the folder of a simulation.
pub const TRUTH: &str = "truth.json";
/// Name of the robot description of the true arm in the folder of a simulation.
pub const TRUE_URDF: &str = "true.urdf";
/// Name of the column of the arm's temperature (°C).
const ARM_TEMPERATURE: &str = "temperature_c";

/// Checks that writing a simulation into `folder` replaces no problem, scenario or truth but those
/// of an earlier simulation, as that wrote them. A folder that does not exist passes.
///
/// # Errors
/// [`IoError::Unexpected`] with the path of such a file.
pub fn check_folder(folder: &Path) -> Result<(), IoError> {
    result_folder::check(folder, ResultKind::Simulation, &[PROBLEM, SCENARIO, TRUTH, TRUE_URDF], &[])
}

/// Writes all files of a simulation into `folder`, in place of a former one: truth, true arm,
/// logs, scenario and problem. `file` is the scenario that was simulated with `seeds`. Missing
/// folders are made.
///
/// # Errors
/// As [`result_folder::write`], [`truth_text`] and [`urdf::rewrite`].
pub fn write_folder(
    folder: &Path,
    file: &ScenarioFile,
    simulated: &SimulatedTrial,
    seeds: impl Into<Seeds>,
) -> Result<(), IoError> {
    let mut texts = vec![truth_text(&file.scenario, simulated, seeds)?];
    texts.extend(log_texts(&file.scenario, simulated));
    texts.extend(scenario_text(file));
    texts.extend(problem_text(file, &simulated.truth));
    texts.push(true_urdf(file, &simulated.truth)?);
    let files: Vec<ResultFile> = texts.into_iter().map(|text| ResultFile::new(text.name, text.text)).collect();
    result_folder::write(folder, ResultKind::Simulation, &files, &[])
}

/// The robot description of the true arm, without the errors of the tool.
fn true_urdf(file: &ScenarioFile, truth: &Truth) -> Result<TextFile, IoError> {
    let robot = experiment::true_robot(&file.scenario.robot, truth);
    Ok(TextFile::new(TRUE_URDF, urdf::rewrite(&file.urdf, &robot)?))
}

/// The text of `problem.toml`, which `touchcal calibrate` takes, preceded by the files that it
/// refers to, except the logs ([`log_texts`]). It poses the problem of
/// [`experiment::problem`](experiment::problem()), with numbers of twelve digits. Of `truth` only
/// the measured distances are used.
pub fn problem_text(file: &ScenarioFile, truth: &Truth) -> Vec<TextFile> {
    let scenario = &file.scenario;
    let mut files = Vec::new();
    let mut text = String::from(
        "# What an arm touched; from its logs the arm's errors are estimated.\n\
         # Paths are relative to this file. Lengths are in mm, angles in degrees, as the keys say.\n",
    );
    text.push_str(&robot_text(file, &mut files));
    text.push_str(&tool_text(scenario, &mut files));
    Lines(&mut text).tolerances(Some(scenario.tool_error), None);
    for touch in &scenario.touches {
        text.push_str(&fixture_text(scenario, touch, &mut files));
        let mut line = Lines(&mut text);
        if touch.free {
            line.raw("free", "true");
        } else {
            line.place(touch);
        }
        let is_hole = matches!(touch.parts, Parts::PegInHole(_));
        let shape = is_hole.then_some(ShapeTolerance {
            clearance: touch.clearance_sigma,
            depth: touch.depth_sigma,
            edge_radius: touch.edge_radius_sigma,
        });
        line.tolerances((!touch.free).then_some(touch.place_error), shape);
    }
    let mut line = Lines(&mut text);
    for Distance { between, distance, sigma } in experiment::distances(scenario, truth) {
        line.between(scenario, between);
        line.number("mm", 1e3 * distance);
        if sigma > EXACT_DISTANCE_SIGMA {
            line.number("sigma_mm", 1e3 * sigma);
        } else {
            line.raw("exact", "true");
        }
    }
    line.table("[log]");
    line.number("force_threshold_n", scenario.recorder.force_threshold);
    if experiment::uses_loads(scenario) {
        line.text("load_on", "tool");
        line.number("load_lag_rows", scenario.recorder.lag());
    }
    if scenario.recorder.joint_torque_sigma > 0.0 {
        line.text("tau_joint", "load");
    }
    if scenario.recorder.warm_up > 0.0 {
        line.text("temperature", ARM_TEMPERATURE);
    }
    for touch in &scenario.touches {
        line.table("[[contacts]]");
        line.text("file", &log_name(scenario, touch));
        line.text("fixture", &touch.name);
    }
    text.push_str(&settings_text(scenario));
    files.push(TextFile::new(PROBLEM, text));
    files
}

/// The tables `[noise]` and `[estimate]` of the [problem](problem_text), which
/// [`Settings::read`](crate::io::problem_file::Settings::read) takes.
pub fn settings_text(scenario: &Scenario) -> String {
    let mut text = String::new();
    let mut line = Lines(&mut text);
    noise_text(scenario, &mut line);
    line.table("[estimate]");
    let names: Vec<&str> = experiment::blocks(scenario).into_iter().map(Block::name).collect();
    line.raw("parameters", &format!("{names:?}"));
    line.text("loss", "geman_mcclure");
    line.number("loss_scale", experiment::LOSS_SCALE);
    line.text("unseen_effects", "ignore");
    text
}

/// The table of the noise.
fn noise_text(scenario: &Scenario, line: &mut Lines<'_>) {
    line.table("[noise]");
    let noise = experiment::noise(scenario);
    line.number("encoder_deg", noise.encoder.to_degrees());
    line.number("contact_mm", 1e3 * noise.contact);
    line.number("encoder_trend_deg", experiment::encoder_trend(&scenario.recorder).to_degrees());
    if scenario.recorder.warm_up > 0.0 {
        line.text("encoder_trend_over", "temperature");
    }
    line.number("encoder_walk_deg", scenario.recorder.encoder_walk.to_degrees());
    if scenario.errors.deflect_joints() && experiment::uses_loads(scenario) {
        let wrench = experiment::wrench(&scenario.recorder);
        line.number("force_bias_n", wrench.force);
        line.number("torque_bias_nm", wrench.torque);
        line.number("force_noise_n", wrench.force_noise);
        line.number("torque_noise_nm", wrench.torque_noise);
        line.number("wrench_scale", wrench.scale);
    }
}

fn log_name(scenario: &Scenario, touch: &Touch) -> String {
    format!("{}.csv", file_name(scenario, touch))
}

/// The logs as CSV with a header, one for each fixture of the scenario, in its order, as an arm's
/// recorder would write them: time (s), joint positions (rad, or m for a prismatic joint; base
/// first), the wrench on the tool about the tip (N, N m) in the tip frame, whether the recorder
/// detected contact (0 or 1), the torques of joints (N m) where they are recorded, and the
/// temperature of each segment (°C) where it is recorded.
pub fn log_texts(scenario: &Scenario, simulated: &SimulatedTrial) -> Vec<TextFile> {
    let each = scenario.touches.iter().zip(&simulated.logs);
    each.map(|(touch, log)| TextFile::new(log_name(scenario, touch), log_text(scenario, log))).collect()
}

fn log_text(scenario: &Scenario, log: &Log) -> String {
    let mut names: Vec<String> = vec!["t".to_owned()];
    names.extend(scenario.robot.moving().map(|joint| joint.name.clone()));
    names.extend(["fx", "fy", "fz", "tx", "ty", "tz", "contact"].map(str::to_owned));
    if !log.joint_torque.is_empty() {
        names.extend(scenario.robot.moving().map(|joint| format!("tau_{}", joint.name)));
    }
    let warm = if log.temperature.is_empty() { 0 } else { segments(&scenario.robot).len() };
    names.extend((0..warm).map(|k| format!("temperature_{k}_c")));
    names.extend(log.arm_temperature.first().map(|_| ARM_TEMPERATURE.to_owned()));
    let mut text = names.join(",") + "\n";
    for row in 0..log.len() {
        let mut written = write!(text, "{:.6}", log.time[row]);
        for q in log.q(row) {
            written = written.and_then(|()| write!(text, ",{q:.9}"));
        }
        for part in log.wrench[row] {
            written = written.and_then(|()| write!(text, ",{part:.WRENCH_DIGITS$}"));
        }
        written = written.and_then(|()| write!(text, ",{}", u8::from(log.contact[row])));
        for torque in log.joint_torque(row).into_iter().flatten() {
            written = written.and_then(|()| write!(text, ",{torque:.WRENCH_DIGITS$}"));
        }
        for celsius in &log.temperature[row * warm..(row + 1) * warm] {
            written = written.and_then(|()| write!(text, ",{celsius:.3}"));
        }
        if let Some(celsius) = log.arm_temperature.get(row) {
            written = written.and_then(|()| write!(text, ",{celsius:.3}"));
        }
        // Writing to a String cannot fail.
        debug_assert!(written.is_ok());
        text.push('\n');
    }
    text
}

/// What the simulation was made with.
#[derive(Serialize)]
struct TruthJson<'a> {
    note: &'static str,
    seed: u64,
    /// Where it is another.
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_seed: Option<u64>,
    /// By name as in estimate.json, in SI units; what is right is left out.
    parameters: BTreeMap<String, f64>,
    /// Declared pose of the tool, which its errors are relative to: x, y, z (m), qw, qx, qy, qz.
    tip_from_tool: [f64; 7],
    clearance_mm: BTreeMap<&'a str, f64>,
    depth_mm: BTreeMap<&'a str, f64>,
    unequal_clearance_mm: BTreeMap<&'a str, [f64; 2]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    distances: Vec<DistanceJson<'a>>,
    rows: BTreeMap<&'a str, RowsJson>,
}

/// A distance that was measured, and what problem.toml declares.
#[derive(Serialize)]
struct DistanceJson<'a> {
    between: [&'a str; 2],
    true_mm: f64,
    declared_mm: f64,
}

/// What is true of a log's rows.
#[derive(Serialize)]
struct RowsJson {
    rows: usize,
    contacts: usize,
    /// Rows that touch and are not taken for contacts, and the other way round.
    missed: usize,
    spurious: usize,
}

/// The text of `truth.json`: the true errors of arm, tool and fixtures, by the names that
/// `estimate.json` has for them (SI units, rad; those that were not drawn are left out), the
/// declared pose of the tool (m and a quaternion), each fixture's true errors of clearance (mm per
/// side), depth (mm) and clearance along x and y (mm per side), the measured distances as they are
/// and as they are declared (mm), the seeds, and how many rows of each log are contacts, missed
/// (with a force above the threshold, but not recorded as contacts) or spurious (the other way
/// round, as noise and filter of the force make some too).
///
/// # Errors
/// [`IoError::Syntax`] if serialization fails, which does not happen.
pub fn truth_text(
    scenario: &Scenario,
    simulated: &SimulatedTrial,
    seeds: impl Into<Seeds>,
) -> Result<TextFile, IoError> {
    let Seeds { errors, noise } = seeds.into();
    let names = || scenario.touches.iter().map(|touch| touch.name.as_str());
    let touching = |log: &Log, row: usize| log.truth[row].force > scenario.recorder.force_threshold;
    let count = |log: &Log, wrong: &dyn Fn(bool, bool) -> bool| {
        (0..log.len()).filter(|&row| wrong(touching(log, row), log.contact[row])).count()
    };
    let rows = |log: &Log| RowsJson {
        rows: log.len(),
        contacts: log.contacts().count(),
        missed: count(log, &|true_contact, contact| true_contact && !contact),
        spurious: count(log, &|true_contact, contact| !true_contact && contact),
    };
    let named = simulated.truth.named(scenario).into_iter();
    let distance = |(k, measured): (usize, &MeasuredDistance)| DistanceJson {
        between: <[usize; 2]>::from(measured.between).map(|fixture| scenario.touches[fixture].name.as_str()),
        true_mm: 1e3 * simulated.truth.distance(scenario, k),
        declared_mm: 1e3 * simulated.truth.measured_distance(scenario, k),
    };
    let truth = TruthJson {
        note: "what the simulation was made with; calibrate does not read this file",
        seed: errors,
        noise_seed: Some(noise).filter(|noise| *noise != errors),
        parameters: named.map(|(parameter, value)| (parameter.name, value)).collect(),
        tip_from_tool: seven(&scenario.tip_from_tool),
        clearance_mm: names().zip(simulated.truth.clearance.iter().map(|wider| 1e3 * wider)).collect(),
        depth_mm: names().zip(simulated.truth.depth.iter().map(|deeper| 1e3 * deeper)).collect(),
        unequal_clearance_mm: names()
            .zip(simulated.truth.unequal_clearance.iter().map(|by| by.map(|m| 1e3 * m)))
            .collect(),
        distances: scenario.distances.iter().enumerate().map(distance).collect(),
        rows: names().zip(simulated.logs.iter().map(rows)).collect(),
    };
    let json =
        serde_json::to_string_pretty(&truth).map_err(|error| IoError::syntax(Place::file(TRUTH), error.to_string()))?;
    Ok(TextFile::new(TRUTH, json + "\n"))
}
