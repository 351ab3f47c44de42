//! pandas, which is imported only where it is asked for.

use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A `pandas.DataFrame` of columns under names.
pub struct Frame<'py>(Bound<'py, PyDict>);

impl<'py> Frame<'py> {
    /// No columns yet.
    pub fn new(py: Python<'py>) -> Self {
        Frame(PyDict::new(py))
    }

    /// Appends a column.
    pub fn column(self, name: &str, values: impl IntoPyObject<'py>) -> PyResult<Self> {
        self.0.set_item(name, values)?;
        Ok(self)
    }

    /// The frame.
    pub fn build(self) -> PyResult<Bound<'py, PyAny>> {
        self.0.py().import("pandas")?.call_method1("DataFrame", (self.0,))
    }
}

/// A `pandas.DataFrame` of a square matrix, with the same labels for rows and columns.
pub fn labelled<'py>(matrix: Bound<'py, PyArray2<f64>>, labels: &[&str]) -> PyResult<Bound<'py, PyAny>> {
    matrix.py().import("pandas")?.call_method1("DataFrame", (matrix, labels, labels))
}
