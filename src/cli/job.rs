//! From a scene's name to its image: the steps that the rendering commands share.

use super::{Common, Failure, Progress, cancel, note};
use crate::camera::{View, expected_electrons};
use crate::film::Film;
use crate::scene::{LoadedScene, PRESETS, Scene, SceneError, load, preset};
use crate::surface::{ContactMap, Surface, SurfaceError, contact_map, surface};
use crate::trace::{Kernel, Model, Outcome, Plan, Settings, render};
use std::path::{Path, PathBuf};

/// Before the name of a scene that comes with the program.
const PRESET: &str = "preset:";

/// A scene ready to be traced.
pub(super) struct Job {
    pub loaded: LoadedScene,
    pub surface: Surface,
    pub contact: Option<ContactMap>,
    pub model: Model<f64>,
    pub settings: Settings,
}

impl Job {
    /// Loads a scene file, or the preset of `preset:NAME`, and all that it names; checks that the flags suit it.
    pub fn load(source: &Path, common: &Common) -> Result<Self, Failure> {
        let (loaded, file) = match source.to_str().and_then(|source| source.strip_prefix(PRESET)) {
            Some(name) => (preset(name)?, PathBuf::from(format!("{name}.toml"))),
            None => (load(source).map_err(|error| with_hint(source, error))?, source.to_path_buf()),
        };
        // A shape that does not fit its stack is a mistake of the scene file.
        let place = |error: SurfaceError| match &error {
            SurfaceError::File { .. } => Failure::from(error),
            SurfaceError::Shape { key, .. } => {
                Failure::input(format!("{}: {error}", file.display())).in_file(&file).at_key(*key)
            }
        };
        let surface = surface(&loaded).map_err(place)?;
        let contact = contact_map(&loaded).map_err(place)?;
        let model = Model::new(&loaded, &surface, contact.clone()).map_err(place)?;
        let settings = common.settings(&loaded.scene.render)?;
        Plan::choose(settings.integrator, &Kernel::of(&model))?;
        Ok(Self { loaded, surface, contact, model, settings })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.loaded.scene
    }

    /// The pinhole's view through the undeformed stack.
    pub fn view(&self) -> Result<View, Failure> {
        let scene = self.scene();
        let lambda = scene.light.wavelength_nm;
        let layers: Vec<_> = scene.stack.layer.iter().map(|layer| (layer.index(lambda), layer.thickness_mm)).collect();
        Ok(View::new(&scene.camera, &layers, scene.stack.surround_n)?)
    }

    /// Electrons that the camera expects of a radiance image, row-major.
    pub fn electrons(&self, mean: Vec<f32>) -> Result<Vec<f64>, Failure> {
        let [width, height] = self.scene().camera.pixels;
        let film = Film { width, height, mean, ..Film::default() };
        Ok(expected_electrons(&film, &self.scene().camera, self.scene().light.wavelength_nm)?)
    }

    /// Traces the image, showing how far it is. Ctrl-C stops it.
    pub fn trace(&self, quiet: bool) -> Result<Outcome, Failure> {
        let progress = Progress::new(quiet);
        let outcome = render(&self.model, &self.settings, &mut |stage| {
            progress.observe(stage.done, stage.what);
            !cancel::requested()
        })?;
        drop(progress);
        if let (Some(notice), false) = (&outcome.notice, quiet) {
            note(notice);
        }
        Ok(outcome)
    }
}

/// An error of loading, with the preset that may have been meant.
fn with_hint(source: &Path, error: SceneError) -> Failure {
    let stem = source.file_stem().and_then(|stem| stem.to_str());
    match PRESETS.iter().find(|(name, _)| Some(*name) == stem && !source.exists()) {
        Some((name, _)) => {
            Failure::input(format!("{error}; the scene of that name in the program is {PRESET}{name}")).in_file(source)
        }
        None => error.into(),
    }
}
