//! How far contacts are from touching.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use touchcal::estimate::{self, apply_estimated_places};
use touchcal::io::calibration_folder::place_written;
use touchcal::io::estimate_file::EstimateFile;
use touchcal::io::urdf;

use crate::calibration::Calibration;
use crate::error::{io, unexpected};
use crate::frame::Frame;
use crate::problem::Problem;

/// Distances from touching, in metres.
///
/// Attributes:
///     count: number of contacts.
///     mean, rms, max: of their distances (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    count: usize,
    mean: f64,
    rms: f64,
    max: f64,
}

impl From<&estimate::Spread> for Spread {
    fn from(spread: &estimate::Spread) -> Self {
        let estimate::Spread { count, mean, rms, max } = *spread;
        Spread { count, mean, rms, max }
    }
}

#[pymethods]
impl Spread {
    fn __repr__(&self) -> String {
        let Spread { count, mean, rms, max } = self;
        format!("Spread(count={count}, mean={mean:?}, rms={rms:?}, max={max:?})")
    }
}

/// How well an arm explains contacts: over all, and over each fixture's.
///
/// A contact's distance is the size of its manifold's residual; for a socket, the distance of the
/// ball's centre from the mean of all centres computed for that socket.
///
/// Attributes:
///     all: over all contacts.
#[pyclass(frozen, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    #[pyo3(get)]
    all: Spread,
    per_fixture: Vec<(String, Spread)>,
}

impl Score {
    /// The score of a problem's fixtures.
    pub fn new(score: &estimate::Score, fixtures: &[estimate::Fixture]) -> Score {
        let each =
            fixtures.iter().zip(&score.per_fixture).map(|(fixture, spread)| (fixture.name.clone(), spread.into()));
        Score { all: (&score.all).into(), per_fixture: each.collect() }
    }
}

#[pymethods]
impl Score {
    /// By name of the fixture.
    #[getter]
    fn per_fixture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.per_fixture.iter().try_for_each(|(name, spread)| dict.set_item(name, spread.clone()))?;
        Ok(dict)
    }

    /// A row a fixture: fixture, contacts, mean, rms, max (m).
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let each =
            |value: fn(&Spread) -> f64| self.per_fixture.iter().map(|(_, spread)| value(spread)).collect::<Vec<_>>();
        Frame::new(py)
            .column("fixture", self.per_fixture.iter().map(|(name, _)| name).collect::<Vec<_>>())?
            .column("contacts", self.per_fixture.iter().map(|(_, spread)| spread.count).collect::<Vec<_>>())?
            .column("mean", each(|spread| spread.mean))?
            .column("rms", each(|spread| spread.rms))?
            .column("max", each(|spread| spread.max))?
            .build()
    }

    fn __repr__(&self) -> String {
        format!("Score({})", self.all.__repr__())
    }
}

/// Scores an arm on a problem's contacts; nothing is fitted.
///
/// Args: problem: contacts, best others than those of the fit. calibration: score the calibrated
/// arm, with tool and fixtures where it found them; default: the problem's arm as it is. urdf:
/// score this URDF's arm instead, as `touchcal evaluate --urdf` does, estimate: and with it, with
/// tool and fixtures where this estimate.json found them.
///
/// Raises:
///     InputError: if the other arm has other moving joints.
#[pyfunction]
#[pyo3(signature = (problem, calibration=None, *, urdf=None, estimate=None))]
pub fn evaluate(
    py: Python<'_>,
    problem: &Problem,
    calibration: Option<&Calibration>,
    urdf: Option<PathBuf>,
    estimate: Option<PathBuf>,
) -> PyResult<Score> {
    if calibration.is_some() && (urdf.is_some() || estimate.is_some()) {
        return Err(unexpected("evaluate", "a calibration, or urdf and estimate", "both"));
    }
    let mut problem = problem.loaded.problem.clone();
    if let Some(calibration) = calibration {
        let robot = &calibration.solved.estimate.robot;
        urdf::check_like(&problem.robot, robot, robot.name()).map_err(io)?;
        let found = |name: &str| calibration.solved.estimate.parameter(name).map(|parameter| parameter.value);
        apply_estimated_places(&mut problem, found);
        problem.robot = robot.clone().with_gravity(*problem.robot.gravity());
    }
    let other = urdf.map(|path| urdf::read_like(&problem.robot, &path)).transpose().map_err(io)?;
    if let Some(path) = estimate {
        place_written(&mut problem, &EstimateFile::read_file(&path).map_err(io)?);
    }
    if let Some(other) = other {
        problem.robot = other.robot;
    }
    let score = py.detach(|| estimate::evaluate(&problem));
    Ok(Score::new(&score, &problem.fixtures))
}
