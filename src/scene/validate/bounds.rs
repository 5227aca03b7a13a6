//! Ranges of single values, and how a message says them.

use super::Invalid;
use std::ops::{Bound, RangeBounds, RangeInclusive};

/// Above zero.
pub(super) const POSITIVE: (Bound<f64>, Bound<f64>) = (Bound::Excluded(0.0), Bound::Unbounded);

/// Zero or more.
pub(super) const NOT_NEGATIVE: (Bound<f64>, Bound<f64>) = (Bound::Included(0.0), Bound::Unbounded);

/// Any finite number.
pub(super) const ANY: (Bound<f64>, Bound<f64>) = (Bound::Unbounded, Bound::Unbounded);

/// Above the first and up to the second, which is `included` or not.
pub(super) fn above(low: f64, high: f64, included: bool) -> (Bound<f64>, Bound<f64>) {
    (Bound::Excluded(low), if included { Bound::Included(high) } else { Bound::Excluded(high) })
}

/// A finite number in a range, or an error that names the range and an example.
pub(super) fn number(key: &str, value: f64, range: impl RangeBounds<f64>, example: f64) -> Result<(), Invalid> {
    let must = if !value.is_finite() {
        "be a finite number".to_owned()
    } else if !range.contains(&value) {
        format!("be {}", in_words(&range))
    } else {
        return Ok(());
    };
    Err(Invalid::new(key, format!("must {must}, is {value}; for example {example:?}")))
}

/// A whole number in a range, or an error that names the range and an example.
pub(super) fn whole(key: &str, value: u64, range: RangeInclusive<u64>, example: u64) -> Result<(), Invalid> {
    if range.contains(&value) {
        return Ok(());
    }
    let (low, high) = range.into_inner();
    Err(Invalid::new(key, format!("must be from {low} to {high}, is {value}; for example {example}")))
}

fn in_words(range: &impl RangeBounds<f64>) -> String {
    let low = match range.start_bound() {
        Bound::Excluded(low) if *low == 0.0 => Some("positive".to_owned()),
        Bound::Included(low) => Some(format!("at least {low}")),
        Bound::Excluded(low) => Some(format!("above {low}")),
        Bound::Unbounded => None,
    };
    let high = match range.end_bound() {
        Bound::Included(high) => Some(format!("at most {high}")),
        Bound::Excluded(high) => Some(format!("below {high}")),
        Bound::Unbounded => None,
    };
    low.into_iter().chain(high).collect::<Vec<_>>().join(" and ")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_said_in_words() {
        let message = |value, range: (Bound<f64>, Bound<f64>)| number("k", value, range, 2.0).unwrap_err().message;
        assert_eq!(message(-2.0, POSITIVE), "must be positive, is -2; for example 2.0");
        assert_eq!(message(-0.5, NOT_NEGATIVE), "must be at least 0, is -0.5; for example 2.0");
        assert_eq!(message(180.0, above(0.0, 179.0, false)), "must be positive and below 179, is 180; for example 2.0");
        assert_eq!(message(f64::NAN, ANY), "must be a finite number, is NaN; for example 2.0");
        assert_eq!(whole("k", 7, 8..=16, 12).unwrap_err().message, "must be from 8 to 16, is 7; for example 12");
    }

    #[test]
    fn the_ends_of_a_range_belong_to_it_as_said() {
        assert!(number("k", 90.0, above(0.0, 90.0, true), 1.0).is_ok());
        assert!(number("k", 90.0, above(0.0, 90.0, false), 1.0).is_err());
        assert!(number("k", 0.0, above(0.0, 90.0, true), 1.0).is_err());
        assert!(number("k", 0.0, NOT_NEGATIVE, 1.0).is_ok());
    }
}
