//! Where frames come from, and what the solver says of them.

use crate::mechanics::frames::scan::{ScanSetup, Scanned};
use crate::mechanics::frames::{Features, Frames, FramesError, Reference, Settings, features};
use crate::pages::PageError;
use crate::pages::facts::{figure, scene_rows, version};
use crate::pipeline::Truth;
use crate::report::{Values, Vtu, VtuError};
use crate::scene::LoadedScan;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Frames and where they come from.
pub struct Source {
    pub name: String,
    pub description: String,
    pub frames: Frames,
    pub computed: Option<Computed>,
    /// The scene's text; none of measured frames.
    pub scene_text: Option<String>,
    pub truth: Truth,
    /// SHA-256 of each file that the scene names.
    pub inputs: BTreeMap<PathBuf, String>,
    /// What goes to the end of the report: name and value.
    pub provenance: Vec<(String, String)>,
}

/// What only computed frames have.
pub struct Computed {
    pub setup: ScanSetup,
    pub scanned: Scanned,
    /// Whether an inclusion lies at position 0.
    pub has_middle: bool,
}

impl Source {
    /// Frames of a file.
    pub fn measured(name: String, frames: Frames, file: &Path) -> Self {
        Self {
            name,
            description: format!("Measured pressure frames of {}.", file.display()),
            frames,
            computed: None,
            scene_text: None,
            truth: Truth::unknown("the frames are measured"),
            inputs: BTreeMap::new(),
            provenance: vec![("measured frames".to_owned(), file.display().to_string()), version()],
        }
    }

    /// Frames of a scan that was computed.
    pub fn computed(loaded: LoadedScan, truth: Truth, setup: ScanSetup, scanned: Scanned) -> Self {
        let has_middle = loaded.scene.phantom.inclusion.iter().any(|one| one.center_mm[0] == 0.0);
        let inputs = loaded.inputs();
        let mut provenance = scene_rows(&loaded.scene.name, &loaded.sha256, &inputs);
        provenance.push(version());
        Self {
            name: loaded.scene.name,
            description: loaded.scene.description,
            frames: scanned.frames.clone(),
            computed: Some(Computed { setup, scanned, has_middle }),
            scene_text: Some(loaded.text),
            truth,
            inputs,
            provenance,
        }
    }

    /// Features of all frames.
    pub fn features(&self, window_mm: Option<f64>, noise_kpa: f64) -> Result<Vec<Features>, FramesError> {
        let settings = Settings { window_mm, contact_above_kpa: noise_kpa, ..Settings::default() };
        let reference = match &self.computed {
            Some(computed) => Reference::Without(&computed.scanned.without),
            None => Reference::Farthest,
        };
        features(&self.frames, reference, &settings)
    }

    /// What the eccentricity compares with.
    pub fn reference_name(&self) -> &'static str {
        match self.computed {
            Some(_) => "the same position without inclusions",
            None => "the frame farthest from position 0",
        }
    }

    /// The frame nearest to a position.
    pub fn nearest(&self, position_mm: f64) -> usize {
        let away = |k: &usize| (self.frames.as_slice()[*k].position_mm - position_mm).abs();
        (0..self.frames.as_slice().len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0)
    }
}

impl Computed {
    /// Solver's figures.
    pub fn json(&self) -> Value {
        let done = &self.scanned;
        json!({
            "dofs": done.unknowns,
            "iterations": done.iterations,
            "one_factorisation": done.one_factorisation,
            "seconds": done.seconds,
            "error_seconds": done.error_seconds,
            "force_n_per_mm": done.force_n_per_mm,
            "error": match &done.error {
                Some(error) => json!(error),
                None => json!({"undefined": "the press on the coarser mesh did not converge or has no contact"}),
            },
        })
    }

    /// The same in words.
    pub fn facts(&self) -> Vec<(String, String)> {
        let done = &self.scanned;
        let row = |name: &str, value: String| (name.to_owned(), value);
        let how =
            if done.one_factorisation { "one factorisation for all positions" } else { "each position by itself" };
        let error = match &done.error {
            Some(error) => format!(
                "{} % rms, {} % of the highest pressure, at {} mm",
                figure(100.0 * error.rms),
                figure(100.0 * error.peak),
                figure(error.position_mm)
            ),
            None => "not known: the coarser mesh did not converge or has no contact".to_owned(),
        };
        vec![
            row("mechanics", format!("{} unknowns, {} iterations, {how}", done.unknowns, done.iterations)),
            row("time", format!("{} s, {} s for the error", figure(done.seconds), figure(done.error_seconds))),
            row("error", error),
        ]
    }

    /// The deformed tissue of the shown position.
    pub fn vtu(&self) -> Result<Vec<u8>, PageError> {
        let vtu = self.deformed().map_err(|error| PageError::Vtu { file: "deformed.vtu".into(), error })?;
        Ok(vtu.to_bytes())
    }

    fn deformed(&self) -> Result<Vtu, VtuError> {
        let shown = &self.scanned.shown;
        let mut vtu = Vtu::of_bodies(&[&shown.mesh], 0.0)?;
        vtu.point_vectors("displacement_mm", &shown.state.displacement)?;
        let size = shown.mesh.element_size();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / size as f64;
        let pressure = shown.pressure_kpa().chunks(size).map(mean).collect();
        vtu.cell_field("pressure_kpa", 1, Values::Float(pressure))?;
        Ok(vtu)
    }
}
