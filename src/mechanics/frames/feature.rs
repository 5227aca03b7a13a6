//! A number that may not exist.

use serde::Serialize;

/// A feature of a frame, or the reason why the frame has none.
///
/// Serialises to a number or `{"undefined": "reason"}`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Feature {
    /// Its value, finite, in the unit that the field's name gives.
    Known(f64),
    /// No value.
    Undefined {
        /// Why there is none.
        #[serde(rename = "undefined")]
        reason: &'static str,
    },
}

impl Feature {
    /// A value; undefined where it is not finite.
    pub fn known(value: f64) -> Self {
        if value.is_finite() { Self::Known(value) } else { Self::undefined("the arithmetic overflows") }
    }

    /// No value, for the given reason.
    pub fn undefined(reason: &'static str) -> Self {
        Self::Undefined { reason }
    }

    /// The value, if there is one.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Known(value) => Some(*value),
            Self::Undefined { .. } => None,
        }
    }

    /// Why there is no value, if there is none.
    pub fn reason(&self) -> Option<&'static str> {
        match self {
            Self::Known(_) => None,
            Self::Undefined { reason } => Some(reason),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn json_is_a_number_or_undefined_with_the_reason() {
        assert_eq!(serde_json::to_string(&Feature::known(2.5)).unwrap(), "2.5");
        let none = serde_json::to_string(&Feature::undefined("no contact")).unwrap();
        assert_eq!(none, r#"{"undefined":"no contact"}"#);
        assert_eq!(Feature::known(f64::NAN).reason(), Some("the arithmetic overflows"));
    }
}
