//! What a test of one light against another starts from, and the ratio of both.

use serde::{Serialize, Serializer};

/// Contributions of light a cell needs in each film to be tested by itself.
pub const MIN_CONTRIBUTIONS: f64 = 100.0;

/// Relative rounding of a radiance computed in f32: a path multiplies some tens of factors, each off by up to an ulp
/// of 2^-23.
pub const ROUNDING: f64 = 1.0 / 262_144.0;

/// A ratio of two means and its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratio {
    /// The ratio.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// As a number, or as the reason why there is none.
pub(super) fn or_undefined<T: Serialize, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Some(value) => value.serialize(serializer),
        None => serializer.collect_map([("undefined", "too little light to test")]),
    }
}
