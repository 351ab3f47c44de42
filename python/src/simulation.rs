//! Simulated logs of which the truth is known.

use std::path::PathBuf;

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use touchcal::experiment;
use touchcal::io::Loaded;
use touchcal::io::problem_file::Assumptions;
use touchcal::io::scenario_file::{self, ScenarioFile};
use touchcal::sim::{self, Log, Seeds, SimulatedTrial, SimulationError as Failure};

use crate::array::{fixed, fixed_rows};
use crate::error::{Error, SimulationError, io, unexpected, unknown_fixture, unpicklable};
use crate::frame::Frame;
use crate::problem::Problem;
use crate::progress::Observer;
use crate::threads::detached;

/// Logs of a simulated arm, and its true errors.
///
/// Attributes:
///     seed: what it was drawn from.
///     noise_seed: what its noise and random phases were drawn from.
#[pyclass(frozen, module = "touchcal")]
#[derive(Debug)]
pub struct Simulation {
    file: ScenarioFile,
    simulated: SimulatedTrial,
    seeds: Seeds,
}

impl Simulation {
    fn logged(&self, fixture: &str) -> PyResult<&Log> {
        let touches = &self.file.scenario.touches;
        let found = touches.iter().zip(&self.simulated.logs).find(|(touch, _)| touch.name == fixture);
        found.map(|(_, log)| log).ok_or_else(|| unknown_fixture("simulation", &self.fixtures(), fixture))
    }
}

#[pymethods]
impl Simulation {
    #[getter]
    fn seed(&self) -> u64 {
        self.seeds.errors
    }

    #[getter]
    fn noise_seed(&self) -> u64 {
        self.seeds.noise
    }

    /// Names of the fixtures, in order.
    #[getter]
    fn fixtures(&self) -> Vec<&str> {
        self.file.scenario.touches.iter().map(|touch| touch.name.as_str()).collect()
    }

    /// The truth, as truth.json has it.
    #[getter]
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = scenario_file::truth_text(&self.file.scenario, &self.simulated, self.seeds).map_err(io)?.text;
        py.import("json")?.call_method1("loads", (text,))
    }

    /// The log of a fixture, in contact and before, as a dict of arrays: t (s), shape (N,); q (rad
    /// or m), shape (N, dof); wrench (N, N m), shape (N, 6); contact, shape (N,).
    fn log<'py>(&self, py: Python<'py>, fixture: &str) -> PyResult<Bound<'py, PyDict>> {
        let log = self.logged(fixture)?;
        let contact = PyArray1::from_slice(py, &log.contact);
        contact.readwrite().make_nonwriteable();
        let arrays = PyDict::new(py);
        arrays.set_item("t", fixed(py, log.time.clone()))?;
        arrays.set_item("q", fixed_rows(py, log.q.clone(), log.dof)?)?;
        arrays.set_item("wrench", fixed_rows(py, log.wrench.concat(), 6)?)?;
        arrays.set_item("contact", contact)?;
        Ok(arrays)
    }

    /// The log of a fixture as a DataFrame with the columns of a log file: t, joint names, fx to
    /// tz, contact.
    fn to_pandas<'py>(&self, py: Python<'py>, fixture: &str) -> PyResult<Bound<'py, PyAny>> {
        let log = self.logged(fixture)?;
        let mut frame = Frame::new(py).column("t", fixed(py, log.time.clone()))?;
        for (k, joint) in self.file.scenario.robot.moving().enumerate() {
            let q = log.q.iter().skip(k).step_by(log.dof).copied().collect();
            frame = frame.column(&joint.name, fixed(py, q))?;
        }
        for (k, name) in ["fx", "fy", "fz", "tx", "ty", "tz"].iter().enumerate() {
            frame = frame.column(name, fixed(py, log.wrench.iter().map(|wrench| wrench[k]).collect()))?;
        }
        frame.column("contact", PyArray1::from_slice(py, &log.contact))?.build()
    }

    /// The problem that the logs pose to a user who believes what the scenario says.
    fn problem(&self) -> PyResult<Problem> {
        let problem = experiment::problem(&self.file.scenario, &self.simulated);
        let (urdf, settings) = (self.file.urdf.clone(), scenario_file::settings_text(&self.file.scenario));
        Problem::of(Loaded { problem, urdf, inputs: Vec::new(), settings, assumptions: Assumptions::default() })
    }

    /// Writes what `touchcal simulate` writes: the logs, problem.toml, scenario.toml, truth.json
    /// and true.urdf.
    ///
    /// Raises:
    ///     FileError, InputError: if a file cannot be written, or the folder holds one of them that
    ///         touchcal did not write, or that was changed since.
    fn save(&self, folder: PathBuf) -> PyResult<()> {
        scenario_file::write_folder(&folder, &self.file, &self.simulated, self.seeds).map_err(io)
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(unpicklable("Simulation", "simulate with the same scenario and seed there: the logs have the same bits"))
    }

    fn __repr__(&self) -> String {
        let rows: usize = self.simulated.logs.iter().map(Log::len).sum();
        format!("Simulation({rows} rows with {} fixtures, seed {})", self.simulated.logs.len(), self.seeds.errors)
    }
}

/// Simulates an arm with wrong kinematics that explores fixtures, as `touchcal simulate` does.
///
/// Args:
///     scenario: path of a scenario.toml; or the name of a preset: a str without `/` and `.`.
///     seed: of errors, noise and exploration; the same seed gives the same logs.
///     contacts: contacts with each fixture; default: what the scenario says.
///     noise_seed: of noise and random phases: the same arm, recorded once more; default: `seed`.
///     progress: called with a `Progress` now and then; what it raises ends the work, as Ctrl-C
///         does.
///
/// Raises:
///     FileError, InputError, SimulationError: if the scenario is not one, or cannot be simulated.
#[pyfunction]
#[pyo3(signature = (scenario, seed, *, contacts=None, noise_seed=None, progress=None))]
#[allow(clippy::too_many_arguments, reason = "most are keywords with a default")]
pub fn simulate(
    py: Python<'_>,
    scenario: Bound<'_, PyAny>,
    seed: u64,
    contacts: Option<usize>,
    noise_seed: Option<u64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Simulation> {
    let file = scenario_of(&scenario, contacts)?;
    let mut observer = Observer::new(progress);
    let seeds = Seeds { errors: seed, noise: noise_seed.unwrap_or(seed) };
    let truth = sim::draw_truth(&file.scenario, seeds.errors);
    let scenario = &file.scenario;
    let logs = detached(py, || sim::run(scenario, &truth, seeds.noise, &mut |contacts| observer.contacts(contacts)));
    observer.finish()?;
    let logs = logs.map_err(|error| match error {
        Failure::Interrupted => Error::new_err("interrupted"),
        error => SimulationError::new_err(error.to_string()),
    })?;
    Ok(Simulation { file, simulated: SimulatedTrial { truth, logs }, seeds })
}

/// A scenario's file, or the preset of that name.
pub fn scenario_of(scenario: &Bound<'_, PyAny>, contacts: Option<usize>) -> PyResult<ScenarioFile> {
    let name: Option<String> = scenario.extract().ok().filter(|name: &String| !name.contains(['/', '\\', '.']));
    let mut file = match name {
        Some(name) => scenario_file::preset(&name),
        None => scenario_file::read_file(&scenario.extract::<PathBuf>()?),
    }
    .map_err(io)?;
    if contacts == Some(0) {
        return Err(unexpected("contacts", "at least 1", "0"));
    }
    file.scenario.contacts = contacts.unwrap_or(file.scenario.contacts);
    Ok(file)
}
