//! What estimate.json holds, as Python has it.

use numpy::PyArray2;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use touchcal::io::estimate_file::{EstimateFile, ParameterEntry};
use touchcal::io::{did_you_mean, list};

use crate::array::fixed_rows;
use crate::frame::{self, Frame};
use crate::result::Parameter;

/// The parameter of that name.
pub fn parameter(file: &EstimateFile, name: &str) -> PyResult<Parameter> {
    let found = file.parameters.iter().find(|entry| entry.name == name);
    found.map(Into::into).ok_or_else(|| {
        let names = file.parameters.iter().map(|entry| entry.name.as_str());
        let found = format!("{name:?}{}", did_you_mean(name, names.clone()));
        PyKeyError::new_err(format!("expected the name of a parameter ({}), found {found}", list(names)))
    })
}

/// The covariance, shape (P, P).
pub fn covariance<'py>(py: Python<'py>, file: &EstimateFile) -> PyResult<Bound<'py, PyArray2<f64>>> {
    fixed_rows(py, file.covariance.concat(), file.parameters.len())
}

/// The covariance with the names of the parameters.
pub fn covariance_frame<'py>(py: Python<'py>, file: &EstimateFile) -> PyResult<Bound<'py, PyAny>> {
    let names: Vec<&str> = file.parameters.iter().map(|entry| entry.name.as_str()).collect();
    frame::labelled(covariance(py, file)?, &names)
}

/// A row a parameter.
pub fn parameters_frame<'py>(py: Python<'py>, file: &EstimateFile) -> PyResult<Bound<'py, PyAny>> {
    let entries = &file.parameters;
    let text = |part: fn(&ParameterEntry) -> &String| entries.iter().map(part).collect::<Vec<_>>();
    let number = |part: fn(&ParameterEntry) -> Option<f64>| {
        entries.iter().map(|entry| part(entry).unwrap_or(f64::NAN)).collect::<Vec<_>>()
    };
    Frame::new(py)
        .column("name", text(|entry| &entry.name))?
        .column("block", text(|entry| &entry.block))?
        .column("unit", text(|entry| &entry.unit))?
        .column("value", number(|entry| Some(entry.value)))?
        .column("sigma", number(|entry| entry.sigma))?
        .column("prior_sigma", number(|entry| entry.prior_sigma))?
        .column("identifiable", entries.iter().map(|entry| entry.identifiable).collect::<Vec<_>>())?
        .build()
}
