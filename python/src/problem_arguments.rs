//! The arguments that a problem is built from.

use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyList, PyMapping, PyString};
use touchcal::contact::{RowsLeftOut, Source, note_repetition, repeated_rows_note};
use touchcal::estimate::{Acceptance, DEFAULT_DISTANCE_SIGMA, Distance, EXACT_DISTANCE_SIGMA};
use touchcal::io::problem_file::{self, Assumptions, Settings};
use touchcal::io::{Input, IoError, Loaded};

use crate::error::{argument, io, unexpected, unknown_fixture};
use crate::list_of::{Item, ListOf};
use crate::log::ContactLog;
use crate::parts::{Fixture, Tool};
use crate::plausible;
use crate::robot::Robot;
use crate::toml_value::as_table;

/// Name of the source of settings in messages.
const SETTINGS: &str = "Problem";
/// Arguments that declare what is assumed without them.
pub const KEYS: &str = "sigma, sigma_angle, clearance_sigma, depth_sigma, edge_radius_sigma, or exact=True";

/// The arguments of a problem: as a dict those of its constructor.
#[derive(Debug, FromPyObject, IntoPyObjectRef)]
#[pyo3(from_item_all)]
pub struct Arguments {
    pub robot: Py<Robot>,
    pub tool: Py<Tool>,
    pub fixtures: Vec<Py<Fixture>>,
    pub contacts: Py<PyMapping>,
    pub parameters: Vec<String>,
    pub distances: Option<Vec<KnownDistance>>,
    pub noise: Option<Py<PyMapping>>,
    pub estimate: Option<Py<PyMapping>>,
    pub accept: Option<Py<PyMapping>>,
    pub held_out: Option<Py<PyMapping>>,
}

impl Arguments {
    /// The problem, and which of its notes were not issued as warnings before.
    pub fn problem(&self, py: Python<'_>) -> PyResult<(Loaded, Vec<String>)> {
        let robot = &self.robot.get().file;
        let settings_text = self.settings_text(py)?;
        let settings = settings(&settings_text, &robot.robot)?;
        let fixtures: Vec<&Fixture> = self.fixtures.iter().map(Py::get).collect();
        let names = FixtureNames::new(fixtures.iter().map(|fixture| fixture.name().to_owned()))?;
        let mut assumptions = Assumptions::default();
        let tool = self.tool.get().nominal(&settings, fixtures.iter().map(|given| given.manifold()), &mut assumptions);
        let mut inputs = vec![robot.input.clone()];
        let mut nominal = Vec::with_capacity(fixtures.len());
        for given in &fixtures {
            nominal.push(given.nominal(&settings, &mut assumptions)?);
            inputs.extend(given.inputs().iter().cloned());
        }
        let mut joined = JoinedLogs::default();
        let mut joined_log =
            |logs: &Py<PyMapping>, field: &str| joined.log(logs.bind(py), field, &names, robot.robot.dof());
        let mut log = joined_log(&self.contacts, "contacts")?;
        let held_out = self.held_out.as_ref().map(|logs| joined_log(logs, "held_out")).transpose()?;
        let held_out = held_out.unwrap_or_default();
        inputs.append(&mut joined.inputs);
        let known = self.distances.iter().flatten();
        let distances: Vec<Distance> =
            known.map(|distance| distance.checked(&names, &mut assumptions)).collect::<PyResult<_>>()?;
        let notes_of_logs = log.notes().len();
        joined.notes.iter().for_each(|note| log.note(note));
        note_repetition(&mut log, &held_out);
        assumptions.notes(KEYS).iter().for_each(|note| log.note(note));
        let accept = self.accept.as_ref();
        let acceptance = accept.map(|accept| acceptance(accept.bind(py), (&robot.robot, &tool))).transpose()?;
        let problem = settings.problem(robot.robot.clone(), (tool, nominal, distances), log);
        let mut problem = problem.map_err(|error| io(without_lines(error)))?;
        problem.acceptance = acceptance;
        problem_file::check_joint_torques(&problem.robot, &held_out, problem.contacts.has_joint_torques())
            .map_err(io)?;
        problem.held_out = held_out;
        let notes = problem.contacts.notes()[notes_of_logs..].to_vec();
        Ok((Loaded { problem, urdf: robot.text.clone(), inputs, settings: settings_text, assumptions }, notes))
    }

    /// The tables `[noise]` and `[estimate]` as a file would have them, so that they mean the same.
    fn settings_text(&self, py: Python<'_>) -> PyResult<String> {
        let table = |mapping: &Option<Py<PyMapping>>| match mapping {
            None => Ok(toml::Table::new()),
            Some(mapping) => as_table(mapping.bind(py)),
        };
        let mut estimate = table(&self.estimate)?;
        estimate.insert("parameters".to_owned(), self.parameters.clone().into());
        let mut both = toml::Table::new();
        both.insert("noise".to_owned(), table(&self.noise)?.into());
        both.insert("estimate".to_owned(), estimate.into());
        Ok(both.to_string())
    }
}

/// A copy of a mapping, and of all that is in it, which later changes leave as it is.
pub fn kept(mapping: &Bound<'_, PyMapping>) -> PyResult<Py<PyMapping>> {
    Ok(kept_value(mapping.as_any())?.cast_into::<PyMapping>()?.unbind())
}

fn kept_value<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    if let Ok(mapping) = value.cast::<PyMapping>() {
        let copy = PyDict::new(value.py());
        for item in mapping.items()?.try_iter()? {
            let (key, value): (Bound<'py, PyAny>, Bound<'py, PyAny>) = item?.extract()?;
            copy.set_item(key, kept_value(&value)?)?;
        }
        return Ok(copy.into_any());
    }
    if value.is_instance_of::<PyBool>() || value.is_instance_of::<PyString>() {
        return Ok(value.clone());
    }
    // As `as_value` reads values: what is a number, even in an array, then what has items.
    if let Ok(number) = value.extract::<f64>() {
        return Ok(PyFloat::new(value.py(), number).into_any());
    }
    let Ok(items) = value.try_iter() else { return Ok(value.clone()) };
    let items = items.map(|item| kept_value(&item?)).collect::<PyResult<Vec<_>>>()?;
    Ok(PyList::new(value.py(), items)?.into_any())
}

/// A known distance (m) between origins of two fixtures, with or without its standard deviation
/// (m).
#[derive(Clone, Debug, FromPyObject, IntoPyObject, IntoPyObjectRef)]
pub enum KnownDistance {
    Default(String, String, f64),
    WithSigma(String, String, f64, f64),
}

impl Item for KnownDistance {
    const LIST: &'static str = "a list of (name, name, metres) or (name, name, metres, sigma)";

    fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        object.extract()
    }
}

impl Item for Py<Fixture> {
    const LIST: &'static str = "a list of Fixture";

    fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(object.extract()?)
    }
}

impl Item for Py<ContactLog> {
    const LIST: &'static str = "a ContactLog (ContactLog.from_numpy makes one of an array) or a list of them";

    fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(object.extract()?)
    }
}

impl KnownDistance {
    fn checked(&self, names: &FixtureNames, assumptions: &mut Assumptions) -> PyResult<Distance> {
        let (first, second, distance, declared) = match self {
            KnownDistance::Default(first, second, distance) => (first, second, *distance, None),
            KnownDistance::WithSigma(first, second, distance, sigma) => (first, second, *distance, Some(*sigma)),
        };
        let sigma = declared.unwrap_or(DEFAULT_DISTANCE_SIGMA);
        let between = (names.index(first, "distances")?, names.index(second, "distances")?);
        let is_length = distance > 0.0 && distance.is_finite() && sigma >= 0.0 && sigma.is_finite();
        if between.0 == between.1 || !is_length {
            let found = format!("({first:?}, {second:?}, {distance}, {sigma})");
            return Err(unexpected("distances", "two fixtures, a positive distance and its sigma (m)", found));
        }
        plausible::length("distances", distance, plausible::REACH)?;
        plausible::length("distances, sigma", sigma, plausible::PLACE_SIGMA)?;
        assumptions.distance([first, second], declared, sigma);
        Ok(Distance { between, distance, sigma: sigma.max(EXACT_DISTANCE_SIGMA) })
    }
}

/// Names of fixtures, which are distinct, with their indices.
pub struct FixtureNames {
    names: Vec<String>,
    indices: HashMap<String, usize>,
}

impl FixtureNames {
    pub fn new(names: impl Iterator<Item = String>) -> PyResult<FixtureNames> {
        let names: Vec<String> = names.collect();
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
        let names = || self.names.iter().map(String::as_str).collect::<Vec<&str>>();
        self.indices.get(name).copied().ok_or_else(|| unknown_fixture(field, &names(), name))
    }
}

/// Logs that were joined: their inputs, their rows, and notes on rows that were there before.
#[derive(Default)]
pub struct JoinedLogs {
    pub inputs: Vec<Input>,
    /// Hashes of all rows: of their content's SHA-256, number and joint positions.
    rows: HashSet<u64>,
    pub notes: Vec<String>,
}

impl JoinedLogs {
    /// The contacts of a log that no earlier log has, with a note on the others. Joint positions
    /// are compared too, as one file may be read twice with different columns.
    fn new_contacts(&mut self, part: &ContactLog) -> touchcal::contact::ContactLog {
        let mut new = self.new_rows(&part.log, |_| &part.input.sha256);
        let (all, repeated) = (part.log.len(), part.log.len() - new.len());
        new.count_left_out(RowsLeftOut { repeated: repeated as u64, ..RowsLeftOut::default() });
        if repeated > 0 {
            self.notes.push(format!("{}: {}", part.input.path, repeated_rows_note(repeated, all)));
        }
        self.inputs.push(part.input.clone());
        new
    }

    /// The contacts of a log, whose files have that SHA-256, that no earlier log has.
    pub fn new_rows<'a>(
        &mut self,
        log: &'a touchcal::contact::ContactLog,
        sha256: impl Fn(&'a str) -> &'a str,
    ) -> touchcal::contact::ContactLog {
        let files: Vec<&str> = log.files().iter().map(|file| sha256(file)).collect();
        let hash = |i| {
            let mut hasher = DefaultHasher::new();
            let Source { file, line } = log.source(i);
            (files.get(file as usize), line).hash(&mut hasher);
            log.q(i).iter().for_each(|position| position.to_bits().hash(&mut hasher));
            hasher.finish()
        };
        log.filtered(|i| self.rows.insert(hash(i)))
    }

    /// The logs of all fixtures as one, in the order of `contacts`, an argument named `field`.
    pub fn log(
        &mut self,
        contacts: &Bound<'_, PyMapping>,
        field: &str,
        names: &FixtureNames,
        dof: usize,
    ) -> PyResult<touchcal::contact::ContactLog> {
        let mut log = touchcal::contact::ContactLog::new(dof);
        for item in contacts.items()?.try_iter()? {
            let (name, logs): (String, Bound<'_, PyAny>) = item?.extract()?;
            let fixture = names.index(&name, field)?;
            let logs = match logs.extract::<Py<ContactLog>>() {
                Ok(one) => vec![one],
                Err(_) => argument::<ListOf<Py<ContactLog>>>(&logs, field)?.0,
            };
            for part in logs.iter().map(Py::get) {
                if part.log.dof() != dof {
                    let (expected, found) = (format!("{dof} joints"), format!("{}", part.log.dof()));
                    return Err(unexpected(part.input.path.clone(), expected, found));
                }
                log.append(&self.new_contacts(part), fixture);
            }
        }
        Ok(log)
    }
}

/// The settings of the tables `[noise]` and `[estimate]` in a text.
pub fn settings(text: &str, robot: &touchcal::robot::Robot) -> PyResult<Settings> {
    Settings::read(text, SETTINGS, robot).map_err(|error| io(without_lines(error)))
}

/// What the table `[accept]` asks for, as a file would have it.
pub fn acceptance(
    accept: &Bound<'_, PyMapping>,
    arm_and_tool: (&touchcal::robot::Robot, &touchcal::estimate::Tool),
) -> PyResult<Acceptance> {
    let mut text = toml::Table::new();
    text.insert("accept".to_owned(), as_table(accept)?.into());
    problem_file::read_acceptance(&text.to_string(), SETTINGS, arm_and_tool).map_err(|error| io(without_lines(error)))
}

/// The error without line and column, which refer to a generated text.
pub fn without_lines(mut error: IoError) -> IoError {
    if let IoError::Unexpected { place, .. } | IoError::Syntax { place, .. } = &mut error {
        place.line = None;
        place.column = None;
    }
    error
}
