//! The numbers of a scene, each with a range to move it in.

use crate::scene::LoadedScene;
use crate::vary::{self, KeyPath, Set};
use serde::Serialize;
use serde_json::Value;
use std::path::Path;
use std::str::FromStr;

/// Numbers that a look at a sensor begins with, by the ending of their keys.
const USUAL: [&str; 7] = [
    ".n",
    "shape.diameter_mm",
    "inclusion[0].depth_mm",
    "inclusion[0].material.youngs_kpa",
    "phantom.material.youngs_kpa",
    "power_mw",
    "exposure_ms",
];

/// A numeric key of a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Knob {
    /// Its path.
    pub key: String,
    /// What the scene has.
    pub value: f64,
    /// The range to move it in; the scene's own rules may be narrower.
    pub from: f64,
    /// Its end.
    pub to: f64,
    /// Whether it takes whole numbers alone.
    pub whole: bool,
    /// Whether it is shown before the others.
    pub first: bool,
}

/// A key and the range to move it in: `KEY` or `KEY=FROM:TO`.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// The key.
    pub key: KeyPath,
    /// The range, where one is given.
    pub range: Option<[f64; 2]>,
}

impl FromStr for Span {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "it must be KEY or KEY=FROM:TO with FROM below TO, as in stack.layer[0].n=1.40:1.45".to_owned();
        let Some((key, range)) = text.rsplit_once('=') else {
            return Ok(Self { key: text.trim().parse()?, range: None });
        };
        let (from, to) = range.split_once(':').ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
        match (number(from), number(to)) {
            (Some(from), Some(to)) if from < to => Ok(Self { key: key.trim().parse()?, range: Some([from, to]) }),
            _ => Err(wrong()),
        }
    }
}

impl Knob {
    /// All numbers of a scene that can be set. Those of `spans` come first, or else the usual ones of a sensor.
    ///
    /// # Errors
    /// One line for a span whose key is no number of the scene.
    pub fn of(loaded: &LoadedScene, file: &Path, spans: &[Span]) -> Result<Vec<Self>, String> {
        let scene = serde_json::to_value(&loaded.scene).map_err(|error| error.to_string())?;
        let mut numbers = Vec::new();
        collect(&scene, String::new(), &mut numbers);
        // The image is that of the last load.
        let depths = loaded.scene.press.as_ref().and_then(|press| press.depths_mm.as_ref());
        let last = depths.map(|depths| format!("press.depths_mm[{}]", depths.len().saturating_sub(1)));
        let is_usual = |key: &str| USUAL.iter().any(|usual| key.ends_with(usual)) || last.as_deref() == Some(key);
        let mut knobs: Vec<Self> = numbers
            .into_iter()
            .filter(|(key, value, _)| is_settable(loaded, file, key, *value))
            .map(|(key, value, whole)| {
                let [from, to] = range(&key, value, whole);
                let first = spans.is_empty() && is_usual(&key);
                Self { key, value, from, to, whole, first }
            })
            .collect();
        for span in spans {
            let key = span.key.to_string();
            let knob = knobs.iter_mut().find(|knob| knob.key == key).ok_or_else(|| {
                format!("{key}: no number of the scene; a key is as in stack.layer[0].n, and has a value in the scene")
            })?;
            knob.first = true;
            if let Some([from, to]) = span.range {
                (knob.from, knob.to) = (from, to);
            }
        }
        Ok(knobs)
    }
}

/// The numbers below a value, with their keys.
fn collect(value: &Value, key: String, numbers: &mut Vec<(String, f64, bool)>) {
    match value {
        Value::Number(number) => {
            numbers.extend(number.as_f64().map(|value| (key, value, number.is_u64() || number.is_i64())));
        }
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(k, value)| collect(value, format!("{key}[{k}]"), numbers));
        }
        Value::Object(table) => {
            let dot = if key.is_empty() { "" } else { "." };
            table.iter().for_each(|(name, value)| collect(value, format!("{key}{dot}{name}"), numbers));
        }
        _ => {}
    }
}

/// Whether the scene's file has a place for the key: a list that it leaves to its default has none.
fn is_settable(loaded: &LoadedScene, file: &Path, key: &str, value: f64) -> bool {
    let Ok(key) = key.parse() else { return false };
    vary::with(loaded.clone(), file, &[Set { key, value: value.into() }]).is_ok()
}

/// Where a number is moved by itself.
fn range(key: &str, value: f64, whole: bool) -> [f64; 2] {
    let is_index = key.ends_with(".n") || key.ends_with("_n");
    match value {
        // Indices of refraction: what silicones, glasses and tissue have.
        value if is_index => [(value - 0.1).max(1.0), value + 0.1],
        0.0 if key.ends_with("_deg") => [-5.0, 5.0],
        0.0 if key.ends_with("_mm") => [-5.0, 5.0],
        0.0 if whole => [0.0, 16.0],
        0.0 => [0.0, 1.0],
        value if value < 0.0 => [2.0 * value, 0.0],
        value if whole => [1.0, 2.0 * value],
        value => [0.25 * value, 2.0 * value],
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::preset;

    fn knobs(spans: &[&str]) -> Result<Vec<Knob>, String> {
        let spans: Vec<Span> = spans.iter().map(|span| span.parse().unwrap()).collect();
        Knob::of(&preset("phantom-size-8mm").unwrap(), Path::new("phantom-size-8mm.toml"), &spans)
    }

    #[test]
    fn every_number_is_there_with_a_range_around_it() {
        let knobs = knobs(&[]).unwrap();
        let knob = |key: &str| knobs.iter().find(|knob| knob.key == key).unwrap();
        assert_eq!(knob("stack.layer[0].n").value, 1.41);
        assert_eq!(knob("phantom.inclusion[0].shape.diameter_mm").value, 8.0);
        assert!(knob("phantom.inclusion[0].shape.diameter_mm").first && !knob("light.wavelength_nm").first);
        assert!(knob("press.depths_mm[2]").first && !knob("press.depths_mm[0]").first);
        assert!(knob("camera.pixels[0]").whole && !knob("led[0].power_mw").whole);
        assert_eq!(knob("press.depths_mm[2]").value, 4.0);
        for Knob { key, value, from, to, .. } in &knobs {
            assert!(from < to && from <= value && value <= to, "{key}: {value} in {from} to {to}");
        }
    }

    #[test]
    fn a_span_has_its_range_and_comes_first_alone() {
        let knobs = knobs(&["stack.layer[0].n=1.38:1.45", "led[2].power_mw"]).unwrap();
        let first: Vec<_> = knobs.iter().filter(|knob| knob.first).map(|knob| knob.key.as_str()).collect();
        assert_eq!(first, ["led[2].power_mw", "stack.layer[0].n"]);
        let n = knobs.iter().find(|knob| knob.key == "stack.layer[0].n").unwrap();
        assert_eq!([n.from, n.to], [1.38, 1.45]);
    }

    #[test]
    fn spans_that_make_no_sense_are_refused() {
        for bad in ["a=1", "a=2:1", "a=1:1", "a=x:2", "a=1:inf", "=1:2", ""] {
            assert!(bad.parse::<Span>().is_err(), "{bad}");
        }
        assert!(knobs(&["stack.layer[9].n"]).unwrap_err().contains("no number of the scene"));
        assert!(knobs(&["camera.lens.kind"]).is_err());
    }
}
