//! `compare --exact` and `--tolerance`: pixel by pixel, whatever the noise.

use super::super::flags::not_negative;
use crate::film::Film;
use crate::film::compare::{CompareError, Deviations, Tolerance, deviations};
use clap::Args;
use serde_json::{Value, json};
use std::fmt::Write;

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
        let first = match found.first {
            Some(first) => json!(first),
            None => json!({"undefined": "nothing differs"}),
        };
        let json = json!({
            "passed": found.passed,
            "allowed": found.tolerance.map_or_else(|| json!("not a bit"), |tolerance| json!(tolerance)),
            "pixels": found.pixels,
            "outside": found.outside,
            "first": first,
            "largest_relative": found.largest_relative,
            "largest_absolute": found.largest_absolute,
        });
        Ok((found.passed, json, text(&found)))
    }
}

fn text(found: &Deviations) -> String {
    let allowed = match found.tolerance {
        None => "not a bit may differ".to_owned(),
        Some(Tolerance { relative, absolute }) => {
            format!("pixels may differ by {relative} of their light or by {absolute}")
        }
    };
    let verdict = if found.passed { "same" } else { "DIFFERENT" };
    let mut text = format!("{verdict} ({allowed})\n");
    if let Some(first) = found.first {
        let (outside, pixels) = (found.outside, found.pixels);
        let of = if found.tolerance.is_some() { "pixels" } else { "means and variances" };
        let values = if found.tolerance.is_some() { pixels } else { 2 * pixels };
        let _ = writeln!(
            text,
            "{outside} of {values} {of} differ; the first: {} in row {}, column {}, A {:e}, B {:e}",
            first.channel, first.row, first.column, first.a, first.b
        );
    }
    let (relative, absolute) = (found.largest_relative, found.largest_absolute);
    let _ = writeln!(text, "largest deviation of a mean: {relative:.3e} of its light, {absolute:.3e} W/(m^2 sr)");
    text
}
