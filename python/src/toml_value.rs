//! Python's mappings and values as TOML.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyMapping};

/// A mapping as a TOML table; entries that are None are left out.
pub fn as_table(mapping: &Bound<'_, PyMapping>) -> PyResult<toml::Table> {
    let mut table = toml::Table::new();
    for item in mapping.items()?.try_iter()? {
        let (key, value): (String, Bound<'_, PyAny>) = item?.extract()?;
        if !value.is_none() {
            table.insert(key, as_value(&value)?);
        }
    }
    Ok(table)
}

fn as_value(value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    if let Ok(mapping) = value.cast::<PyDict>() {
        return Ok(as_table(mapping.as_mapping())?.into());
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(value.extract::<bool>()?.into());
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(text.into());
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(number.into());
    }
    let items = value.try_iter()?.map(|item| as_value(&item?)).collect::<PyResult<Vec<toml::Value>>>()?;
    Ok(items.into())
}
