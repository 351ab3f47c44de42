//! A calibration problem: read from a file or built from parts.

use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;

use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use touchcal::contact::{RowsLeftOut, note_repetition, repeated_rows_note};
use touchcal::estimate::{self, Acceptance, DEFAULT_DISTANCE_SIGMA, Distance, EXACT_DISTANCE_SIGMA, contact_poses};
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::problem_file::{self, Assumptions, Settings};
use touchcal::io::{Input, IoError, Loaded};

use crate::array::poses_array;
use crate::error::{io, unexpected, unpicklable};
use crate::log::{ContactLog, contact_positions, warn};
use crate::parts::{Fixture, Tool};
use crate::robot::Robot;
use crate::toml_value::as_table;

/// Name of the source of settings in messages.
const SETTINGS: &str = "Problem";
/// Arguments that declare what is assumed without them.
const KEYS: &str = "sigma, sigma_angle, clearance_sigma, depth_sigma, edge_radius_sigma, or exact=True";

/// A calibration problem: robot, tool, fixtures and contacts. What is assumed where no standard
/// deviations are declared is issued as a `UserWarning`.
///
/// Args:
///     robot: the arm.
///     tool: the tool.
///     fixtures: the fixtures.
///     contacts: by name of a fixture, the log of its contacts, or several; a row that is there
///         twice, of the same file or array, counts once.
///     parameters: blocks to estimate: "strain", "segment_strain", "joint_offset", "joint_origin",
///         "joint_compliance", "joint_drift", "joint_trend", "joint_walk", "joint_harmonic",
///         "tool", "fixture".
///     distances: known distances between origins of fixtures: (name, name, metres) or (name, name,
///         metres, sigma); default of sigma: 0.1 mm. A sigma of 0 is exact.
///     noise: the table [noise] of problem.toml: encoder_deg, contact_mm, encoder_trend_deg,
///         encoder_trend_over, encoder_walk_deg, estimated, force_bias_n, torque_bias_nm,
///         force_noise_n, torque_noise_nm, wrench_scale; default: learned from the data.
///     estimate: other keys of the table [estimate] of problem.toml: loss, loss_scale, freeze,
///         prior, method, descent, unseen_effects.
///     accept: the table [accept] of problem.toml: tolerance_mm, tolerance_deg, confidence, and the
///         task as postures_deg, joints_deg or region (center_mm, size_mm); default: nothing is
///         asked for.
///     held_out: as contacts; these are not fitted, but test the result (`Calibration.held_out`). A
///         row that `contacts` has too is not held out.
///
/// Raises:
///     InputError: as for a file.
#[pyclass(frozen, module = "touchcal")]
#[derive(Debug)]
pub struct Problem {
    pub loaded: Loaded,
}

/// A known distance (m) between origins of two fixtures, with or without its standard deviation
/// (m).
#[derive(FromPyObject)]
enum KnownDistance {
    Default(String, String, f64),
    WithSigma(String, String, f64, f64),
}

impl KnownDistance {
    fn checked(self, names: &FixtureNames, assumptions: &mut Assumptions) -> PyResult<Distance> {
        let (first, second, distance, declared) = match self {
            KnownDistance::Default(first, second, distance) => (first, second, distance, None),
            KnownDistance::WithSigma(first, second, distance, sigma) => (first, second, distance, Some(sigma)),
        };
        let sigma = declared.unwrap_or(DEFAULT_DISTANCE_SIGMA);
        let between = (names.index(&first, "distances")?, names.index(&second, "distances")?);
        let is_length = distance > 0.0 && distance.is_finite() && sigma >= 0.0 && sigma.is_finite();
        if between.0 == between.1 || !is_length {
            let found = format!("({first:?}, {second:?}, {distance}, {sigma})");
            return Err(unexpected("distances", "two fixtures, a positive distance and its sigma (m)", found));
        }
        assumptions.distance([&first, &second], declared, sigma);
        Ok(Distance { between, distance, sigma: sigma.max(EXACT_DISTANCE_SIGMA) })
    }
}

/// Names of fixtures, which are distinct, with their indices.
struct FixtureNames {
    names: Vec<String>,
    indices: HashMap<String, usize>,
}

impl FixtureNames {
    fn new(fixtures: &[PyRef<'_, Fixture>]) -> PyResult<FixtureNames> {
        let names: Vec<String> = fixtures.iter().map(|fixture| fixture.name().to_owned()).collect();
        let mut indices = HashMap::new();
        for (index, name) in names.iter().enumerate() {
            if indices.insert(name.clone(), index).is_some() {
                return Err(unexpected("fixture, name", "distinct names", format!("{name:?} twice")));
            }
        }
        Ok(FixtureNames { names, indices })
    }

    /// Index of a fixture, named in the argument `field`.
    fn index(&self, name: &str, field: &str) -> PyResult<usize> {
        let expected = || format!("the name of a fixture ({})", self.names.join(", "));
        self.indices.get(name).copied().ok_or_else(|| unexpected(field, expected(), format!("{name:?}")))
    }
}

/// Logs that were joined: their inputs, their rows, and notes on rows that were there before.
#[derive(Default)]
struct JoinedLogs {
    inputs: Vec<Input>,
    /// Hashes of all rows: of their content's SHA-256, number and joint positions.
    rows: HashSet<u64>,
    notes: Vec<String>,
}

impl JoinedLogs {
    /// The contacts of a log that no earlier log has, with a note on the others. Joint positions
    /// are compared too, as one file may be read twice with different columns.
    fn new_contacts(&mut self, part: &ContactLog) -> touchcal::contact::ContactLog {
        let hash = |i| {
            let mut hasher = DefaultHasher::new();
            (&part.input.sha256, part.log.source(i).line).hash(&mut hasher);
            part.log.q(i).iter().for_each(|position| position.to_bits().hash(&mut hasher));
            hasher.finish()
        };
        let mut new = part.log.filtered(|i| self.rows.insert(hash(i)));
        let (all, repeated) = (part.log.len(), part.log.len() - new.len());
        new.count_left_out(RowsLeftOut { repeated: repeated as u64, ..RowsLeftOut::default() });
        if repeated > 0 {
            self.notes.push(format!("{}: {}", part.input.path, repeated_rows_note(repeated, all)));
        }
        self.inputs.push(part.input.clone());
        new
    }
}

/// The logs of all fixtures as one, in the order of `contacts`, an argument of the name `field`.
fn joined_log(
    contacts: &Bound<'_, PyMapping>,
    field: &str,
    names: &FixtureNames,
    dof: usize,
    joined: &mut JoinedLogs,
) -> PyResult<touchcal::contact::ContactLog> {
    let mut log = touchcal::contact::ContactLog::new(dof);
    for item in contacts.items()?.try_iter()? {
        let (name, logs): (String, Bound<'_, PyAny>) = item?.extract()?;
        let fixture = names.index(&name, field)?;
        let logs: Vec<PyRef<'_, ContactLog>> = match logs.cast::<ContactLog>() {
            Ok(one) => vec![one.borrow()],
            Err(_) => logs.extract()?,
        };
        for part in logs {
            if part.log.dof() != dof {
                let (expected, found) = (format!("{dof} joints"), format!("{}", part.log.dof()));
                return Err(unexpected(part.input.path.clone(), expected, found));
            }
            log.append(&joined.new_contacts(&part), fixture);
        }
    }
    Ok(log)
}

#[pymethods]
#[allow(clippy::too_many_arguments, reason = "most are keywords with a default")]
impl Problem {
    #[new]
    #[pyo3(signature = (robot, tool, fixtures, contacts, *, parameters, distances=None, noise=None, estimate=None, accept=None, held_out=None))]
    fn new(
        py: Python<'_>,
        robot: &Robot,
        tool: &Tool,
        fixtures: Vec<PyRef<'_, Fixture>>,
        contacts: &Bound<'_, PyMapping>,
        parameters: Vec<String>,
        distances: Option<Vec<KnownDistance>>,
        noise: Option<Bound<'_, PyMapping>>,
        estimate: Option<Bound<'_, PyMapping>>,
        accept: Option<Bound<'_, PyMapping>>,
        held_out: Option<Bound<'_, PyMapping>>,
    ) -> PyResult<Problem> {
        let arm = &robot.file.robot;
        let settings = Settings::read(&settings_text(parameters, noise, estimate)?, SETTINGS, arm);
        let settings = settings.map_err(|error| io(without_lines(error)))?;
        let mut inputs = vec![robot.file.input.clone()];
        let names = FixtureNames::new(&fixtures)?;
        let mut assumptions = Assumptions::default();
        let tool = tool.nominal(&settings, &fixtures, &mut assumptions);
        let mut nominal = Vec::with_capacity(fixtures.len());
        for given in &fixtures {
            nominal.push(given.nominal(&settings, &mut assumptions)?);
            inputs.extend(given.inputs().iter().cloned());
        }
        let mut joined = JoinedLogs::default();
        let mut log = joined_log(contacts, "contacts", &names, arm.dof(), &mut joined)?;
        let held_out = held_out.map(|logs| joined_log(&logs, "held_out", &names, arm.dof(), &mut joined));
        let held_out = held_out.transpose()?.unwrap_or_default();
        inputs.append(&mut joined.inputs);
        let known = distances.unwrap_or_default().into_iter();
        let distances: Vec<Distance> =
            known.map(|distance| distance.checked(&names, &mut assumptions)).collect::<PyResult<_>>()?;
        let told = log.notes().len();
        joined.notes.iter().for_each(|note| log.note(note));
        note_repetition(&mut log, &held_out);
        assumptions.notes(KEYS).iter().for_each(|note| log.note(note));
        let acceptance = accept.map(|accept| acceptance(&accept, (arm, &tool))).transpose()?;
        let problem = settings.problem(arm.clone(), (tool, nominal, distances), log);
        let mut problem = problem.map_err(|error| io(without_lines(error)))?;
        problem.acceptance = acceptance;
        problem.held_out = held_out;
        warn(py, &problem.contacts.notes()[told..])?;
        let urdf = robot.file.text.clone();
        // Meshes are warned of where they are read.
        Problem::of(Loaded { problem, urdf, inputs, has_several_bodies: false })
    }

    /// Reads problem.toml and the files it refers to.
    ///
    /// Raises:
    ///     FileError, InputError: with the text that the command line prints.
    #[staticmethod]
    fn from_toml(py: Python<'_>, path: PathBuf) -> PyResult<Problem> {
        Problem::of(py.detach(|| problem_file::read_file(&path)).map_err(io)?)?.with_warnings(py)
    }

    /// Reads a folder PLACEMENT/hole_N.csv of ball-in-socket logs, joint angles in radians, as
    /// `touchcal new sockets --from` does.
    ///
    /// Args:
    ///     folder: the folder.
    ///     robot: the nominal arm, whose tip link carries the ball.
    ///     only, leave_out: names of placements to read, and not to read; default: all.
    ///     spacing: distance of neighbouring sockets (m).
    ///     joint_compliance: whether to estimate joint compliance under gravity.
    #[staticmethod]
    #[pyo3(signature = (folder, robot, *, only=vec![], leave_out=vec![], spacing=0.05, joint_compliance=false), text_signature = "(folder, robot, *, only=(), leave_out=(), spacing=0.05, joint_compliance=False)")]
    fn from_mukca(
        py: Python<'_>,
        folder: PathBuf,
        robot: &Robot,
        only: Vec<String>,
        leave_out: Vec<String>,
        spacing: f64,
        joint_compliance: bool,
    ) -> PyResult<Problem> {
        let options = MukcaOptions { only, except: leave_out, spacing, joint_compliance, ..MukcaOptions::default() };
        let urdf = robot.file.clone();
        Problem::of(py.detach(|| mukca::read(&folder, urdf, &options)).map_err(io)?)?.with_warnings(py)
    }

    /// The nominal arm.
    #[getter]
    fn robot(&self) -> Robot {
        Robot::new(self.loaded.problem.robot.clone(), self.loaded.urdf.clone(), &self.loaded.inputs)
    }

    /// Names of the fixtures, in order.
    #[getter]
    fn fixtures(&self) -> Vec<&str> {
        self.loaded.problem.fixtures.iter().map(|fixture| fixture.name.as_str()).collect()
    }

    /// Joint positions of all contacts (rad or m), shape (N, dof).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        contact_positions(py, &self.loaded.problem.contacts)
    }

    /// Input files: paths and SHA-256 of the content.
    #[getter]
    fn inputs(&self) -> Vec<(&str, &str)> {
        self.loaded.inputs.iter().map(|input| (input.path.as_str(), input.sha256.as_str())).collect()
    }

    /// Assumptions made in reading logs, and where no standard deviations are declared, as issued
    /// in warnings.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.loaded.problem.contacts.notes().to_vec()
    }

    /// Tool poses by the problem's arm in the contacts with a fixture. For a calibrated arm these
    /// are samples of the fixture's manifold.
    ///
    /// Returns:
    ///     `fixture_from_tool`, shape (N, 7), in the order of the log.
    fn contact_poses<'py>(&self, py: Python<'py>, fixture: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let names = self.fixtures();
        let Some(index) = names.iter().position(|name| *name == fixture) else {
            let expected = format!("the name of a fixture ({})", names.join(", "));
            return Err(unexpected("contact_poses", expected, format!("{fixture:?}")));
        };
        poses_array(py, &py.detach(|| contact_poses(&self.loaded.problem, index)))
    }

    /// Number of contacts.
    fn __len__(&self) -> usize {
        self.loaded.problem.contacts.len()
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(unpicklable("Problem", "send the path of its problem.toml, as `touchcal.distributed.run_fleet` does"))
    }

    fn __repr__(&self) -> String {
        let estimate::Problem { robot, fixtures, contacts, .. } = &self.loaded.problem;
        format!("Problem({:?}, {} contacts with {} fixtures)", robot.name(), contacts.len(), fixtures.len())
    }
}

impl Problem {
    /// A problem all of whose shapes are known.
    pub fn of(loaded: Loaded) -> PyResult<Problem> {
        Ok(Problem { loaded: loaded.with_known_shapes().map_err(io)? })
    }

    /// The problem, after the notes of its logs were issued as Python warnings.
    fn with_warnings(self, py: Python<'_>) -> PyResult<Problem> {
        warn(py, self.loaded.problem.contacts.notes())?;
        Ok(self)
    }
}

/// The tables `[noise]` and `[estimate]` as a file would have them, so that they mean the same.
fn settings_text(
    parameters: Vec<String>,
    noise: Option<Bound<'_, PyMapping>>,
    estimate: Option<Bound<'_, PyMapping>>,
) -> PyResult<String> {
    let table = |mapping: Option<Bound<'_, PyMapping>>| match mapping {
        None => Ok(toml::Table::new()),
        Some(mapping) => as_table(&mapping),
    };
    let mut estimate = table(estimate)?;
    estimate.insert("parameters".to_owned(), parameters.into());
    let mut both = toml::Table::new();
    both.insert("noise".to_owned(), table(noise)?.into());
    both.insert("estimate".to_owned(), estimate.into());
    Ok(both.to_string())
}

/// What the table `[accept]` asks for, as a file would have it.
fn acceptance(
    accept: &Bound<'_, PyMapping>,
    arm_and_tool: (&touchcal::robot::Robot, &touchcal::estimate::Tool),
) -> PyResult<Acceptance> {
    let mut text = toml::Table::new();
    text.insert("accept".to_owned(), as_table(accept)?.into());
    problem_file::read_acceptance(&text.to_string(), SETTINGS, arm_and_tool).map_err(|error| io(without_lines(error)))
}

/// The error without line and column, which refer to a generated text.
fn without_lines(mut error: IoError) -> IoError {
    if let IoError::Unexpected { place, .. } | IoError::Syntax { place, .. } = &mut error {
        place.line = None;
        place.column = None;
    }
    error
}
