//! An estimate: a number with its interval, or the reason why there is none.

use serde::Serialize;

/// An estimate of type `T` (a number, or a pair for a point of the image).
///
/// Serialises to `{"value": .., "low": .., "high": ..}` or `{"undefined": "reason"}`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value<T = f64> {
    /// A value and its interval, of 95 % where nothing else is said; all are finite.
    Known {
        /// Best value.
        value: T,
        /// Lower end of the interval.
        low: T,
        /// Upper end of the interval.
        high: T,
    },
    /// No value.
    Undefined {
        /// Why there is none.
        #[serde(rename = "undefined")]
        reason: String,
    },
}

impl<T> Value<T> {
    /// No value, for the given reason.
    pub fn undefined(reason: impl Into<String>) -> Self {
        Self::Undefined { reason: reason.into() }
    }

    /// The best value, if there is one.
    pub fn best(&self) -> Option<&T> {
        match self {
            Self::Known { value, .. } => Some(value),
            Self::Undefined { .. } => None,
        }
    }
}

impl Value<f64> {
    /// A value with its interval; undefined where one of them is not finite.
    pub fn known(value: f64, low: f64, high: f64) -> Self {
        if [value, low, high].iter().all(|v| v.is_finite()) {
            Self::Known { value, low, high }
        } else {
            Self::undefined("the arithmetic overflows")
        }
    }

    /// The value and its interval times a positive factor, such as a unit or a scale.
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Known { value, low, high } => Self::known(value * factor, low * factor, high * factor),
            Self::Undefined { .. } => self.clone(),
        }
    }
}

impl Value<[f64; 2]> {
    /// One coordinate of a point: 0 for the column, anything else for the row.
    pub fn axis(&self, axis: usize) -> Value {
        let pick = |[column, row]: &[f64; 2]| if axis == 0 { *column } else { *row };
        match self {
            Self::Known { value, low, high } => Value::known(pick(value), pick(low), pick(high)),
            Self::Undefined { reason } => Value::undefined(reason.clone()),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn json_is_value_low_high_or_undefined_with_the_reason() {
        let known = serde_json::to_string(&Value::known(2.0, 1.0, 4.0)).unwrap();
        assert_eq!(known, r#"{"value":2.0,"low":1.0,"high":4.0}"#);
        let none = serde_json::to_string(&Value::<f64>::undefined("blank image")).unwrap();
        assert_eq!(none, r#"{"undefined":"blank image"}"#);
        let point = Value::Known { value: [1.0, 2.0], low: [0.0, 1.0], high: [2.0, 3.0] };
        assert_eq!(serde_json::to_string(&point).unwrap(), r#"{"value":[1.0,2.0],"low":[0.0,1.0],"high":[2.0,3.0]}"#);
    }

    #[test]
    fn what_is_not_finite_is_undefined() {
        assert_eq!(Value::known(f64::NAN, 0.0, 1.0).best(), None);
        assert_eq!(Value::known(1.0, 0.0, f64::INFINITY).best(), None);
        assert_eq!(Value::known(1e308, 0.0, 1e308).scaled(1e3).best(), None);
    }
}
