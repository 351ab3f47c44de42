//! Exceptions, with the texts that the command-line tool prints.

use pyo3::exceptions::{PyException, PyTypeError};
use pyo3::prelude::*;
use touchcal::io::{IoError, Place};

pyo3::create_exception!(
    touchcal,
    Error,
    PyException,
    "Whatever touchcal refuses; the text is that of the command line."
);
pyo3::create_exception!(
    touchcal,
    InputError,
    Error,
    "A file or argument is not what it should be. `file`, `line` and `field` say where, if known, else they are None."
);
pyo3::create_exception!(touchcal, FileError, Error, "The operating system refused to read or write `file`.");
pyo3::create_exception!(touchcal, SimulationError, Error, "A scenario cannot be simulated.");

/// The exception that an error of a file becomes.
pub fn io(error: IoError) -> PyErr {
    let message = error.to_string();
    let (error, place) = match error {
        IoError::File { path, .. } => (FileError::new_err(message), Place::file(path)),
        IoError::Unexpected { place, .. } | IoError::Syntax { place, .. } => (InputError::new_err(message), *place),
        _ => (Error::new_err(message), Place::default()),
    };
    let result = Python::attach(|py| {
        let value = error.value(py);
        value.setattr("file", place.file)?;
        value.setattr("line", place.line)?;
        value.setattr("field", place.field)
    });
    result.err().unwrap_or(error)
}

/// The exception for an argument `what` that is not as `expected`.
pub fn unexpected(what: impl Into<String>, expected: impl Into<String>, found: impl Into<String>) -> PyErr {
    let place = Box::new(Place::file(what));
    io(IoError::Unexpected { place, expected: expected.into(), found: found.into() })
}

/// The exception for an argument `what` of which the library says `message`.
pub fn refused(what: impl Into<String>, message: impl ToString) -> PyErr {
    io(IoError::Syntax { place: Box::new(Place::file(what)), message: message.to_string() })
}

/// The exception where an object of `class` is to be sent to another process: what to do instead.
pub fn unpicklable(class: &str, instead: &str) -> PyErr {
    PyTypeError::new_err(format!("a touchcal.{class} cannot be pickled; {instead}"))
}
