//! Evaluation of an arm on contacts, without estimation.

use std::path::PathBuf;

use pyo3::prelude::*;
use touchcal::estimate::{ParameterPosterior, apply_estimate, evaluate_held_out};
use touchcal::io::SavedCalibration;
use touchcal::io::calibration_folder::apply_written;
use touchcal::io::estimate_file::{EstimateFile, RobotEntry};
use touchcal::io::problem_file::check_joint_torques;
use touchcal::io::urdf;

use crate::comparison::AnyCalibration;
use crate::error::{Given, argument, io, optional_argument, unexpected};
use crate::evaluation::Evaluation;
use crate::problem::Problem;
use crate::threads::detached;

/// Evaluates an arm on a problem's contacts, without estimation, as `touchcal evaluate` does.
///
/// Args:
///     problem: contacts, best others than those of the fit; those that are held out, if there
///         are any.
///     calibration: the calibrated arm, saved or not, with tool and fixtures where it found
///         them; default: the problem's arm as it is.
///     urdf: this URDF's arm instead, as `touchcal evaluate --urdf` does,
///     estimate: and with it, with tool and fixtures where this estimate.json found them.
///
/// Raises:
///     InputError: if the other arm has other moving joints, or the estimate is of another robot;
///         and if the arm's compliances belong to joint torques, which the contacts lack.
#[pyfunction]
#[pyo3(signature = (problem, calibration=None, *, urdf=None, estimate=None))]
pub fn evaluate(
    py: Python<'_>,
    problem: &Bound<'_, PyAny>,
    calibration: Option<Bound<'_, PyAny>>,
    urdf: Option<PathBuf>,
    estimate: Option<PathBuf>,
) -> PyResult<Evaluation> {
    let problem = argument::<Given<Problem>>(problem, "problem")?.0;
    let calibration: Option<AnyCalibration<'_>> = optional_argument(calibration.as_ref(), "calibration")?;
    if calibration.is_some() && (urdf.is_some() || estimate.is_some()) {
        return Err(unexpected("evaluate", "a calibration, or urdf and estimate", "both"));
    }
    let given = &problem.get().loaded.problem;
    // A log may have millions of contacts: a copy only where another one takes its place.
    let of_held_out = (!given.held_out.is_empty()).then(|| given.clone().of_held_out_contacts());
    let nominal = of_held_out.as_ref().unwrap_or(given);
    let mut evaluated = nominal.clone();
    let mut posterior = None;
    match calibration {
        None => {}
        Some(AnyCalibration::Made(calibration)) => {
            let estimate = &calibration.solved.estimate;
            urdf::check_like(&nominal.robot, &estimate.robot, estimate.robot.name()).map_err(io)?;
            calibration.file.check_tool(&nominal.tool.tip_from_tool, "the calibration").map_err(io)?;
            apply_estimate(&mut evaluated, |name| estimate.parameter(name).map(|parameter| parameter.value));
            evaluated.robot = estimate.robot.clone().with_gravity(*nominal.robot.gravity());
            posterior = ParameterPosterior::of_estimate(estimate);
        }
        Some(AnyCalibration::Saved(calibration)) => {
            let SavedCalibration { name, file, urdf } = &calibration.saved;
            let Some(urdf) = urdf else {
                return Err(unexpected(name, "a folder with calibrated.urdf", "an estimate.json alone"));
            };
            urdf::check_like(&nominal.robot, &urdf.robot, name).map_err(io)?;
            file.check_robot(&RobotEntry::of(&nominal.robot), name).map_err(io)?;
            file.check_tool(&nominal.tool.tip_from_tool, name).map_err(io)?;
            apply_written(&mut evaluated, file);
            evaluated.robot = urdf.robot.clone().with_gravity(*nominal.robot.gravity());
            posterior = file.posterior();
        }
    }
    let other = urdf.map(|path| urdf::read_like(&nominal.robot, &path)).transpose().map_err(io)?;
    if let Some(path) = estimate {
        let file = EstimateFile::read_file(&path).map_err(io)?;
        let name = path.display().to_string();
        file.check_robot(&RobotEntry::of(&nominal.robot), &name).map_err(io)?;
        file.check_tool(&nominal.tool.tip_from_tool, &name).map_err(io)?;
        apply_written(&mut evaluated, &file);
        posterior = file.posterior();
    }
    if let Some(other) = other {
        evaluated.robot = other.robot;
    }
    check_joint_torques(&evaluated.robot, &nominal.contacts, nominal.contacts.has_joint_torques()).map_err(io)?;
    let evaluation = detached(py, || evaluate_held_out(nominal, &evaluated, posterior.as_ref()));
    Ok(Evaluation::new(evaluation, &nominal.fixtures))
}
