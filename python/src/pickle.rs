//! Objects as bytes, which pickle sends to other processes.

use ciborium::into_writer;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Serialize;

use crate::error::{refused, unexpected};

/// Version and revision: objects are made again by the same alone.
pub const VERSION: &str = env!("TOUCHCAL_VERSION");

/// What pickle takes of an object: the function that makes it again, and its arguments: class,
/// version, data, and the problem that the object belongs to.
pub type Reduced<'py> = (Bound<'py, PyAny>, (&'static str, &'static str, Bound<'py, PyBytes>, Option<Py<PyAny>>));

/// An object of a class with these data, of that problem if it belongs to one.
pub fn reduced<'py>(
    py: Python<'py>,
    class: &'static str,
    data: &impl Serialize,
    problem: Option<Py<PyAny>>,
) -> PyResult<Reduced<'py>> {
    let mut bytes = Vec::new();
    into_writer(data, &mut bytes).map_err(|error| refused("pickle", error))?;
    let restore = py.import("touchcal._touchcal")?.getattr("_restore")?;
    Ok((restore, (class, VERSION, PyBytes::new(py, &bytes), problem)))
}

/// Refuses an object of another version.
pub fn check_version(version: &str) -> PyResult<()> {
    if version == VERSION {
        return Ok(());
    }
    Err(unexpected("pickle", format!("an object of touchcal {VERSION}"), format!("one of {version}")))
}
