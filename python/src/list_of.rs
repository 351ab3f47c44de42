//! Arguments that are lists.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyMapping, PyString};

use crate::error::{wrong_item, wrong_type};

/// What lists have as items.
pub trait Item: Sized {
    /// A list of them in words.
    const LIST: &'static str;

    /// The item that a Python object is.
    fn of(object: &Bound<'_, PyAny>) -> PyResult<Self>;
}

/// A list, or another iterable; a text, whose letters would be the items, and a mapping are none.
#[derive(Debug)]
pub struct ListOf<T>(pub Vec<T>);

impl<T: Item> FromPyObject<'_, '_> for ListOf<T> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let is_other = object.is_instance_of::<PyString>() || object.is_instance_of::<PyBytes>();
        let items = object.try_iter().ok().filter(|_| !is_other && object.cast::<PyMapping>().is_err());
        let items = items.ok_or_else(|| wrong_type(T::LIST, &object))?;
        let item = |item: PyResult<Bound<'_, PyAny>>| {
            let item = item?;
            T::of(&item).map_err(|_| wrong_item(T::LIST, &item))
        };
        Ok(ListOf(items.map(item).collect::<PyResult<_>>()?))
    }
}

impl Item for String {
    const LIST: &'static str = "a list of names";

    fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        object.extract()
    }
}
