//! What is said of the bounds of a protocol.

use super::facts::{figure, interval};
use crate::calibrate::{Bounds, CalibrateError, FrameModel, Inclusion, Limits, Protocol};
use crate::estimate::Value;
use crate::figure::Figure;
use serde::Serialize;

/// Bounds for one inclusion: of the frames, and with the calibration's own error.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The inclusion.
    #[serde(flatten)]
    pub inclusion: Inclusion,
    /// Of the frames.
    pub frames: Figure<Bounds>,
    /// With the calibration's error.
    pub calibrated: Figure<Bounds>,
}

/// Bounds by a calibration, for inclusions over its range; none where `go_on` says no.
///
/// # Errors
/// A calibration that is damaged.
pub fn rows(
    model: &FrameModel,
    protocol: &Protocol,
    go_on: &dyn Fn() -> bool,
) -> Result<Option<Vec<Row>>, CalibrateError> {
    let limits = Limits::of(model)?;
    let row = |inclusion: Inclusion| {
        let of = |whole| limits.bounds(&inclusion, protocol, whole).map_or_else(Figure::undefined, Figure::Known);
        go_on().then(|| Row { inclusion, frames: of(false), calibrated: of(true) })
    };
    Ok(model.some_inclusions().into_iter().map(row).collect())
}

/// The table for reading.
pub fn text(rows: &[Row]) -> String {
    let percent = |value: &Value| match value.scaled(100.0) {
        Value::Known { value, low, high } => {
            let (value, range) = interval(value, low, high);
            format!("{value} % ({range})")
        }
        Value::Undefined { reason } => reason,
    };
    let mut lines = vec![
        "Least standard deviations by the calibration's scores; in brackets what its slopes leave open (95 %)."
            .to_owned(),
        format!(
            "{:>8} {:>9} {:>12}   {:24} {:24} {:24}",
            "size, mm", "depth, mm", "modulus, kPa", "size", "depth", "modulus"
        ),
    ];
    lines.extend(rows.iter().map(|row| {
        let inclusion = row.inclusion;
        let [size, depth, youngs] = [inclusion.size_mm, inclusion.depth_mm, inclusion.youngs_kpa].map(figure);
        match &row.frames {
            Figure::Known(bounds) => {
                let [a, b, c] = [&bounds.size, &bounds.depth, &bounds.youngs].map(percent);
                format!("{size:>8} {depth:>9} {youngs:>12}   {a:24} {b:24} {c}")
            }
            Figure::Undefined { reason: why } => format!("{size:>8} {depth:>9} {youngs:>12}   undefined: {why}"),
        }
    }));
    lines.join("\n")
}
