//! `compare --exact` and `--tolerance`: pixel by pixel, whatever the noise.

use super::super::flags::not_negative;
use crate::film::Film;
use crate::film::compare::{CompareError, Tolerance, deviations};
use crate::pages::comparison;
use clap::Args;
use serde_json::Value;

/// How far pixels may be apart, if that is asked for in place of the statistics.
#[derive(Debug, Args)]
pub(super) struct Strict {
    /// Not a bit may differ, in means and variances; no statistics.
    #[arg(long, conflicts_with_all = ["tolerance", "absolute"])]
    exact: bool,
    /// Largest deviation of a pixel's mean, as a share of the larger of both; no statistics.
    #[arg(long, value_name = "E", value_parser = not_negative, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Largest deviation of a pixel's mean, W/(m^2 sr); with --tolerance one of both is enough.
    #[arg(long, value_name = "E", value_parser = not_negative, allow_negative_numbers = true)]
    absolute: Option<f64>,
}

impl Strict {
    /// Whether it is asked for.
    pub fn asked(&self) -> bool {
        self.exact || self.tolerance.is_some() || self.absolute.is_some()
    }

    /// The verdict, as JSON and as text.
    pub fn judge(&self, a: &Film, b: &Film) -> Result<(bool, Value, String), CompareError> {
        let either = Tolerance { relative: self.tolerance.unwrap_or(0.0), absolute: self.absolute.unwrap_or(0.0) };
        let found = deviations(a, b, (!self.exact).then_some(either))?;
        Ok((found.passed, comparison::strict_json(&found), comparison::strict_text(&found)))
    }
}
