//! Sweeps without a file: a grid over a few keys.

use super::file::rules;
use super::{Measure, Settings, Sweep, SweepFile, schema};
use crate::scene::{Invalid, LoadedScene, parse_file};
use crate::vary::{Design, Keys, Range, Scalar, Vary, key_and_value};
use std::path::{Path, PathBuf};

/// A variable of `KEY=VALUE`, `KEY=A,B,C` or `KEY=FROM:TO:POINTS`.
///
/// # Errors
/// What is wrong with the text.
pub fn vary(text: &str) -> Result<Vary, String> {
    let (key, values) = key_and_value(text).ok_or("it must be KEY=VALUES, as in stack.layer[0].n=1.40:1.43:7")?;
    let vary = Vary { key: Some(Keys::One(key.into())), ..Vary::default() };
    let parts: Vec<&str> = values.split(':').map(str::trim).collect();
    if let [from, to, points] = parts[..] {
        let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
        let range = number(from).zip(number(to)).zip(points.parse().ok());
        let ((from, to), points) = range.ok_or("FROM:TO:POINTS must be two numbers and how many values there are")?;
        return Ok(Vary { linear: Some(Range { from, to, points }), ..vary });
    }
    if parts.len() > 1 {
        return Err("a range is FROM:TO:POINTS".into());
    }
    let values = values.split(',').map(str::trim).filter(|value| !value.is_empty());
    if let Some(value) = values.clone().find(|value| value.parse::<f64>().is_ok_and(|number| !number.is_finite())) {
        return Err(format!("{value} is no value of a key"));
    }
    let values: Vec<Scalar> = values.map(Scalar::of_cell).collect();
    match <[Scalar; 1]>::try_from(values) {
        // One value is no axis.
        Ok([only]) => Ok(Vary { fixed: Some(only), ..vary }),
        Err(values) if values.is_empty() => Err("it has no values".into()),
        Err(values) => Ok(Vary { values: Some(values), ..vary }),
    }
}

/// A measure of its kind, with its keys after it: `contrast radius_mm=4 around_mm=[5,7]`.
///
/// # Errors
/// A kind that there is not, a key that it has not.
pub fn measure(text: &str) -> Result<Measure, String> {
    let (kind, keys) = text.trim().split_once(char::is_whitespace).unwrap_or((text.trim(), ""));
    let lines: String = keys.split_whitespace().map(|key| format!("{key}\n")).collect();
    let error = |error: toml::de::Error| error.message().to_owned();
    let mut table: toml::Table = lines.parse().map_err(error)?;
    table.insert("kind".into(), kind.into());
    table.try_into().map_err(error)
}

/// The sweep of a scene over a grid; `scene` is how it was named.
///
/// # Errors
/// As [`Sweep::new`].
pub fn sweep(
    name: String,
    scene: &Path,
    vary: Vec<Vary>,
    measure: Vec<Measure>,
    base: LoadedScene,
    base_file: PathBuf,
) -> Result<Sweep, Invalid> {
    let settings = Settings {
        description: String::new(),
        scene: scene.display().to_string(),
        design: Design::Grid {},
        target_error: None,
        seed: None,
        random_numbers: Default::default(),
        images: None,
    };
    let file = SweepFile { sweep: settings, vary, require: Vec::new(), measure };
    let wrong = |why: String| Invalid::new("sweep", why);
    let text = toml::to_string(&file).map_err(|error| wrong(error.to_string()))?;
    // What no file can hold is refused before a folder is made of it.
    let read = parse_file::<SweepFile>(&text, Path::new(&name), &schema(), rules);
    let file = read.map_err(|error| Invalid::new(error.key.unwrap_or_default(), error.message))?.scene;
    Sweep::new(name, file, text, base, base_file, None)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::preset;

    #[test]
    fn a_sweep_by_hand_is_that_of_a_file() {
        let axes = ["stack.layer[0].n=1.40:1.43:4", "led[*].power_mw=1,2"].map(|text| vary(text).unwrap());
        let measures = ["mean_radiance", "contrast radius_mm=4 around_mm=[5,7]"].map(|text| measure(text).unwrap());
        let base = preset("contact-disc").unwrap();
        let made =
            sweep("s".into(), Path::new("preset:contact-disc"), axes.to_vec(), measures.to_vec(), base, "".into());
        let made = made.unwrap();
        assert_eq!(made.plan.count(), 8);
        assert_eq!(toml::from_str::<SweepFile>(&made.text).unwrap(), made.file);
        assert_eq!(made.plan.names().collect::<Vec<_>>(), ["stack.layer[0].n", "led[*].power_mw"]);
    }

    #[test]
    fn what_is_wrong_is_told() {
        for bad in ["a", "a=", "a=1:2", "a=1:x:3", "a=1:2:3:4"] {
            assert!(vary(bad).is_err(), "{bad}");
        }
        assert!(measure("contrats").unwrap_err().contains("contrats"));
        assert!(measure("contrast size=3").unwrap_err().contains("size"));
        assert!(vary("a=1.4,nan").unwrap_err().contains("nan") && vary("a=inf").is_err());
        let by = |text: &str| {
            let (base, axis) = (preset("contact-disc").unwrap(), vary("stack.layer[0].n=1.4,1.41").unwrap());
            sweep(
                "s".into(),
                Path::new("preset:contact-disc"),
                vec![axis],
                vec![measure(text).unwrap()],
                base,
                "".into(),
            )
        };
        for not_finite in ["unevenness radius_mm=nan", "paper threshold_grey=inf", "contrast center_mm=[nan,0]"] {
            let error = by(not_finite).unwrap_err();
            assert!(error.message.contains("finite"), "{not_finite}: {error}");
        }
        assert!(by("unevenness radius_mm=3").is_ok());
    }
}
