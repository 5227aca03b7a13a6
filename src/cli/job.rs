//! From a scene's name to its image: the steps that the rendering commands share.

use super::pressing::{Wanted, press_scene};
use super::{Common, Failure, Progress, cancel, note};
use crate::camera::{View, expected_electrons};
use crate::film::Film;
use crate::mechanics::press::{PressStep, Pressed};
use crate::scene::{LoadedScene, PRESETS, Scene, SceneError, load, preset};
use crate::streams::{Role, Sharing, Streams};
use crate::surface::{ContactMap, Surface, SurfaceError, contact_map, pressed_contact, pressed_surface, surface};
use crate::trace::{Devices, Kernel, Model, Outcome, Plan, Settings, render};
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
    /// What traces it.
    pub devices: Devices,
    /// How it is traced; its seed is that of the image's own stream.
    pub settings: Settings,
    /// The random numbers that it draws.
    pub streams: Streams,
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

/// Refuses a scene whose light cannot be traced.
pub(super) fn guides_light(loaded: &LoadedScene, file: &Path) -> Result<(), Failure> {
    match &loaded.scene.press {
        Some(press) if press.indenter.is_some() => {
            let message = "press.indenter: an indenter guides no light; `tirtouch press` presses it";
            Err(Failure::input(format!("{}: {message}", file.display())).in_file(file).at_key("press.indenter"))
        }
        _ => Ok(()),
    }
}

/// A scene and how it is wanted, before any work.
pub(super) struct Order {
    loaded: LoadedScene,
    devices: Devices,
    settings: Settings,
    sharing: Sharing,
    file: PathBuf,
    wanted: Wanted,
}

impl Order {
    /// Loads a scene, and checks that the flags suit it.
    pub fn read(source: &Path, common: &Common) -> Result<Self, Failure> {
        let wanted = Wanted { without_inclusions: common.without_inclusions, coarse: false, quiet: common.talk.quiet };
        let order = Self::new(source, common, wanted)?;
        guides_light(&order.loaded, &order.file)?;
        Ok(order)
    }

    fn new(source: &Path, common: &Common, wanted: Wanted) -> Result<Self, Failure> {
        let (loaded, file) = load_scene(source)?;
        let settings = common.settings(&loaded.scene.render);
        if wanted.without_inclusions && loaded.scene.press.is_none() {
            let message = format!("{}: --without-inclusions needs a scene with a [press]", file.display());
            return Err(Failure::usage(message).in_file(&file));
        }
        let sharing = if common.common_random_numbers { Sharing::Common } else { Sharing::Own };
        Ok(Self { loaded, devices: common.devices()?, settings, sharing, file, wanted })
    }

    /// Name of the scene.
    pub fn name(&self) -> &str {
        &self.loaded.scene.name
    }

    /// Presses the scene's phantom, if it has one. The job is that of the last load.
    pub fn prepare(self) -> Result<Job, Failure> {
        let Self { loaded, devices, settings, sharing, file, wanted } = self;
        let role = if wanted.without_inclusions { Role::WithoutInclusions } else { Role::Image };
        let streams = Streams { sharing, ..Streams::new(settings.seed, &*loaded.sha256, role) };
        let press = match loaded.scene.press {
            Some(_) => Some(Rc::new(press_scene(&loaded, &file, wanted, None).map_err(|stopped| stopped.failure)?)),
            None => None,
        };
        let press = press.and_then(|pressed| Some((pressed.clone(), pressed.steps.len().checked_sub(1)?)));
        let load = press.as_ref().map_or(0, |(_, load)| *load);
        Job::build(loaded, devices, press, settings, Streams { load, ..streams }, file)
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
        let streams = Streams { load: step, ..self.streams.clone() };
        Self::build(self.loaded.clone(), self.devices.clone(), press, self.settings.clone(), streams, self.file.clone())
    }

    /// The job of the same load without inclusions, with random numbers of its own.
    pub fn baseline(&self, quiet: bool) -> Result<Self, Failure> {
        let file = &self.file;
        let Some((pressed, number)) = &self.press else {
            let message =
                format!("{}: there is no baseline to subtract, since the scene presses nothing", file.display());
            return Err(Failure::usage(message).in_file(file));
        };
        let mut loaded = self.loaded.clone();
        // The traced load, at the depth that it reached, or the steps that lead to it.
        if let (Some(press), Some(step)) = (&mut loaded.scene.press, pressed.steps.get(*number)) {
            if press.step.is_empty() {
                (press.depths_mm, press.forces_n) = (Some(vec![step.depth_mm]), None);
            } else {
                press.step.truncate(number + 1);
            }
            press.estimate_error = false;
        }
        let wanted = Wanted { without_inclusions: true, coarse: false, quiet };
        let pressed = Rc::new(press_scene(&loaded, file, wanted, Some(pressed)).map_err(|stopped| stopped.failure)?);
        let streams = Streams { role: Role::Baseline, ..self.streams.clone() };
        let last = pressed.steps.len().saturating_sub(1);
        let (devices, press) = (self.devices.clone(), Some((pressed, last)));
        Self::build(loaded, devices, press, self.settings.clone(), streams, file.clone())
    }

    fn build(
        loaded: LoadedScene,
        devices: Devices,
        press: Option<(Rc<Pressed>, usize)>,
        settings: Settings,
        streams: Streams,
        file: PathBuf,
    ) -> Result<Self, Failure> {
        let settings = Settings { seed: streams.light(), ..settings };
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
        Ok(Self { loaded, press, surface, contact, model, devices, settings, streams, surface_seconds, file })
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
        view(self.scene())
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
        let outcome = render(&self.devices, &self.model, &self.settings, &mut |stage| {
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

/// The pinhole's view through a scene's undeformed stack.
pub(super) fn view(scene: &Scene) -> Result<View, Failure> {
    let lambda = scene.light.wavelength_nm;
    let layers: Vec<_> = scene.stack.layer.iter().map(|layer| (layer.index(lambda), layer.thickness_mm)).collect();
    Ok(View::new(&scene.camera, &layers, scene.stack.surround_n)?)
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::trace::Precision;

    /// The same job under another seed, few paths and photons on the CPU.
    fn reseeded(job: &Job, seed: u32, sharing: Sharing) -> Job {
        let settings = Settings { spp: 16, photons: Some(1 << 14), ..job.settings.clone() };
        let devices = Devices::cpu(Precision::F32);
        let streams = Streams { seed, sharing, ..job.streams.clone() };
        Job::build(job.loaded.clone(), devices, job.press.clone(), settings, streams, job.file.clone()).unwrap()
    }

    /// Noise of an image: the difference of those of two seeds.
    fn noise(job: &Job, seeds: [u32; 2], sharing: Sharing) -> Vec<f64> {
        let [one, other] = seeds.map(|seed| reseeded(job, seed, sharing).trace(true).unwrap().film.mean);
        one.iter().zip(&other).map(|(one, other)| f64::from(one - other)).collect()
    }

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        product(a, b) / (product(a, a) * product(b, b)).sqrt()
    }

    /// With seeds counted on, a baseline had 0.9 of its noise in common with the next run, and loads 0.8 with one
    /// another.
    #[test]
    fn baselines_loads_and_runs_have_no_noise_in_common_unless_asked() {
        let mut job = Job::sketch(Path::new("preset:phantom-size-8mm")).unwrap();
        job.loaded.scene.camera.pixels = [48, 36];
        job.loaded.scene.render.map_texel_mm = 0.5;
        // The baseline's mesh is as coarse as the sketch's.
        job.loaded.scene.press.as_mut().unwrap().resolution = 0.5;
        job.settings.photons = Some(1 << 19);
        let baseline = job.baseline(true).unwrap();
        let first_load = job.at_step(0).unwrap();
        let [image, without, load] = [&job, &baseline, &first_load].map(|job| noise(job, [1, 3], Sharing::Own));
        // Smoothing leaves some hundred independent patches in 1,728 pixels: four standard errors of a correlation of
        // none.
        let none = 4.0 / 100f64.sqrt();
        let next = noise(&job, [2, 4], Sharing::Own);
        for (name, one, other) in [
            ("baseline and image", &without, &image),
            ("first load and image", &load, &image),
            ("baseline and the next seed's image", &without, &next),
        ] {
            let found = correlation(one, other);
            assert!(found.abs() < none, "{name}: {found}");
        }
        // Loads bend light apart, so that the same numbers leave less in common.
        let [image, without] = [&job, &baseline].map(|job| noise(job, [1, 3], Sharing::Common));
        let found = correlation(&without, &image);
        assert!(found > none, "baseline and image, common random numbers: {found}");
        let [one, other] = [&job, &first_load].map(|job| reseeded(job, 1, Sharing::Common).settings.seed);
        assert_eq!((one, other), (1, 1));
    }

    #[test]
    fn each_seed_load_role_and_scene_has_a_stream_and_repeats_it() {
        let job = Job::sketch(Path::new("preset:phantom-size-8mm")).unwrap();
        let other = Job::sketch(Path::new("preset:phantom-size-2mm")).unwrap();
        let loads = job.press.as_ref().unwrap().0.steps.len();
        let mut streams: Vec<u32> = (0..loads).map(|load| job.at_step(load).unwrap().settings.seed).collect();
        assert_eq!(streams.last(), Some(&job.settings.seed), "the last load is the image");
        streams.extend([other.settings.seed, reseeded(&job, job.streams.seed + 1, Sharing::Own).settings.seed]);
        let again = reseeded(&job, job.streams.seed, Sharing::Own);
        assert_eq!((again.settings.seed, again.streams.sensor()), (job.settings.seed, job.streams.sensor()));
        let count = streams.len();
        streams.sort_unstable();
        streams.dedup();
        assert_eq!(streams.len(), count);
    }
}
