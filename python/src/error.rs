//! Exceptions, with the texts that the command-line tool prints.

use pyo3::PyClass;
use pyo3::exceptions::{PyException, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use touchcal::io::{IoError, Place, did_you_mean};

/// Most characters of a value in a message.
const MOST_SHOWN: usize = 60;

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

/// The exception for an argument `what` that is the name `found` of no fixture.
pub fn unknown_fixture(what: &str, names: &[&str], found: &str) -> PyErr {
    let expected = format!("the name of a fixture ({})", names.join(", "));
    unexpected(what, expected, format!("{found:?}{}", did_you_mean(found, names.iter().copied())))
}

/// The exception for a value of another type than `expected`; [`argument`] adds its name.
pub fn wrong_type(expected: &str, found: &Bound<'_, PyAny>) -> PyErr {
    PyTypeError::new_err(format!("expected {expected}, found {}", shown(found)))
}

/// The exception for an argument that is a list as `expected`, but for an item.
pub fn wrong_item(expected: &str, found: &Bound<'_, PyAny>) -> PyErr {
    PyTypeError::new_err(format!("expected {expected}, found {} in it", shown(found)))
}

/// The exception for an argument `name` of another type than `expected`. pyo3 has the name in a
/// note alone, and from Python 3.11 on.
pub fn wrong_argument(name: &str, expected: &str, found: &Bound<'_, PyAny>) -> PyErr {
    of_argument(name, &wrong_type(expected, found), found.py())
}

fn of_argument(name: &str, error: &PyErr, py: Python<'_>) -> PyErr {
    PyTypeError::new_err(format!("argument '{name}': {}", error.value(py)))
}

/// The value of an argument, whose name errors have.
pub fn argument<'py, T: for<'a> FromPyObject<'a, 'py, Error = PyErr>>(
    value: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<T> {
    value.extract::<T>().map_err(|error| of_argument(name, &error, value.py()))
}

/// The value of an argument that may be left out.
pub fn optional_argument<'py, T: for<'a> FromPyObject<'a, 'py, Error = PyErr>>(
    value: Option<&Bound<'py, PyAny>>,
    name: &str,
) -> PyResult<Option<T>> {
    value.map(|value| argument(value, name)).transpose()
}

/// A class of objects that are given as arguments.
pub trait ArgumentClass: PyClass {
    /// What was expected where another object is given, with how to make one.
    const EXPECTED: &'static str;
}

/// An argument that is an object of a class. pyo3 would say of another one what it is no instance
/// of, and not how to make one.
pub struct Given<T>(pub Py<T>);

impl<'py, T: ArgumentClass> FromPyObject<'_, 'py> for Given<T> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let found = object.to_owned();
        found.cast::<T>().map(|given| Given(given.clone().unbind())).map_err(|_| wrong_type(T::EXPECTED, &found))
    }
}

/// An argument that is a mapping.
pub fn mapping_argument<'a, 'py>(value: &'a Bound<'py, PyAny>, name: &str) -> PyResult<&'a Bound<'py, PyMapping>> {
    value.cast::<PyMapping>().map_err(|_| wrong_argument(name, "a mapping", value))
}

/// A value with its type, as messages show it.
fn shown(found: &Bound<'_, PyAny>) -> String {
    let kind = found.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
    let shown = found.repr().map_or_else(|_| String::new(), |shown| shown.to_string());
    if shown.chars().count() > MOST_SHOWN { kind } else { format!("{kind} {shown}") }
}

/// The exception for an argument `what` of which the library says `message`.
pub fn refused(what: impl Into<String>, message: impl ToString) -> PyErr {
    io(IoError::Syntax { place: Box::new(Place::file(what)), message: message.to_string() })
}

/// The exception where an object of `class` is to be sent to another process: what to do instead.
pub fn unpicklable(class: &str, instead: &str) -> PyErr {
    PyTypeError::new_err(format!("a touchcal.{class} cannot be pickled; {instead}"))
}
