//! From a scene's name to its image: the steps that the rendering commands share.

use super::pressing::{Wanted, press_scene};
use super::{Common, Failure, Progress, cancel, note};
use crate::camera::{View, expected_electrons};
use crate::film::Film;
use crate::mechanics::press::{PressStep, Pressed};
use crate::scene::{LoadedScene, PRESETS, Scene, SceneError, load, preset};
use crate::surface::{ContactMap, Surface, SurfaceError, contact_map, pressed_contact, pressed_surface, surface};
use crate::trace::{Kernel, Model, Outcome, Plan, Settings, render};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Instant;

/// Before the name of a scene that comes with the program.
const PRESET: &str = "preset:";

/// A scene ready to be traced.
pub(super) struct Job {
    pub loaded: LoadedScene,
    /// The press, and which of its loads is traced.
    pub press: Option<(Rc<Pressed>, usize)>,
    pub surface: Surface,
    pub contact: Option<ContactMap>,
    pub model: Model<f64>,
    pub settings: Settings,
    /// Time to make surfaces, contact and model, seconds.
    pub surface_seconds: f64,
    file: PathBuf,
}

/// Loads a scene file, or the preset of `preset:NAME`, and the name it goes by in messages.
pub(super) fn load_scene(source: &Path) -> Result<(LoadedScene, PathBuf), Failure> {
    match source.to_str().and_then(|source| source.strip_prefix(PRESET)) {
        Some(name) => Ok((preset(name)?, PathBuf::from(format!("{name}.toml")))),
        None => Ok((load(source).map_err(|error| with_hint(source, error))?, source.to_path_buf())),
    }
}

/// A scene and how it is wanted, before any work.
pub(super) struct Order {
    loaded: LoadedScene,
    settings: Settings,
    file: PathBuf,
    wanted: Wanted,
}

impl Order {
    /// Loads a scene, and checks that the flags suit it.
    pub fn read(source: &Path, common: &Common) -> Result<Self, Failure> {
        let wanted = Wanted { without_inclusions: common.without_inclusions, coarse: false, quiet: common.talk.quiet };
        Self::new(source, common, wanted)
    }

    fn new(source: &Path, common: &Common, wanted: Wanted) -> Result<Self, Failure> {
        let (loaded, file) = load_scene(source)?;
        let settings = common.settings(&loaded.scene.render)?;
        if wanted.without_inclusions && loaded.scene.press.is_none() {
            let message = format!("{}: --without-inclusions needs a scene with a [press]", file.display());
            return Err(Failure::usage(message).in_file(&file));
        }
        Ok(Self { loaded, settings, file, wanted })
    }

    /// Name of the scene.
    pub fn name(&self) -> &str {
        &self.loaded.scene.name
    }

    /// Presses the scene's phantom, if it has one. The job is that of the last load.
    pub fn prepare(self) -> Result<Job, Failure> {
        let Self { loaded, settings, file, wanted } = self;
        let press = match loaded.scene.press {
            Some(_) => Some(Rc::new(press_scene(&loaded, &file, wanted).map_err(|stopped| stopped.failure)?)),
            None => None,
        };
        let press = press.and_then(|pressed| Some((pressed.clone(), pressed.steps.len().checked_sub(1)?)));
        Job::build(loaded, press, settings, file)
    }
}

impl Job {
    /// A look at a scene: a press on a coarse mesh, without estimate of its error.
    pub fn sketch(source: &Path) -> Result<Self, Failure> {
        let wanted = Wanted { coarse: true, quiet: true, ..Wanted::default() };
        Order::new(source, &Common::default(), wanted)?.prepare()
    }

    /// The job at another load of its press.
    pub fn at_step(&self, step: usize) -> Result<Self, Failure> {
        let press = self.press.as_ref().map(|(pressed, _)| (pressed.clone(), step));
        Self::build(self.loaded.clone(), press, self.settings.clone(), self.file.clone())
    }

    /// The job of the same load without inclusions, with the next seed.
    pub fn baseline(&self, quiet: bool) -> Result<Self, Failure> {
        let file = &self.file;
        let Some((pressed, step)) = &self.press else {
            let message =
                format!("{}: there is no baseline to subtract, since the scene presses nothing", file.display());
            return Err(Failure::usage(message).in_file(file));
        };
        let mut loaded = self.loaded.clone();
        // Only the traced load, at the depth that it reached.
        if let (Some(press), Some(step)) = (&mut loaded.scene.press, pressed.steps.get(*step)) {
            (press.depths_mm, press.forces_n) = (Some(vec![step.depth_mm]), None);
            press.estimate_error = false;
        }
        let wanted = Wanted { without_inclusions: true, coarse: false, quiet };
        let pressed = Rc::new(press_scene(&loaded, file, wanted).map_err(|stopped| stopped.failure)?);
        let mut settings = self.settings.clone();
        settings.seed = settings.seed.wrapping_add(1);
        Self::build(loaded, Some((pressed, 0)), settings, file.clone())
    }

    fn build(
        loaded: LoadedScene,
        press: Option<(Rc<Pressed>, usize)>,
        settings: Settings,
        file: PathBuf,
    ) -> Result<Self, Failure> {
        // A shape that does not fit its stack is a mistake of the scene file.
        let place = |error: SurfaceError| match &error {
            SurfaceError::File { .. } => Failure::from(error),
            SurfaceError::Shape { key, .. } => {
                Failure::input(format!("{}: {error}", file.display())).in_file(&file).at_key(*key)
            }
        };
        let start = Instant::now();
        let reached = press.as_ref().and_then(|(pressed, step)| Some((pressed, pressed.steps.get(*step)?)));
        let (surface, contact) = match reached {
            Some((pressed, step)) => {
                (pressed_surface(&loaded, pressed, step).map_err(place)?, pressed_contact(&loaded, pressed, step))
            }
            None => (surface(&loaded).map_err(place)?, contact_map(&loaded).map_err(place)?),
        };
        let model = Model::new(&loaded, &surface, contact.clone()).map_err(place)?;
        Plan::choose(settings.integrator, &Kernel::of(&model))?;
        let surface_seconds = start.elapsed().as_secs_f64();
        Ok(Self { loaded, press, surface, contact, model, settings, surface_seconds, file })
    }

    /// The press and the load that is traced.
    pub fn pressed(&self) -> Option<(&Pressed, &PressStep)> {
        let (pressed, step) = self.press.as_ref()?;
        Some((pressed, pressed.steps.get(*step)?))
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
