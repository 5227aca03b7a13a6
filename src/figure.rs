//! A figure, or the reason why there is none; how one is written.

use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeSet;

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

/// How many significant digits numbers are written with: three, or as many as write some values out, seven at most;
/// else as many as tell them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Digits(usize);

impl Digits {
    /// As many as write these out, or tell them apart.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().collect();
        let count = |texts: &mut dyn Iterator<Item = String>| texts.collect::<BTreeSet<_>>().len();
        let all = count(&mut values.iter().map(ToString::to_string));
        let tell = |digits: &usize| count(&mut values.iter().map(|value| Self(*digits).written(*value))) == all;
        // But for the rounding of an axis' steps.
        let is_told =
            |text: &str, value: f64| text.parse::<f64>().is_ok_and(|told| (told - value).abs() <= 1e-12 * value.abs());
        let out = |digits: &usize| values.iter().all(|value| is_told(&Self(*digits).written(*value), *value));
        Self((3..8).find(|digits| tell(digits) && out(digits)).or_else(|| (3..17).find(tell)).unwrap_or(17))
    }

    /// A number with so many.
    pub fn written(self, value: f64) -> String {
        let rounded = format!("{value:.*e}", self.0 - 1).parse().unwrap_or(value);
        if self.0 == 3 { three_digits(value) } else { f64::to_string(&rounded) }
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
    fn digits_tell_values_apart_and_are_no_more_than_that() {
        let grid = || (0..7).map(|k| 1.4 + 0.005 * f64::from(k));
        let digits = Digits::of(grid());
        let texts: Vec<String> = grid().map(|value| digits.written(value)).collect();
        assert_eq!(texts, ["1.4", "1.405", "1.41", "1.415", "1.42", "1.425", "1.43"]);
        let steps = [1.405, 1.405 + 3.0 * 0.01];
        assert_eq!(steps.map(|value| Digits::of(steps).written(value)), ["1.405", "1.435"]);
        assert_eq!(Digits::of([1_048_577.0]).written(1_048_577.0), "1048577");
        assert_eq!(Digits::of([120.0, 5.0, 5.0]).written(0.123_45), "0.123");
        assert_ne!(Digits::of([1.0, 1.0 + f64::EPSILON]).written(1.0 + f64::EPSILON), "1");
        assert_eq!(Digits::of([]), Digits(3));
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
