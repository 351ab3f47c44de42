//! A calibration that was saved.

use std::path::PathBuf;

use numpy::PyArray2;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::io;
use touchcal::io::estimate_file::Status;

use crate::error::io as io_error;
use crate::estimate_tables;
use crate::result::{CalibrationWarning, NullDirection, Parameter, WorkspaceUncertainty};
use crate::robot::Robot;
use crate::summary::Summary;

/// A calibration that was saved: what calibrated.urdf and estimate.json hold, as `Calibration` has
/// it. `evaluate` and `compare` take it.
///
/// `saved["joint_offset.joint_a1"]` is the parameter of that name.
///
/// Attributes:
///     created: when the estimation ended (UTC); None in files of earlier versions.
///     version: of touchcal that wrote it.
#[pyclass(frozen, module = "touchcal")]
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SavedCalibration {
    pub saved: io::SavedCalibration,
}

#[pymethods]
impl SavedCalibration {
    /// Reads the folder that `Calibration.save` or `touchcal calibrate --out` wrote, or an
    /// estimate.json alone. The SHA-256 of files that a touchcal.json beside them lists is checked.
    ///
    /// Raises:
    ///     FileError, InputError: if a file is missing that is listed, or was changed since; or if
    ///         it is of a calibration whose writing was interrupted.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<SavedCalibration> {
        Ok(SavedCalibration { saved: io::SavedCalibration::read(&path).map_err(io_error)? })
    }

    #[getter]
    fn created(&self) -> Option<&str> {
        self.saved.file.created.as_deref()
    }

    #[getter]
    fn version(&self) -> &str {
        &self.saved.file.version
    }

    /// Whether the result may be used, with doubts or without.
    #[getter]
    fn usable(&self) -> bool {
        self.saved.file.status != Status::NotUsable
    }

    /// "usable", "doubtful" or "not_usable".
    #[getter]
    fn status(&self) -> &'static str {
        self.saved.file.status.name()
    }

    /// Estimated parameters, in order.
    #[getter]
    fn parameters(&self) -> Vec<Parameter> {
        self.saved.file.parameters.iter().map(Into::into).collect()
    }

    /// Covariance of the parameters, in their order and units, shape (P, P).
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        estimate_tables::covariance(py, &self.saved.file)
    }

    /// Number of directions of the parameters that the data determine.
    #[getter]
    fn rank(&self) -> usize {
        self.saved.file.rank
    }

    /// Directions of the parameters that the data do not determine.
    #[getter]
    fn null_space(&self) -> Vec<NullDirection> {
        self.saved.file.null_space.iter().cloned().map(NullDirection::from).collect()
    }

    /// Warnings, with advice.
    #[getter]
    fn warnings(&self) -> Vec<CalibrationWarning> {
        self.saved.file.warnings.iter().cloned().map(CalibrationWarning::from).collect()
    }

    /// Names of effects and declarations that contacts cannot test.
    #[getter]
    fn untested(&self) -> Vec<String> {
        self.saved.file.untested.clone()
    }

    /// How well the tool is known across the workspace; None where contacts are measured by a
    /// projection, and in files of earlier versions.
    #[getter]
    fn workspace_uncertainty(&self) -> Option<WorkspaceUncertainty> {
        self.saved.file.workspace_uncertainty.map(WorkspaceUncertainty::from)
    }

    /// Input files: paths and SHA-256 of the content.
    #[getter]
    fn inputs(&self) -> Vec<(&str, &str)> {
        self.saved.file.inputs.iter().map(|input| (input.path.as_str(), input.sha256.as_str())).collect()
    }

    /// The calibrated arm, standing upright; None of an estimate.json alone, and of earlier
    /// versions.
    #[getter]
    fn robot(&self) -> Option<Robot> {
        self.saved.urdf.clone().map(|file| Robot { file })
    }

    /// The result in some lines, as `Calibration.summary`, without the noise and what contacts
    /// say against the problem.
    fn summary(&self) -> String {
        Summary::new(&self.saved.file, None, None, 10).text()
    }

    fn _repr_html_(&self) -> String {
        Summary::new(&self.saved.file, None, None, 100).html()
    }

    fn _ipython_key_completions_(&self) -> Vec<&str> {
        self.saved.file.parameters.iter().map(|entry| entry.name.as_str()).collect()
    }

    fn __getitem__(&self, name: &str) -> PyResult<Parameter> {
        estimate_tables::parameter(&self.saved.file, name)
    }

    /// A row a parameter: name, block, unit, value, sigma, prior_sigma, identifiable.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        estimate_tables::parameters_frame(py, &self.saved.file)
    }

    /// The covariance with the names of the parameters as index and columns, in their units.
    fn covariance_frame<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        estimate_tables::covariance_frame(py, &self.saved.file)
    }

    /// The text of estimate.json: of a file of an earlier version as this version writes it.
    fn to_json(&self) -> PyResult<String> {
        self.saved.file.to_json().map_err(io_error)
    }

    fn __repr__(&self) -> String {
        let io::SavedCalibration { name, file, .. } = &self.saved;
        format!("SavedCalibration({name:?}, {:?}, {} parameters)", file.status.name(), file.parameters.len())
    }
}
