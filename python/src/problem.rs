//! A calibration problem: read from a file or built from parts.

use std::collections::HashMap;
use std::path::PathBuf;

use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use touchcal::estimate::{self, Distance, PlacePrior, contact_poses};
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::problem_file::{self, DEFAULT_DISTANCE_SIGMA, Settings};
use touchcal::io::{Input, IoError, Loaded};
use touchcal::se3::Pose;

use crate::array::{Numbers, one_pose, poses_array};
use crate::error::{io, unexpected};
use crate::log::{ContactLog, contact_positions, warn};
use crate::manifold::Manifold;
use crate::robot::Robot;
use crate::toml_value::as_table;

/// Name of the source of settings in messages.
const SETTINGS: &str = "Problem";

/// The tool: its pose on the arm's tip link.
///
/// Args:
///     tip_from_tool: nominal pose of the tool's frame on the tip link, shape (7,) or (4, 4);
///         default: the tip link itself.
///     sigma, sigma_angle: its prior: standard deviations of each translation (m) and
///         rotation (rad) component; 0: exactly known.
///     free: flat prior, instead of sigma and sigma_angle.
#[pyclass(frozen, module = "touchcal")]
#[derive(Clone, Debug)]
pub struct Tool {
    tool: estimate::Tool,
}

#[pymethods]
impl Tool {
    #[new]
    #[pyo3(signature = (tip_from_tool=None, *, sigma=0.0, sigma_angle=0.0, free=false))]
    fn new(tip_from_tool: Option<Numbers<'_>>, sigma: f64, sigma_angle: f64, free: bool) -> PyResult<Tool> {
        let tip_from_tool = match &tip_from_tool {
            None => Pose::identity(),
            Some(pose) => one_pose(pose, "tip_from_tool")?,
        };
        Ok(Tool { tool: estimate::Tool { tip_from_tool, prior: place_prior("tool", sigma, sigma_angle, free)? } })
    }
}

/// A fixture: a contact manifold at a pose.
///
/// Args: name: unique; fixtures "left/0" and "left/1" are of the placement "left". manifold: its
/// contact manifold. base_from_fixture: its nominal pose in the base frame, shape (7,) or (4, 4). A
/// free socket needs none. sigma, sigma_angle: its prior: standard deviations of each translation
/// (m) and rotation (rad) component; 0: exactly known. free: flat prior, instead of sigma and
/// sigma_angle. placement: fixtures that were recorded in one session share it; default: the name
/// up to its first "/".
#[pyclass(frozen, module = "touchcal")]
#[derive(Clone, Debug)]
pub struct Fixture {
    fixture: estimate::Fixture,
    manifold: Manifold,
}

#[pymethods]
#[allow(clippy::too_many_arguments, reason = "most are keywords with a default")]
impl Fixture {
    #[new]
    #[pyo3(signature = (name, manifold, base_from_fixture=None, *, sigma=0.0, sigma_angle=0.0, free=false, placement=None))]
    fn new(
        name: String,
        manifold: &Manifold,
        base_from_fixture: Option<Numbers<'_>>,
        sigma: f64,
        sigma_angle: f64,
        free: bool,
        placement: Option<String>,
    ) -> PyResult<Fixture> {
        let title = format!("fixture `{name}`");
        let place = base_from_fixture.as_ref();
        let place = place.map(|pose| one_pose(pose, &format!("{title}, base_from_fixture"))).transpose()?;
        let fixture = estimate::Fixture {
            manifold: manifold.shape.clone(),
            base_from_fixture: place,
            prior: place_prior(&title, sigma, sigma_angle, free)?,
            placement: placement.unwrap_or_else(|| problem_file::placement(&name).to_owned()),
            name,
        };
        Ok(Fixture { fixture, manifold: manifold.clone() })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.fixture.name
    }

    fn __repr__(&self) -> String {
        format!("Fixture({:?}, {:?})", self.fixture.name, self.fixture.manifold.name())
    }
}

fn place_prior(what: &str, sigma: f64, sigma_angle: f64, free: bool) -> PyResult<PlacePrior> {
    if let Some(bad) = [sigma, sigma_angle].into_iter().find(|sigma| !(*sigma >= 0.0 && sigma.is_finite())) {
        return Err(unexpected(format!("{what}, sigma"), "a number of at least 0", format!("{bad}")));
    }
    match (free, sigma > 0.0 || sigma_angle > 0.0) {
        (true, true) => Err(unexpected(what, "free or sigma and sigma_angle", "both")),
        (true, false) => Ok(PlacePrior::Flat),
        (false, true) => Ok(PlacePrior::Gaussian { sigma, sigma_angle }),
        (false, false) => Ok(PlacePrior::Fixed),
    }
}

/// A calibration problem: robot, tool, fixtures and contacts.
///
/// Args:
///     robot: the arm.
///     tool: the tool.
///     fixtures: the fixtures.
///     contacts: by name of a fixture, the log of its contacts, or several.
///     parameters: blocks to estimate: "strain", "segment_strain", "joint_offset", "joint_origin",
///         "joint_compliance", "joint_drift", "tool", "fixture".
///     distances: known distances between origins of fixtures: (name, name, metres) or (name, name,
///         metres, sigma).
///     noise: the table [noise] of problem.toml: encoder_deg, contact_mm; default: learned from the
///         data.
///     estimate: other keys of the table [estimate] of problem.toml: loss, loss_scale, freeze,
///         prior, method, descent.
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
    fn checked(self, names: &FixtureNames) -> PyResult<Distance> {
        let (first, second, distance, sigma) = match self {
            KnownDistance::Default(first, second, distance) => (first, second, distance, DEFAULT_DISTANCE_SIGMA),
            KnownDistance::WithSigma(first, second, distance, sigma) => (first, second, distance, sigma),
        };
        let between = (names.index(&first, "distances")?, names.index(&second, "distances")?);
        let is_positive = |value: f64| value > 0.0 && value.is_finite();
        if between.0 == between.1 || !is_positive(distance) || !is_positive(sigma) {
            let found = format!("({first:?}, {second:?}, {distance}, {sigma})");
            return Err(unexpected("distances", "two fixtures, a positive distance and its sigma (m)", found));
        }
        Ok(Distance { between, distance, sigma })
    }
}

/// Names of fixtures, which are distinct, with their indices.
struct FixtureNames {
    names: Vec<String>,
    indices: HashMap<String, usize>,
}

impl FixtureNames {
    fn new(fixtures: &[PyRef<'_, Fixture>]) -> PyResult<FixtureNames> {
        let names: Vec<String> = fixtures.iter().map(|fixture| fixture.fixture.name.clone()).collect();
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

/// The logs of all fixtures as one, in the order of `contacts`; appends their inputs.
fn joined_log(
    contacts: &Bound<'_, PyMapping>,
    names: &FixtureNames,
    dof: usize,
    inputs: &mut Vec<Input>,
) -> PyResult<touchcal::contact::ContactLog> {
    let mut log = touchcal::contact::ContactLog::new(dof);
    for item in contacts.items()?.try_iter()? {
        let (name, logs): (String, Bound<'_, PyAny>) = item?.extract()?;
        let fixture = names.index(&name, "contacts")?;
        let logs: Vec<PyRef<'_, ContactLog>> = match logs.cast::<ContactLog>() {
            Ok(one) => vec![one.borrow()],
            Err(_) => logs.extract()?,
        };
        for part in logs {
            if part.log.dof() != dof {
                let (expected, found) = (format!("{dof} joints"), format!("{}", part.log.dof()));
                return Err(unexpected(part.input.path.clone(), expected, found));
            }
            log.append(&part.log, fixture);
            inputs.push(part.input.clone());
        }
    }
    Ok(log)
}

#[pymethods]
#[allow(clippy::too_many_arguments, reason = "most are keywords with a default")]
impl Problem {
    #[new]
    #[pyo3(signature = (robot, tool, fixtures, contacts, *, parameters, distances=None, noise=None, estimate=None))]
    fn new(
        robot: &Robot,
        tool: &Tool,
        fixtures: Vec<PyRef<'_, Fixture>>,
        contacts: &Bound<'_, PyMapping>,
        parameters: Vec<String>,
        distances: Option<Vec<KnownDistance>>,
        noise: Option<Bound<'_, PyMapping>>,
        estimate: Option<Bound<'_, PyMapping>>,
    ) -> PyResult<Problem> {
        let arm = &robot.file.robot;
        let settings = Settings::read(&settings_text(parameters, noise, estimate)?, SETTINGS, arm);
        let settings = settings.map_err(|error| io(without_lines(error)))?;
        let mut inputs = vec![robot.file.input.clone()];
        let names = FixtureNames::new(&fixtures)?;
        let mut nominal = Vec::with_capacity(fixtures.len());
        for given in &fixtures {
            let mut fixture = given.fixture.clone();
            fixture.prior = settings.fixture_freedom(fixture.prior);
            if let Some(expected) = problem_file::missing_place(&fixture) {
                return Err(unexpected(format!("fixture `{}`", fixture.name), expected, "none"));
            }
            inputs.extend(given.manifold.inputs.iter().cloned());
            nominal.push(fixture);
        }
        let log = joined_log(contacts, &names, arm.dof(), &mut inputs)?;
        let distances = distances.unwrap_or_default().into_iter().map(|distance| distance.checked(&names));
        let distances: Vec<Distance> = distances.collect::<PyResult<_>>()?;
        let problem = settings.problem(arm.clone(), (tool.tool.clone(), nominal, distances), log);
        let problem = problem.map_err(|error| io(without_lines(error)))?;
        Problem::of(Loaded { problem, urdf: robot.file.text.clone(), inputs })
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

    /// Assumptions made in reading logs, as issued in warnings.
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
        warn(py, &self.loaded.problem.contacts)?;
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

/// The error without line and column, which refer to a generated text.
fn without_lines(mut error: IoError) -> IoError {
    if let IoError::Unexpected { place, .. } | IoError::Syntax { place, .. } = &mut error {
        place.line = None;
        place.column = None;
    }
    error
}
