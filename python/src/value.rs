//! A figure, with its interval or the reason why there is none.

use pyo3::prelude::*;
use tirtouch::estimate;
use tirtouch::figure::Figure;

/// A figure, or the reason why there is none: ``bool(figure)`` tells which. A figure of 0 is known, and so true.
#[pyclass(frozen, module = "tirtouch", eq)]
#[derive(Clone, PartialEq)]
pub struct Value {
    /// The best value, in the unit that its name gives; None where it is not known.
    #[pyo3(get)]
    value: Option<f64>,
    /// Lower end of the interval, of 95 % where nothing else is said; None where there is no interval.
    #[pyo3(get)]
    low: Option<f64>,
    /// Upper end of the interval.
    #[pyo3(get)]
    high: Option<f64>,
    /// Why there is no value; None where there is one.
    #[pyo3(get)]
    reason: Option<String>,
}

#[pymethods]
impl Value {
    fn __bool__(&self) -> bool {
        self.value.is_some()
    }

    fn __repr__(&self) -> String {
        format!("<tirtouch.Value {}>", self.said())
    }
}

impl From<&estimate::Value> for Value {
    fn from(value: &estimate::Value) -> Self {
        match value {
            estimate::Value::Known { value, low, high } => {
                Self { value: Some(*value), low: Some(*low), high: Some(*high), reason: None }
            }
            estimate::Value::Undefined { reason } => Self::undefined(reason),
        }
    }
}

impl From<&Figure> for Value {
    fn from(figure: &Figure) -> Self {
        match figure {
            Figure::Known(value) => Self::known(*value),
            Figure::Undefined { reason } => Self::undefined(reason),
        }
    }
}

impl Value {
    pub fn known(value: f64) -> Self {
        Self { value: Some(value), low: None, high: None, reason: None }
    }

    pub fn undefined(reason: &str) -> Self {
        Self { value: None, low: None, high: None, reason: Some(reason.to_owned()) }
    }

    /// In words.
    pub fn said(&self) -> String {
        match (self.value, self.low, self.high, &self.reason) {
            (Some(value), Some(low), Some(high), _) => format!("{value} ({low} to {high})"),
            (Some(value), ..) => value.to_string(),
            (None, _, _, reason) => format!("undefined: {}", reason.as_deref().unwrap_or("no reason is given")),
        }
    }
}
