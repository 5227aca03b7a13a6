//! The scenes that come with the program.

use super::error::SceneError;
use super::load::{LoadedScene, parse};
use std::path::Path;

/// Name and text of every preset.
pub const PRESETS: &[(&str, &str)] = &[
    ("tsis-paper", include_str!("../../scenes/tsis-paper.toml")),
    ("tsis-literature", include_str!("../../scenes/tsis-literature.toml")),
    ("tsis-dent", include_str!("../../scenes/tsis-dent.toml")),
    ("press-hertz", include_str!("../../scenes/press-hertz.toml")),
    ("flat-bonded", include_str!("../../scenes/flat-bonded.toml")),
    ("dent-cap", include_str!("../../scenes/dent-cap.toml")),
    ("contact-disc", include_str!("../../scenes/contact-disc.toml")),
    ("rough", include_str!("../../scenes/rough.toml")),
    ("microfacet", include_str!("../../scenes/microfacet.toml")),
    ("absorbing", include_str!("../../scenes/absorbing.toml")),
];

/// A preset by its name.
///
/// # Errors
/// When there is no preset of that name.
pub fn preset(name: &str) -> Result<LoadedScene, SceneError> {
    match PRESETS.iter().find(|(known, _)| *known == name) {
        Some((_, text)) => parse(text, Path::new(&format!("{name}.toml"))),
        None => {
            let names: Vec<&str> = PRESETS.iter().map(|(known, _)| *known).collect();
            let message = format!("there is no such preset; there are {}", names.join(", "));
            Err(SceneError::of_file("unknown_preset", Path::new(name), message))
        }
    }
}
