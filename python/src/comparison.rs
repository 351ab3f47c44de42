//! What changed between two calibrations.

use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::estimate::{self, ParameterPosterior};
use touchcal::experiment::RmsAndMax;
use touchcal::io::{self, CalibrationChanges};

use crate::calibration::Calibration;
use crate::error::{argument, io as io_error, unexpected, wrong_type};
use crate::repr::{length, number};
use crate::saved::SavedCalibration;
use crate::threads::detached;

/// A parameter in two calibrations.
///
/// Attributes:
///     name: "joint_offset.joint_a1".
///     earlier, later: both estimates (SI).
///     sigma: standard deviation of their difference if the parameter is the same (SI); 0 where
///         both are fixed, or mostly the prior's.
///     deviations: later minus earlier in these standard deviations; None where they are 0.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterChange {
    name: String,
    earlier: f64,
    later: f64,
    sigma: f64,
    deviations: Option<f64>,
}

impl From<&estimate::ParameterChange> for ParameterChange {
    fn from(change: &estimate::ParameterChange) -> Self {
        let [earlier, later] = change.values;
        ParameterChange {
            name: change.name.clone(),
            earlier,
            later,
            sigma: change.sigma,
            deviations: change.deviations(),
        }
    }
}

#[pymethods]
impl ParameterChange {
    fn __repr__(&self) -> String {
        let deviations = self.deviations.map_or_else(|| "not determined".to_owned(), number);
        format!("ParameterChange({:?}, {deviations} standard deviations)", self.name)
    }
}

/// What changed between two calibrations of one arm, as `touchcal compare` tells.
///
/// Attributes:
///     p_value: probability of differences of the arm's parameters as large by chance, if nothing
///         changed; None if contacts determine none of them.
///     statistic: squared length of the differences in units of their covariance, chi-squared
///         distributed if nothing changed.
///     degrees_of_freedom: number of directions that contacts determine.
///     parameters: the parameters that both calibrations estimate.
///     only_in_one: names of parameters that one of them estimates.
///     tool_p_value: the same for how the tool is mounted; None if both have another nominal pose,
///         or none of its parameters.
///     tool_parameters: parameters of the tool.
///     tip_motion: by how much the tip moves at equal joint positions across the workspace (m),
///         root mean square and largest; None unless both have a URDF.
///     common_logs: paths of logs from which both were made.
///     notes: what to keep in mind about the comparison, with advice, as the command prints it.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    p_value: Option<f64>,
    statistic: f64,
    degrees_of_freedom: usize,
    parameters: Vec<ParameterChange>,
    only_in_one: Vec<String>,
    tool_p_value: Option<f64>,
    tool_parameters: Vec<ParameterChange>,
    tip_motion: Option<(f64, f64)>,
    common_logs: Vec<String>,
    notes: Vec<String>,
}

impl From<CalibrationChanges> for Comparison {
    fn from(changes: CalibrationChanges) -> Self {
        let each = |found: &estimate::Comparison| found.parameters.iter().map(ParameterChange::from).collect();
        let notes = changes.notes().iter().map(|(words, advice)| format!("{words} -> {advice}")).collect();
        let CalibrationChanges { arm, tool, tip_motion, common_logs, .. } = changes;
        Comparison {
            parameters: each(&arm),
            p_value: arm.p_value,
            statistic: arm.statistic,
            degrees_of_freedom: arm.degrees_of_freedom,
            only_in_one: arm.only_in_one,
            tool_p_value: tool.as_ref().and_then(|tool| tool.p_value),
            tool_parameters: tool.as_ref().map(each).unwrap_or_default(),
            tip_motion: tip_motion.map(|motion| {
                let RmsAndMax { rms, max } = motion.position;
                (rms, max)
            }),
            common_logs,
            notes,
        }
    }
}

#[pymethods]
impl Comparison {
    fn __repr__(&self) -> String {
        let p = self.p_value.map_or_else(|| "None".to_owned(), number);
        let moves = self.tip_motion.map_or_else(String::new, |(rms, _)| format!(", moves the tip by {}", length(rms)));
        let notes: String = self.notes.iter().map(|note| format!("; note: {note}")).collect();
        format!("Comparison(p = {p}, {} parameters{moves}{notes})", self.parameters.len())
    }
}

/// A calibration, saved or not.
pub enum AnyCalibration<'py> {
    Made(PyRef<'py, Calibration>),
    Saved(PyRef<'py, SavedCalibration>),
}

impl<'py> FromPyObject<'_, 'py> for AnyCalibration<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(made) = object.cast::<Calibration>() {
            return Ok(AnyCalibration::Made(made.to_owned().borrow()));
        }
        let saved = object.cast::<SavedCalibration>();
        let saved = saved.map_err(|_| wrong_type("a Calibration or a SavedCalibration", &object))?;
        Ok(AnyCalibration::Saved(saved.to_owned().borrow()))
    }
}

impl AnyCalibration<'_> {
    fn saved(&self, name: &str) -> PyResult<io::SavedCalibration> {
        match self {
            AnyCalibration::Made(calibration) => calibration.as_saved(name),
            AnyCalibration::Saved(saved) => Ok(saved.saved.clone()),
        }
    }
}

/// Tells what changed between two calibrations of an arm, and whether by more than their
/// uncertainties explain, as `touchcal compare` does.
///
/// Args:
///     earlier, later: calibrations, saved or not.
///
/// Raises:
///     InputError: if they are of two arms, have no parameter of the arm in common, or no
///         uncertainty.
#[pyfunction]
pub fn compare(py: Python<'_>, earlier: &Bound<'_, PyAny>, later: &Bound<'_, PyAny>) -> PyResult<Comparison> {
    let saved = |value, name| argument::<AnyCalibration<'_>>(value, name)?.saved(name);
    let both = [saved(earlier, "earlier")?, saved(later, "later")?];
    let posterior = |calibration: &io::SavedCalibration| -> PyResult<ParameterPosterior> {
        let found = calibration.file.posterior();
        found.ok_or_else(|| unexpected(&calibration.name, "estimates with uncertainty", "those of projections"))
    };
    let posteriors = [posterior(&both[0])?, posterior(&both[1])?];
    let changes = detached(py, || CalibrationChanges::new([&both[0], &both[1]], &posteriors)).map_err(io_error)?;
    if changes.arm.parameters.is_empty() {
        return Err(unexpected("compare", "parameters of the arm that both calibrations estimate", "none"));
    }
    Ok(changes.into())
}
