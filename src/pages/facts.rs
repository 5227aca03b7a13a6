//! The figures of a shot in words, for the terminal and the report.

use crate::estimate::Value as Estimate;
pub use crate::figure::three_digits as figure;
use crate::film::RADIANCE_UNIT;
use crate::mechanics::press::PressStep;
use crate::pipeline::{Shot, segments_per_second};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What a report says of its scene, so that whoever has the files can tell: name and value.
pub fn scene_rows(name: &str, sha256: &str, inputs: &BTreeMap<PathBuf, String>) -> Vec<(String, String)> {
    let own = [("scene".to_owned(), name.to_owned()), ("scene's SHA-256".to_owned(), sha256.to_owned())];
    let named = inputs.iter().map(|(file, sha256)| (format!("{}'s SHA-256", file.display()), sha256.clone()));
    own.into_iter().chain(named).collect()
}

/// The program's version, as name and value.
pub fn version() -> (String, String) {
    ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned())
}

/// Name and value of what was computed, in reading order.
pub fn facts(shot: &Shot) -> Vec<(String, String)> {
    let outcome = &shot.outcome;
    let fact = |name: &str, value: String| (name.to_owned(), value);
    vec![
        fact("computed on", format!("{} ({})", outcome.adapter, outcome.backend)),
        fact("integrator", format!("{}: {}", outcome.plan.integrator.name(), outcome.plan.why)),
        fact(
            "samples",
            format!(
                "{} a pixel, {} paths, {} photons{}, {} replicates, seed {}",
                outcome.spp,
                figure(outcome.paths as f64),
                figure(outcome.photons as f64),
                mirrored(shot),
                outcome.film.replicates,
                shot.prepared.streams.seed
            ),
        ),
        fact(
            "time",
            format!(
                "{} s, {} s to set up; {} segments a second",
                figure(outcome.seconds),
                figure(outcome.setup_seconds),
                figure(segments_per_second(outcome))
            ),
        ),
        fact("mean radiance", mean_radiance(shot)),
        fact("camera", camera(shot)),
    ]
}

/// For how many places each photon of the map counts.
fn mirrored(shot: &Shot) -> String {
    match (shot.outcome.smoothing, shot.prepared.model.symmetry.order()) {
        (Some(_), order @ 2..) => format!(" (each for {order} mirror images)"),
        _ => String::new(),
    }
}

/// Edge of the blocks whose error is told beside that of a pixel.
const AREA_PIXELS: u32 = 16;

/// Mean radiance with its error, or how dark a dark image is.
pub fn mean_radiance(shot: &Shot) -> String {
    let outcome = &shot.outcome;
    match (outcome.unseen.mean_below, outcome.relative_error) {
        (Some(_), _) if outcome.unseen.known_dark.is_some() => {
            format!("0: {}", outcome.unseen.known_dark.unwrap_or_default())
        }
        (Some(bound), _) => {
            format!("0: no path found light (below {} {RADIANCE_UNIT} with 95 % confidence)", figure(bound))
        }
        (None, Some(error)) => {
            let blocks = outcome.block_errors().into_iter().find(|(edge, _)| *edge == AREA_PIXELS);
            let area = blocks.and_then(|(edge, error)| {
                error.map(|error| format!(", of {edge} x {edge} pixels {} %", figure(100.0 * error)))
            });
            format!(
                "{} {RADIANCE_UNIT}; relative error of a lit pixel {} %{}",
                figure(outcome.mean_radiance),
                figure(100.0 * error),
                area.unwrap_or_default()
            )
        }
        (None, None) => format!("{} {RADIANCE_UNIT}", figure(outcome.mean_radiance)),
    }
}

fn camera(shot: &Shot) -> String {
    let saturated = match shot.frame.saturated_pixels() {
        0 => String::new(),
        count => format!(", {count} pixels saturated"),
    };
    format!(
        "{} x {} pixels, {} mm each; brightest grey level {} of {}{saturated}",
        shot.frame.width,
        shot.frame.height,
        figure(shot.mm_per_pixel),
        shot.frame.max_grey(),
        shot.frame.top_grey()
    )
}

/// Where the light went, in per cent of what the LEDs emit, without what is nothing.
pub fn ledger(shot: &Shot) -> String {
    let ledger = &shot.outcome.ledger;
    let parts = [
        ("absorbed", ledger.absorbed),
        ("out at the touched side", ledger.escaped_top),
        ("out below", ledger.escaped_bottom),
        ("out at the side walls", ledger.escaped_sides),
        ("into the lens", ledger.detected),
        ("cut off", ledger.terminated),
    ];
    let said = parts.iter().filter(|(_, share)| *share != 0.0);
    let said: Vec<String> = said.map(|(name, share)| format!("{} % {name}", figure(100.0 * share))).collect();
    format!("{} (residual {})", said.join(", "), figure(ledger.residual))
}

/// A value with its 95 % interval, or why there is none.
pub fn said(value: &Estimate, unit: &str) -> String {
    said_within(value, unit, "95 %")
}

/// A value with its interval and what that is, or why there is none.
pub fn said_within(value: &Estimate, unit: &str, what: &str) -> String {
    match value {
        Estimate::Known { value, low, high } => {
            let (value, range) = interval(*value, *low, *high);
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            format!("{value}{unit} ({what}: {range})")
        }
        Estimate::Undefined { reason } => format!("undefined: {reason}"),
    }
}

/// Rows of name and value, the values aligned.
pub fn columns(rows: &[(String, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    rows.iter().map(|(name, value)| format!("  {name:width$}  {value}\n")).collect()
}

/// A value and its interval with two digits of the interval's half width.
pub fn interval(value: f64, low: f64, high: f64) -> (String, String) {
    let half_width = 0.5 * (high - low);
    // Below that, so many decimals would be all zeros.
    let decimals = match half_width > 1e-8 {
        true => (1.0 - half_width.log10().floor()).clamp(0.0, 9.0) as usize,
        false => return (figure(value), format!("{} to {}", figure(low), figure(high))),
    };
    let text = |value: f64| {
        let text = format!("{value:.decimals$}");
        // What rounds to zero has no sign.
        let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
        if is_zero { text.trim_start_matches('-').to_owned() } else { text }
    };
    (text(value), format!("{} to {}", text(low), text(high)))
}

/// A load in words.
pub fn load_name(step: &PressStep) -> String {
    let mut name = format!("{} mm", figure(step.depth_mm));
    let [x, y] = step.slide_mm;
    match [x != 0.0, y != 0.0] {
        [false, false] => {}
        [true, false] => name += &format!(", slid by {} mm", figure(x)),
        [false, true] => name += &format!(", slid by {} mm along y", figure(y)),
        [true, true] => name += &format!(", slid by {} and {} mm", figure(x), figure(y)),
    }
    if step.hold_s > 0.0 {
        name += &format!(", held {} s", figure(step.hold_s));
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_show_the_digits_they_support() {
        let both = |v, l, h| {
            let (value, range) = interval(v, l, h);
            format!("{value} ({range})")
        };
        assert_eq!(both(128.123, 127.9, 128.4), "128.12 (127.90 to 128.40)");
        assert_eq!(both(2_331_640.4, 2_330_750.0, 2_332_530.0), "2331640 (2330750 to 2332530)");
        assert_eq!(both(5.0, 5.0, 5.0), "5 (5 to 5)");
        assert_eq!(both(0.0, 0.0, 0.003_68), "0.0000 (0.0000 to 0.0037)");
        assert_eq!(both(3e-12, 2e-12, 4e-12), "3.00e-12 (2.00e-12 to 4.00e-12)");
        assert_eq!(both(1.0, -0.01, 2.01), "1.0 (0.0 to 2.0)");
    }

    #[test]
    fn columns_align_their_values() {
        let rows = [("a".to_owned(), "1".to_owned()), ("bcd".to_owned(), "2".to_owned())];
        assert_eq!(columns(&rows), "  a    1\n  bcd  2\n");
    }
}
