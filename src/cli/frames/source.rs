//! Where frames come from: a scene that is computed, or a measured table.

use super::super::{Failure, Progress, cancel};
use crate::mechanics::frames::scan::{ScanSettings, ScanSetup, scan};
use crate::mechanics::frames::{Frames, read_frames};
use crate::pages::frames::{Computed, Source};
use crate::pipeline::Truth;
use crate::scene::{LoadedScan, SCAN_PRESETS, load_scan, scan_preset};
use std::path::{Path, PathBuf};

/// Before the name of a scene that comes with the program.
const PRESET: &str = "preset:";

/// What the command line names, read and found in order.
pub(super) enum Input {
    /// A scan scene.
    Scene(Box<(LoadedScan, ScanSetup)>),
    /// Measured frames and their file.
    Measured(Frames, PathBuf),
}

/// Reads what the command line names.
pub(super) fn read(scene: Option<&Path>, measured: Option<&Path>) -> Result<Input, Failure> {
    match (scene, measured) {
        (Some(scene), None) => {
            let (loaded, file) = match scene.to_str().and_then(|text| text.strip_prefix(PRESET)) {
                Some(name) => (scan_preset(name)?, PathBuf::from(format!("{name}.toml"))),
                None => (load_scan(scene).map_err(|error| with_hint(scene, error.into()))?, scene.to_path_buf()),
            };
            let place = |failure: Failure| match failure.names_a_file() {
                true => failure,
                false => failure.prefixed(&file.display().to_string()).in_file(&file),
            };
            let setup = ScanSetup::from_scene(&loaded).map_err(|error| place(error.into()))?;
            // What cannot be meshed shows before the work.
            setup.tissue.build_2d().map_err(|error| place(Failure::input(error.to_string())))?;
            Ok(Input::Scene(Box::new((loaded, setup))))
        }
        (None, Some(file)) => Ok(Input::Measured(read_frames(file)?, file.to_path_buf())),
        _ => Err(Failure::usage("give either a scan scene or `--measured CSV`")),
    }
}

/// An error of loading, with the preset that may have been meant.
fn with_hint(source: &Path, error: Failure) -> Failure {
    let stem = source.file_stem().and_then(|stem| stem.to_str());
    match SCAN_PRESETS.iter().find(|(name, _)| Some(*name) == stem && !source.exists()) {
        Some((name, _)) => {
            let message = format!("{}; the scene of that name in the program is {PRESET}{name}", error.message());
            Failure::input(message).in_file(source)
        }
        None => error,
    }
}

impl Input {
    /// Name of the output folder.
    pub fn name(&self) -> String {
        match self {
            Self::Scene(scene) => scene.0.scene.name.clone(),
            Self::Measured(_, file) => file.file_stem().unwrap_or(file.as_os_str()).to_string_lossy().into_owned(),
        }
    }

    /// The scene's window, mm.
    pub fn window_mm(&self) -> Option<f64> {
        match self {
            Self::Scene(scene) => scene.0.scene.scan.window_mm,
            Self::Measured(..) => None,
        }
    }

    /// Computes the frames where they are not measured. Ctrl-C stops it.
    pub fn frames(self, shown_mm: f64, quiet: bool) -> Result<Source, Failure> {
        let name = self.name();
        let version = ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned());
        let (loaded, setup) = match self {
            Self::Scene(scene) => *scene,
            Self::Measured(frames, file) => {
                let provenance = vec![("measured frames".to_owned(), file.display().to_string()), version];
                let description = format!("Measured pressure frames of {}.", file.display());
                let truth = Truth::unknown("the frames are measured");
                return Ok(Source { name, description, frames, computed: None, scene_text: None, truth, provenance });
            }
        };
        let truth = Truth::of(Some(&loaded.scene.phantom), &loaded.folder, false)?;
        let progress = Progress::new(quiet);
        let scanned = scan(&setup, ScanSettings { shown_mm, estimate_error: true }, &|stage| {
            progress.observe(stage.done, stage.what);
            !cancel::requested()
        })?;
        drop(progress);
        let has_middle = loaded.scene.phantom.inclusion.iter().any(|one| one.center_mm[0] == 0.0);
        let provenance =
            vec![("scene".to_owned(), name.clone()), ("scene's SHA-256".to_owned(), loaded.sha256), version];
        let (description, frames) = (loaded.scene.description, scanned.frames.clone());
        let (computed, scene_text) = (Some(Computed { setup, scanned, has_middle }), Some(loaded.text));
        Ok(Source { name, description, frames, computed, scene_text, truth, provenance })
    }
}
