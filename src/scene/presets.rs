//! The scenes that come with the program.

use super::error::SceneError;
use super::load::{Loaded, LoadedScan, LoadedScene, load, load_scan, parse, parse_scan, read_text};
use std::path::{Path, PathBuf};

/// Name and text of every preset.
pub const PRESETS: &[(&str, &str)] = &[
    ("tsis-paper", include_str!("../../scenes/tsis-paper.toml")),
    ("tsis-literature", include_str!("../../scenes/tsis-literature.toml")),
    ("tsis-dent", include_str!("../../scenes/tsis-dent.toml")),
    ("press-hertz", include_str!("../../scenes/press-hertz.toml")),
    ("phantom-size-2mm", include_str!("../../scenes/phantom-size-2mm.toml")),
    ("phantom-size-8mm", include_str!("../../scenes/phantom-size-8mm.toml")),
    ("phantom-size-14mm", include_str!("../../scenes/phantom-size-14mm.toml")),
    ("phantom-depth-3mm", include_str!("../../scenes/phantom-depth-3mm.toml")),
    ("phantom-depth-7mm", include_str!("../../scenes/phantom-depth-7mm.toml")),
    ("phantom-depth-11.2mm", include_str!("../../scenes/phantom-depth-11.2mm.toml")),
    ("phantom-stiffness-44.5kpa", include_str!("../../scenes/phantom-stiffness-44.5kpa.toml")),
    ("phantom-stiffness-63.5kpa", include_str!("../../scenes/phantom-stiffness-63.5kpa.toml")),
    ("phantom-stiffness-102.8kpa", include_str!("../../scenes/phantom-stiffness-102.8kpa.toml")),
    ("flat-bonded", include_str!("../../scenes/flat-bonded.toml")),
    ("dent-cap", include_str!("../../scenes/dent-cap.toml")),
    ("contact-disc", include_str!("../../scenes/contact-disc.toml")),
    ("rough", include_str!("../../scenes/rough.toml")),
    ("microfacet", include_str!("../../scenes/microfacet.toml")),
    ("absorbing", include_str!("../../scenes/absorbing.toml")),
];

/// Name and text of every scan scene.
pub const SCAN_PRESETS: &[(&str, &str)] = &[("frames-galea", include_str!("../../scenes/frames-galea.toml"))];

/// A preset by its name.
///
/// # Errors
/// When there is no preset of that name.
pub fn preset(name: &str) -> Result<LoadedScene, SceneError> {
    let (text, file) = find(PRESETS, name, (SCAN_PRESETS, "a scan scene, which frames takes"))?;
    parse(text, &file)
}

/// A scan scene by its name.
///
/// # Errors
/// When there is no scan scene of that name.
pub fn scan_preset(name: &str) -> Result<LoadedScan, SceneError> {
    let others = (PRESETS, "a scene of a sensor, which run, render, press and inspect take");
    let (text, file) = find(SCAN_PRESETS, name, others)?;
    parse_scan(text, &file)
}

/// Before the name of a scene that comes with the program.
const PRESET: &str = "preset:";

/// The scene of a file, or the preset of `preset:NAME`, and the name it goes by in messages.
///
/// # Errors
/// As [`load`] and [`preset`].
pub fn open(source: &Path) -> Result<(LoadedScene, PathBuf), SceneError> {
    open_as(source, PRESETS, preset, load)
}

/// The scan scene of a file, or the preset of `preset:NAME`, and the name it goes by in messages.
///
/// # Errors
/// As [`load_scan`] and [`scan_preset`].
pub fn open_scan(source: &Path) -> Result<(LoadedScan, PathBuf), SceneError> {
    open_as(source, SCAN_PRESETS, scan_preset, load_scan)
}

/// Whether a file, or the preset of `preset:NAME`, is a scene, and nothing else that is written in TOML.
pub fn is_scene(source: &Path) -> bool {
    let is_preset = source.to_str().is_some_and(|source| source.starts_with(PRESET));
    let has_stack = || read_text(source).ok()?.parse::<toml::Table>().ok().map(|table| table.contains_key("stack"));
    is_preset || has_stack().unwrap_or(false)
}

fn open_as<S>(
    source: &Path,
    presets: Presets,
    preset: fn(&str) -> Result<Loaded<S>, SceneError>,
    load: fn(&Path) -> Result<Loaded<S>, SceneError>,
) -> Result<(Loaded<S>, PathBuf), SceneError> {
    if let Some(name) = source.to_str().and_then(|source| source.strip_prefix(PRESET)) {
        return Ok((preset(name)?, PathBuf::from(format!("{name}.toml"))));
    }
    let meant = |(name, _): &&(&str, &str)| source.file_stem().is_some_and(|stem| stem == *name) && !source.exists();
    let loaded = load(source).map_err(|error| match presets.iter().find(meant) {
        Some((name, _)) => {
            let message = format!("{}; the scene of that name in the program is {PRESET}{name}", error.message);
            SceneError { message, ..error }
        }
        None => error,
    })?;
    Ok((loaded, source.to_path_buf()))
}

/// Name and text of presets.
type Presets = &'static [(&'static str, &'static str)];

/// A preset of one kind; a name of the other kind is told what it is.
fn find(presets: Presets, name: &str, others: (Presets, &str)) -> Result<(&'static str, PathBuf), SceneError> {
    let named = |presets: Presets| presets.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    if let Some(text) = named(presets) {
        return Ok((text, PathBuf::from(format!("{name}.toml"))));
    }
    let (others, kind) = others;
    let wrong = match named(others) {
        Some(_) => format!("this preset is {kind}"),
        None => "there is no such preset".to_owned(),
    };
    let names: Vec<&str> = presets.iter().map(|(known, _)| *known).collect();
    let message = format!("{wrong}; here there are {}", names.join(", "));
    Err(SceneError::of_file("unknown_preset", Path::new(name), message))
}
