//! What serialises, as Python's dictionaries; and the text of files from those.

use crate::trouble::Trouble;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString};
use serde::Serialize;
use serde_json::Value;

/// Most tables within tables of a scene that is made of a dictionary.
const MOST_LEVELS: usize = 32;

/// As serde sees it.
///
/// # Errors
/// Never for what the library gives.
pub fn json(value: &impl Serialize) -> Result<Value, Trouble> {
    serde_json::to_value(value).map_err(|error| Trouble::input(error.to_string()))
}

/// As Python's own types.
///
/// # Errors
/// When Python has no memory left.
pub fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => py.None().into_bound(py),
        Value::Bool(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Value::Number(number) => match (number.as_i64(), number.as_u64()) {
            (Some(whole), _) => whole.into_pyobject(py)?.into_any(),
            (None, Some(whole)) => whole.into_pyobject(py)?.into_any(),
            (None, None) => number.as_f64().into_pyobject(py)?.into_any(),
        },
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Array(values) => {
            let values = values.iter().map(|value| to_python(py, value)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, values)?.into_any()
        }
        Value::Object(_) => to_dict(py, value)?.into_any(),
    })
}

/// An object as a dictionary; empty for what is no object.
///
/// # Errors
/// As [`to_python`].
pub fn to_dict<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in value.as_object().into_iter().flatten() {
        dict.set_item(key, to_python(py, value)?)?;
    }
    Ok(dict)
}

/// Without keys that hold nothing: in a file they are left out.
pub fn without_nulls(value: Value) -> Value {
    match value {
        Value::Object(map) => map
            .into_iter()
            .filter(|(_, value)| !value.is_null())
            .map(|(key, value)| (key, without_nulls(value)))
            .collect(),
        Value::Array(values) => values.into_iter().map(without_nulls).collect(),
        other => other,
    }
}

/// A dictionary as a TOML table; keys that are None are left out.
///
/// # Errors
/// `TypeError` for what TOML has no type for, `ValueError` for tables too deep in one another.
pub fn to_table(dict: &Bound<'_, PyDict>) -> PyResult<toml::Table> {
    table(dict, "", 0)
}

fn table(dict: &Bound<'_, PyDict>, place: &str, level: usize) -> PyResult<toml::Table> {
    if level > MOST_LEVELS {
        return Err(PyValueError::new_err(format!("{place}: tables lie more than {MOST_LEVELS} deep in one another")));
    }
    let mut table = toml::Table::new();
    for (key, value) in dict {
        let key = key.extract::<String>().map_err(|_| PyTypeError::new_err(format!("{place}: a key must be a str")))?;
        let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
        if !value.is_none() {
            table.insert(key, to_toml(&value, &place, level)?);
        }
    }
    Ok(table)
}

/// A value of Python as one of TOML; `place` names it in messages.
///
/// # Errors
/// As [`to_table`].
pub fn to_value(value: &Bound<'_, PyAny>, place: &str) -> PyResult<toml::Value> {
    to_toml(value, place, 0)
}

fn to_toml(value: &Bound<'_, PyAny>, place: &str, level: usize) -> PyResult<toml::Value> {
    if let Ok(dict) = value.cast::<PyDict>() {
        return Ok(toml::Value::Table(table(dict, place, level + 1)?));
    }
    // A flag of Python is a whole number too, a whole number a number.
    if let Ok(flag) = value.extract::<bool>() {
        return Ok(toml::Value::Boolean(flag));
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(toml::Value::String(text));
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Ok(toml::Value::Integer(whole));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(toml::Value::Float(number));
    }
    // What has no length may have no end.
    let (Ok(_), Ok(items)) = (value.len(), value.try_iter()) else {
        return Err(PyTypeError::new_err(format!("{place}: a scene has no {}", value.get_type().name()?)));
    };
    if level > MOST_LEVELS {
        return Err(PyValueError::new_err(format!("{place}: lists lie more than {MOST_LEVELS} deep in one another")));
    }
    let items = items.enumerate().map(|(k, item)| to_toml(&item?, &format!("{place}[{k}]"), level + 1));
    Ok(toml::Value::Array(items.collect::<PyResult<_>>()?))
}
