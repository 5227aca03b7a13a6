//! Keys of a scene set by hand: `stack.layer[0].n=1.42`.

use super::{KeyPath, Scalar, kinds};
use crate::scene::{Invalid, Loaded, LoadedScan, LoadedScene, SceneError, at_its_place, parse, parse_scan};
use std::path::Path;
use std::str::FromStr;

/// A key and the value that it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Set {
    /// The key.
    pub key: KeyPath,
    /// Its value: a number, a text or a flag; a list or a table in the place of one.
    pub value: toml::Value,
}

impl FromStr for Set {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match key_and_value(text) {
            Some((key, value)) if !value.is_empty() => Ok(Self { key: key.parse()?, value: value_of(value)? }),
            _ => Err("it must be KEY=VALUE, as in stack.layer[0].n=1.42".into()),
        }
    }
}

/// What stands before and after the first `=` that is in no quotes.
pub(crate) fn key_and_value(text: &str) -> Option<(&str, &str)> {
    let mut quoted = false;
    let at = text.find(|letter| {
        quoted ^= letter == '"';
        letter == '=' && !quoted
    })?;
    Some((text[..at].trim(), text[at + 1..].trim()))
}

/// A number, a word or a flag; a list or a table as TOML writes them.
fn value_of(text: &str) -> Result<toml::Value, String> {
    if !text.starts_with(['[', '{']) {
        return Ok(Scalar::of_cell(text).to_toml());
    }
    let read = format!("value = {text}").parse::<toml::Table>();
    let value = read.ok().filter(|table| table.len() == 1).and_then(|mut table| table.remove("value"));
    value.ok_or_else(|| format!("{text} is no list or table of TOML, as in [1.0, 2.0] or {{ kind = \"clear\" }}"))
}

/// A scene with keys set; `file` is the one it came from. Its text is then the changed one.
///
/// # Errors
/// A key that leads nowhere, a scene that breaks a rule.
pub fn with(loaded: LoadedScene, file: &Path, sets: &[Set]) -> Result<LoadedScene, SceneError> {
    changed(loaded, file, sets, parse)
}

/// The same of a scan scene.
///
/// # Errors
/// As [`with`].
pub fn with_scan(loaded: LoadedScan, file: &Path, sets: &[Set]) -> Result<LoadedScan, SceneError> {
    changed(loaded, file, sets, parse_scan)
}

fn changed<S>(
    loaded: Loaded<S>,
    file: &Path,
    sets: &[Set],
    parse: impl FnOnce(&str, &Path) -> Result<Loaded<S>, SceneError>,
) -> Result<Loaded<S>, SceneError> {
    if sets.is_empty() {
        return Ok(loaded);
    }
    let at = |key: &str, why: String| at_its_place(&loaded.text, file, &Invalid::new(key, why));
    let document = loaded.text.parse::<toml_edit::DocumentMut>();
    let mut document = document.map_err(|error| at("", error.to_string()))?;
    for Set { key, value } in sets {
        key.set(document.as_item_mut(), value).map_err(|why| at(&key.to_string(), why))?;
    }
    kinds::leave_strangers_out(&mut document, &loaded.text, sets.iter().map(|set| &set.key));
    let files = loaded.files.clone();
    Ok(Loaded { files, ..parse(&document.to_string(), file)? })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::preset;

    #[test]
    fn keys_are_set_and_checked() {
        let set = |text: &str| with(preset("contact-disc").unwrap(), Path::new("disc.toml"), &[text.parse().unwrap()]);
        let loaded = set("stack.layer[0].n = 1.42").unwrap();
        assert_eq!(loaded.scene.stack.layer[0].n, Some(1.42));
        assert_ne!(loaded.identity(), preset("contact-disc").unwrap().identity());
        let error = set("stack.layer[0].n=-1").unwrap_err();
        assert_eq!(error.key.as_deref(), Some("stack.layer[0].n"));
        assert!(set("stack.layer[7].n=1").unwrap_err().to_string().contains("elements"));
        assert!(set("stack.layer[0].m=1").unwrap_err().message.contains("unknown key"));
        let loaded = set("camera.pixels=[20, 10]").unwrap();
        assert_eq!(loaded.scene.camera.pixels, [20, 10]);
        let loaded = set("stack.walls = { kind = \"clear\" }").unwrap();
        assert_eq!(loaded.scene.stack.walls, crate::scene::Walls::Clear);
        assert_eq!(set("description=a = b").unwrap().scene.description, "a = b");
        for bad in ["", "a", "a=", "=1", "a..b=1", "a=[1", "a=[1]\nb = 2", "a={}}"] {
            assert!(bad.parse::<Set>().is_err(), "{bad}");
        }
    }
}
