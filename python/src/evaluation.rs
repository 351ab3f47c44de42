//! The score of an arm on contacts.

use std::path::PathBuf;

use pyo3::prelude::*;
use touchcal::estimate::{self, apply_estimated_places};
use touchcal::io::calibration_folder::place_written;
use touchcal::io::estimate_file::EstimateFile;
use touchcal::io::urdf;

use crate::calibration::Calibration;
use crate::error::{io, unexpected};
use crate::problem::Problem;
use crate::score::Score;

/// Evaluates an arm on a problem's contacts, without estimation.
///
/// Args:
///     problem: contacts, best others than those of the fit.
///     calibration: score the calibrated arm, with tool and fixtures where it found them; default:
///         the problem's arm as it is.
///     urdf: score this URDF's arm instead, as `touchcal evaluate --urdf` does,
///     estimate: and with it, with tool and fixtures where this estimate.json found them.
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
        let estimated = |name: &str| calibration.solved.estimate.parameter(name).map(|parameter| parameter.value);
        apply_estimated_places(&mut problem, estimated);
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
