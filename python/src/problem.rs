//! A calibration problem: read from a file or built from parts.

use std::path::PathBuf;

use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use touchcal::estimate::{self, contact_poses};
use touchcal::io::Loaded;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::problem_file;

use crate::array::poses_array;
use crate::error::{ArgumentClass, Given, argument, io, mapping_argument, optional_argument, unknown_fixture};
use crate::list_of::ListOf;
use crate::log::{contact_positions, warn};
use crate::parts::{Fixture, Tool};
use crate::pickle::{VERSION, check_version, reduced};
use crate::plausible;
use crate::problem_arguments::{self, Arguments, KnownDistance};
use crate::problem_changes;
use crate::robot::Robot;
use crate::threads::detached;

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
///         "joint_compliance", "joint_backlash", "joint_drift", "joint_trend", "joint_walk",
///         "joint_harmonic", "joint_harmonic_2", "joint_gear_ratio", "tool", "fixture".
///     distances: known distances between origins of fixtures: (name, name, metres) or (name, name,
///         metres, sigma); default of sigma: 0.1 mm. A sigma of 0 is exact.
///     noise: the table [noise] of problem.toml: encoder_deg, contact_mm, encoder_trend_deg,
///         encoder_trend_over, encoder_walk_deg, estimated, force_bias_n, torque_bias_nm,
///         force_noise_n, torque_noise_nm, wrench_scale; default: learned from the data.
///     estimate: other keys of the table [estimate] of problem.toml: loss, loss_scale, freeze,
///         prior, method, descent, unseen_effects.
///     accept: the table [accept] of problem.toml: tolerance_mm, tolerance_deg, confidence, frame,
///         and the task as postures_deg, joints_deg or region (center_mm, size_mm); default:
///         nothing is asked for.
///     held_out: as contacts; these are not fitted, but test the result (`Calibration.held_out`). A
///         row that `contacts` has too is not held out.
///
/// Raises:
///     InputError: as for a file.
#[pyclass(frozen, module = "touchcal")]
#[derive(Debug)]
pub struct Problem {
    pub loaded: Loaded,
    /// Of a problem that was made of them.
    arguments: Option<Arguments>,
}

impl ArgumentClass for Problem {
    const EXPECTED: &'static str = "a Problem, such as Problem.from_toml(\"problem.toml\")";
}

#[pymethods]
#[allow(clippy::too_many_arguments, reason = "most are keywords with a default")]
impl Problem {
    #[new]
    #[pyo3(signature = (robot, tool, fixtures, contacts, *, parameters, distances=None, noise=None, estimate=None, accept=None, held_out=None))]
    fn new(
        py: Python<'_>,
        robot: &Bound<'_, PyAny>,
        tool: &Bound<'_, PyAny>,
        fixtures: &Bound<'_, PyAny>,
        contacts: &Bound<'_, PyAny>,
        parameters: &Bound<'_, PyAny>,
        distances: Option<Bound<'_, PyAny>>,
        noise: Option<Bound<'_, PyAny>>,
        estimate: Option<Bound<'_, PyAny>>,
        accept: Option<Bound<'_, PyAny>>,
        held_out: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Problem> {
        let kept = |value: &Bound<'_, PyAny>, name| problem_arguments::kept(mapping_argument(value, name)?);
        let optional = |value: Option<Bound<'_, PyAny>>, name| value.map(|value| kept(&value, name)).transpose();
        let (noise, estimate) = (optional(noise, "noise")?, optional(estimate, "estimate")?);
        let (accept, held_out) = (optional(accept, "accept")?, optional(held_out, "held_out")?);
        let contacts = kept(contacts, "contacts")?;
        let fixtures = argument::<ListOf<Py<Fixture>>>(fixtures, "fixtures")?.0;
        let parameters = argument::<ListOf<String>>(parameters, "parameters")?.0;
        let distances: Option<ListOf<KnownDistance>> = optional_argument(distances.as_ref(), "distances")?;
        let distances = distances.map(|distances| distances.0);
        let robot = argument::<Given<Robot>>(robot, "robot")?.0;
        let tool = argument::<Given<Tool>>(tool, "tool")?.0;
        let arguments =
            Arguments { robot, tool, fixtures, contacts, parameters, distances, noise, estimate, accept, held_out };
        let (loaded, notes) = arguments.problem(py)?;
        warn(py, &notes)?;
        Ok(Problem { arguments: Some(arguments), ..Problem::of(loaded)? })
    }

    /// Reads problem.toml and the files it refers to.
    ///
    /// Raises:
    ///     FileError, InputError: with the text that the command line prints.
    #[staticmethod]
    fn from_toml(py: Python<'_>, path: PathBuf) -> PyResult<Problem> {
        Problem::of(detached(py, || problem_file::read_file(&path)).map_err(io)?)?.with_warnings(py)
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
    #[pyo3(signature = (folder, robot, *, only=None, leave_out=None, spacing=0.05, joint_compliance=false), text_signature = "(folder, robot, *, only=(), leave_out=(), spacing=0.05, joint_compliance=False)")]
    fn from_mukca(
        py: Python<'_>,
        folder: PathBuf,
        robot: &Robot,
        only: Option<Bound<'_, PyAny>>,
        leave_out: Option<Bound<'_, PyAny>>,
        spacing: f64,
        joint_compliance: bool,
    ) -> PyResult<Problem> {
        plausible::length("spacing", spacing, plausible::PART)?;
        let names = |value: Option<Bound<'_, PyAny>>, name| {
            Ok::<_, PyErr>(optional_argument::<ListOf<String>>(value.as_ref(), name)?.map_or(vec![], |names| names.0))
        };
        let (only, except) = (names(only, "only")?, names(leave_out, "leave_out")?);
        let options = MukcaOptions { only, except, spacing, joint_compliance, ..MukcaOptions::default() };
        let urdf = robot.file.clone();
        Problem::of(detached(py, || mukca::read(&folder, urdf, &options)).map_err(io)?)?.with_warnings(py)
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
        let index = names.iter().position(|name| *name == fixture);
        let index = index.ok_or_else(|| unknown_fixture("contact_poses", &names, fixture))?;
        poses_array(py, &detached(py, || contact_poses(&self.loaded.problem, index)))
    }

    /// Number of contacts.
    fn __len__(&self) -> usize {
        self.loaded.problem.contacts.len()
    }

    /// The same problem with other arguments, as `problem.with_(noise={"encoder_deg": 0.01})`.
    ///
    /// Args:
    ///     changes: arguments of `Problem` by their names; of a problem that was read or simulated
    ///         all but robot, fixtures and distances, where noise and estimate replace those tables
    ///         of its file.
    ///
    /// Raises:
    ///     InputError: as for `Problem`; for robot, fixtures and distances of a problem that was
    ///         read or simulated, or parameters that list "fixture", or "tool" without another
    ///         tool, where those before did not, or the other way round; and for parameters, noise
    ///         and estimate of one that was extended by `free_suspects`.
    #[pyo3(signature = (**changes))]
    fn with_<'py>(slf: &Bound<'py, Self>, changes: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        let (py, Problem { loaded, arguments }) = (slf.py(), slf.get());
        let Some(changes) = changes else { return Ok(slf.clone().into_any()) };
        let Some(arguments) = arguments else {
            let (loaded, notes) = problem_changes::changed(loaded, changes)?;
            warn(py, &notes)?;
            return Ok(Bound::new(py, Problem::of(loaded)?)?.into_any());
        };
        let all = arguments.into_pyobject(py)?;
        all.update(changes.as_mapping())?;
        slf.get_type().call((), Some(&all))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (restore, data) = match &self.arguments {
            Some(arguments) => {
                let rebuild = py.import("touchcal._touchcal")?.getattr("_rebuild")?;
                (rebuild, (VERSION, arguments).into_pyobject(py)?.into_any())
            }
            None => {
                let (restore, data) = reduced(py, "Problem", &self.loaded, None)?;
                (restore, data.into_pyobject(py)?.into_any())
            }
        };
        Ok((restore, data))
    }

    fn __repr__(&self) -> String {
        let estimate::Problem { robot, fixtures, contacts, .. } = &self.loaded.problem;
        format!("Problem({:?}, {} contacts with {} fixtures)", robot.name(), contacts.len(), fixtures.len())
    }
}

impl Problem {
    /// A problem all of whose shapes are known.
    pub fn of(loaded: Loaded) -> PyResult<Problem> {
        Ok(Problem { loaded: loaded.with_known_shapes().map_err(io)?, arguments: None })
    }

    /// The problem, after the notes of its logs were issued as Python warnings.
    fn with_warnings(self, py: Python<'_>) -> PyResult<Problem> {
        warn(py, self.loaded.problem.contacts.notes())?;
        Ok(self)
    }
}

/// The problem of these arguments, whose notes were issued as warnings before.
#[pyfunction]
pub fn _rebuild(py: Python<'_>, version: &str, arguments: &Bound<'_, PyAny>) -> PyResult<Problem> {
    check_version(version)?;
    let arguments: Arguments = arguments.extract()?;
    let (loaded, _) = arguments.problem(py)?;
    Ok(Problem { arguments: Some(arguments), ..Problem::of(loaded)? })
}
