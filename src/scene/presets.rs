//! The scenes that come with the program.

use super::error::SceneError;
use super::load::{LoadedScan, LoadedScene, parse, parse_scan};
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
