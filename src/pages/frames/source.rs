//! Where frames come from, and what the solver says of them.

use crate::mechanics::frames::scan::{ScanError, ScanSettings, ScanSetup, Scanned, Shown, scan};
use crate::mechanics::frames::{Features, Frames, FramesError, Reference, Settings, features};
use crate::mechanics::press::PressError;
use crate::pages::PageError;
use crate::pages::facts::{figure, scene_rows, version};
use crate::pages::press_vtu::Solved;
use crate::pipeline::Truth;
use crate::progress::Stage;
use crate::scene::LoadedScan;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Frames and where they come from.
#[derive(Debug, Clone)]
pub struct Source {
    /// Name of the scene, or of the table.
    pub name: String,
    /// What the scene is.
    pub description: String,
    /// The frames.
    pub frames: Frames,
    /// What only computed frames have.
    pub computed: Option<Computed>,
    /// The scene's text; none of measured frames.
    pub scene_text: Option<String>,
    /// What the tissue holds.
    pub truth: Truth,
    /// SHA-256 of each file that the scene names.
    pub inputs: BTreeMap<PathBuf, String>,
    /// What goes to the end of the report: name and value.
    pub provenance: Vec<(String, String)>,
}

/// What only computed frames have.
#[derive(Debug, Clone)]
pub struct Computed {
    /// What was scanned.
    pub setup: ScanSetup,
    /// What came out.
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

    /// Computes the frames of a scan; the whole state of the position nearest to `shown_mm` is kept. `observe` hears
    /// how far it is, from any thread, and may stop it.
    ///
    /// # Errors
    /// As [`scan`].
    pub fn scan(
        loaded: LoadedScan,
        setup: ScanSetup,
        shown_mm: f64,
        observe: &(dyn Fn(Stage) -> bool + Sync),
    ) -> Result<Self, ScanError> {
        let truth = Truth::of(Some(&loaded.scene.phantom), &loaded.files, false).map_err(|error| match error {
            PressError::File(file) => ScanError::File(file),
            error => ScanError::Truth(Box::new(error)),
        })?;
        let scanned = scan(&setup, ScanSettings { shown_mm, estimate_error: true }, observe)?;
        Ok(Self::computed(loaded, truth, setup, scanned))
    }

    /// Frames of a scan that was computed.
    fn computed(loaded: LoadedScan, truth: Truth, setup: ScanSetup, scanned: Scanned) -> Self {
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

    /// Takes the file of what is known beside measured frames among what its results are of.
    pub fn know(&mut self, file: &Path, known: &LoadedScan) {
        self.provenance.push((format!("{}'s SHA-256", file.display()), known.sha256.clone()));
        self.inputs.insert(file.into(), known.sha256.clone());
    }

    /// Features of all frames, which are fitted in a window of half this width, or in the whole contact.
    ///
    /// # Errors
    /// Never for frames of one source.
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

/// A scan found in order: what cannot be meshed shows before the work.
///
/// # Errors
/// Geometry, material or a file that cannot be used.
pub fn setup_of(loaded: &LoadedScan) -> Result<ScanSetup, ScanError> {
    let setup = ScanSetup::from_scene(loaded)?;
    setup.tissue.build_2d()?;
    Ok(setup)
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
    ///
    /// # Errors
    /// A state that does not fit its mesh.
    pub fn vtu(&self) -> Result<Vec<u8>, PageError> {
        let Shown { problem, state, points, .. } = &self.scanned.shown;
        let vtu = Solved { problem, state, points }.vtu();
        Ok(vtu.map_err(|error| PageError::Vtu { file: "deformed.vtu".into(), error })?.to_bytes())
    }
}
