//! Reading a scene file: text, structure, types, rules, and the files it names. The first mistake is the error and
//! carries the others of its stage: what the types are is not asked before the structure is right, nor a rule before
//! the types are.

use super::data_file::read_limited;
use super::error::SceneError;
use super::inputs::{Inputs, sha256};
use super::locate::{line_at, line_of};
use super::{Invalid, ScanScene, Scene, schema, structure, validate};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, Deserializer};

/// Largest scene file, bytes. The presets are below 4 KiB; a file of this size is not a scene.
const MAX_BYTES: u64 = 1 << 20;

/// A valid scene of one of the two kinds, and where it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded<S> {
    /// The scene.
    pub scene: S,
    /// The files that the scene names, relative to its folder.
    pub files: Inputs,
    /// The file's text.
    pub text: String,
    /// SHA-256 of the file's bytes, in hexadecimal.
    pub sha256: String,
}

/// A valid scene of a sensor.
pub type LoadedScene = Loaded<Scene>;

/// A valid scan scene.
pub type LoadedScan = Loaded<ScanScene>;

impl LoadedScene {
    /// What tells the scene from others: the SHA-256 of its file, or one of the scene itself where that has been
    /// changed since it was read; with those of the files that it names, where it names some.
    #[must_use]
    pub fn identity(&self) -> String {
        let as_read = parse(&self.text, Path::new("")).is_ok_and(|read| read.scene == self.scene);
        let own = match serde_json::to_vec(&self.scene) {
            Ok(bytes) if !as_read => sha256(&bytes),
            _ => self.sha256.clone(),
        };
        let inputs = self.inputs();
        match inputs.is_empty() {
            true => own,
            false => sha256(format!("{own}{inputs:?}").as_bytes()),
        }
    }

    /// SHA-256 of each file that the scene names, by the name as written; those that cannot be read are left out.
    pub fn inputs(&self) -> BTreeMap<PathBuf, String> {
        self.files.hashes(self.scene.files().into_iter().map(|(_, file)| file))
    }
}

impl LoadedScan {
    /// As [`LoadedScene::inputs`].
    pub fn inputs(&self) -> BTreeMap<PathBuf, String> {
        self.files.hashes(self.scene.files().into_iter().map(|(_, file)| file))
    }
}

/// Reads a scene file.
///
/// # Errors
/// When the file cannot be read, is no scene, breaks a rule, or names a file that does not exist.
pub fn load(path: &Path) -> Result<LoadedScene, SceneError> {
    let text = read_text(path)?;
    let mut loaded = parse(&text, path)?;
    read_named(&text, path, &mut loaded.files, loaded.scene.files())?;
    Ok(loaded)
}

/// Reads a scene file without looking at the files that it names, which may lie elsewhere: for its camera.
///
/// # Errors
/// As [`load`], but for those files.
pub fn load_alone(path: &Path) -> Result<LoadedScene, SceneError> {
    parse(&read_text(path)?, path)
}

/// Reads a scan scene file.
///
/// # Errors
/// As [`load`].
pub fn load_scan(path: &Path) -> Result<LoadedScan, SceneError> {
    let text = read_text(path)?;
    let mut loaded = parse_scan(&text, path)?;
    read_named(&text, path, &mut loaded.files, loaded.scene.files())?;
    Ok(loaded)
}

/// The text of a file of this program's.
pub(crate) fn read_text(path: &Path) -> Result<String, SceneError> {
    let bytes = read_limited(path, MAX_BYTES).map_err(|error| {
        SceneError::of_file(
            error.kind,
            path,
            format!("{}; scenes, sweeps and studies are TOML files of some kilobytes", error.message),
        )
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes().iter().take(valid).filter(|&&byte| byte == b'\n').count();
        SceneError::of_file("not_utf8", path, "is not UTF-8; save it as UTF-8 text").at(Some(line), None)
    })
}

/// Reads the files that a scene names; one that is missing is a mistake of the scene.
fn read_named(text: &str, path: &Path, inputs: &mut Inputs, files: Vec<(String, &Path)>) -> Result<(), SceneError> {
    let missing = |(key, named): &(String, &Path)| {
        let resolved = inputs.resolve(named);
        let line = || DeTable::parse(text).ok().map(|document| line_of(text, document.get_ref(), key));
        let message =
            format!("names {}, which is not a file; paths are relative to the scene's folder", resolved.display());
        (!resolved.is_file()).then(|| SceneError::of_file("missing_file", path, message).at(line(), Some(key)))
    };
    match SceneError::first_of(files.iter().filter_map(missing).collect()) {
        Some(error) => Err(error),
        None => {
            files.iter().for_each(|(_, named)| inputs.keep(named));
            Ok(())
        }
    }
}

/// Reads a scene from its text; `origin` is the file it came from, for messages and relative paths.
///
/// The files that the scene names are not looked at: they are read when they are needed, where [`Inputs::insert`] has
/// not given them.
///
/// # Errors
/// When the text is no scene or breaks a rule.
pub fn parse(text: &str, origin: &Path) -> Result<LoadedScene, SceneError> {
    parse_file(text, origin, &schema::schema(), validate::validate).map_err(|error| match error.key.as_deref() {
        Some("scan") if error.kind == "unknown_key" => {
            let message = "makes this a scan scene, which frames takes; here a scene of a sensor is needed".to_owned();
            SceneError { message, ..error }
        }
        _ => error,
    })
}

/// Reads a scan scene from its text, as [`parse`].
///
/// # Errors
/// When the text is no scan scene or breaks a rule.
pub fn parse_scan(text: &str, origin: &Path) -> Result<LoadedScan, SceneError> {
    parse_file(text, origin, &schema::scan_schema(), validate::validate_scan)
}

/// A broken rule at its place in a file.
pub(crate) fn at_its_place(text: &str, origin: &Path, broken: &Invalid) -> SceneError {
    let place = |one: &Invalid| {
        let line = DeTable::parse(text).ok().map(|document| line_of(text, document.get_ref(), &one.key));
        SceneError::of_file("invalid_value", origin, &one.message).at(line, Some(&one.key))
    };
    SceneError { others: broken.others.iter().map(place).collect(), ..place(broken) }
}

/// Reads a file of this program's from its text: structure first, then types, then rules.
pub(crate) fn parse_file<'t, S: Deserialize<'t>>(
    text: &'t str,
    origin: &Path,
    schema: &serde_json::Value,
    rules: fn(&S) -> Result<(), Invalid>,
) -> Result<Loaded<S>, SceneError> {
    let toml_error = |kind: &'static str, error: &toml::de::Error| {
        let line = error.span().map(|span| line_at(text, span.start));
        SceneError::of_file(kind, origin, error.message()).at(line, None)
    };
    let document = DeTable::parse(text).map_err(|error| toml_error("syntax", &error))?;
    let at_key = |kind: &'static str, key: &str, message: &str| {
        let line = line_of(text, document.get_ref(), key);
        SceneError::of_file(kind, origin, message).at(Some(line), Some(key))
    };
    let faults = structure::faults(document.get_ref(), schema);
    let faults = faults.iter().map(|fault| at_key(fault.kind, &fault.key, &fault.message)).collect();
    if let Some(error) = SceneError::first_of(faults) {
        return Err(error);
    }
    let scene = S::deserialize(Deserializer::from(document.clone())).map_err(|error| toml_error("syntax", &error))?;
    rules(&scene).map_err(|broken| at_its_place(text, origin, &broken))?;
    Ok(Loaded {
        scene,
        files: Inputs::of_folder(origin.parent().unwrap_or(Path::new(""))),
        text: text.to_owned(),
        sha256: sha256(text.as_bytes()),
    })
}

#[cfg(test)]
#[path = "load_tests.rs"]
mod tests;
