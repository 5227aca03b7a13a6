//! A figure, or the reason why there is none; how one is written.

use serde::Serialize;
use std::borrow::Cow;

/// A figure of type `T`, or the reason why there is none.
///
/// Serialises to the figure or `{"undefined": "reason"}`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Figure<T = f64> {
    /// Its value, finite, in the unit that the field's name gives.
    Known(T),
    /// No value.
    Undefined {
        /// Why there is none.
        #[serde(rename = "undefined")]
        reason: Cow<'static, str>,
    },
}

impl<T> Figure<T> {
    /// No value, for the given reason.
    pub fn undefined(reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Undefined { reason: reason.into() }
    }

    /// The value, or the reason why there is none.
    pub fn of(value: Option<T>, otherwise: impl Into<Cow<'static, str>>) -> Self {
        value.map_or_else(|| Self::undefined(otherwise), Self::Known)
    }

    /// Why there is no value, if there is none.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Known(_) => None,
            Self::Undefined { reason } => Some(reason),
        }
    }
}

impl Figure {
    /// A value; undefined where it is not finite.
    pub fn known(value: f64) -> Self {
        if value.is_finite() { Self::Known(value) } else { Self::undefined("the arithmetic overflows") }
    }

    /// The value, if there is one.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Known(value) => Some(*value),
            Self::Undefined { .. } => None,
        }
    }
}

/// Three significant digits, in powers of ten where that is shorter.
pub fn three_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e6).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let decimals = (2.0 - value.abs().log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn json_is_a_number_or_undefined_with_the_reason() {
        assert_eq!(serde_json::to_string(&Figure::known(2.5)).unwrap(), "2.5");
        let none = serde_json::to_string(&Figure::<f64>::undefined("no contact")).unwrap();
        assert_eq!(none, r#"{"undefined":"no contact"}"#);
        assert_eq!(Figure::known(f64::NAN).reason(), Some("the arithmetic overflows"));
        assert_eq!(Figure::of(Some([1, 2]), "none"), Figure::Known([1, 2]));
    }

    #[test]
    fn figures_have_three_digits() {
        for (value, text) in
            [(0.0, "0"), (1.0, "1"), (0.012_345, "0.0123"), (12.34, "12.3"), (123_456.0, "123456"), (-3e-9, "-3.00e-9")]
        {
            assert_eq!(three_digits(value), text);
        }
    }
}
