//! A scene made ready to be traced: pressed, its surfaces, contact and model.

use super::PipelineError;
use crate::mechanics::press::{PressStep, Pressed};
use crate::scene::{LoadedScene, Scene};
use crate::streams::{Role, Sharing, Streams};
use crate::surface::{ContactMap, Surface, SurfaceError, contact_map, pressed_contact, pressed_surface, surface};
use crate::trace::{Kernel, Model, Plan, Settings};
use std::sync::Arc;
use std::time::Instant;

/// How an image of a scene is wanted.
#[derive(Debug, Clone)]
pub struct Order {
    /// How it is traced; the seed is the user's.
    pub settings: Settings,
    /// Whether its random numbers are its own.
    pub sharing: Sharing,
    /// The phantom without its inclusions, on the same mesh.
    pub without_inclusions: bool,
    /// The press starts from what the session's last one found, of a phantom like it, as far as that leads to the same
    /// state (docs/decisions/warm-starts.md). It is the same to rounding only: its bits depend on what came before.
    pub near: bool,
    /// For a quick look: a press on a coarse mesh, without an estimate of its error.
    pub sketch: bool,
    /// What the random numbers know the scene as, in place of its own identity: scenes known as one draw the same.
    pub known_as: Option<Arc<str>>,
}

impl Order {
    /// What a scene asks for by itself.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let settings = Settings::of(&scene.render);
        Self { settings, sharing: Sharing::Own, without_inclusions: false, near: false, sketch: false, known_as: None }
    }

    /// The random numbers of the scene's first load.
    pub(super) fn streams(&self, loaded: &LoadedScene) -> Streams {
        let role = if self.without_inclusions { Role::WithoutInclusions } else { Role::Image };
        let identity = self.known_as.as_ref().map_or_else(|| loaded.identity(), ToString::to_string);
        Streams { sharing: self.sharing, ..Streams::new(self.settings.seed, identity, role) }
    }
}

/// A scene ready to be traced, at one load of its press.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The scene.
    pub loaded: Arc<LoadedScene>,
    /// The press, and which of its loads is traced.
    pub press: Option<(Arc<Pressed>, usize)>,
    /// Shape of the interfaces.
    pub surface: Surface,
    /// Share of true contact.
    pub contact: Option<ContactMap>,
    /// What the tracers see.
    pub model: Model<f64>,
    /// How it is traced; its seed is that of the image's own stream.
    pub settings: Settings,
    /// The random numbers that it draws.
    pub streams: Streams,
    /// Time to make surfaces, contact and model, seconds.
    pub surface_seconds: f64,
}

impl Prepared {
    /// Makes surfaces, contact and model.
    ///
    /// # Errors
    /// A shape that does not fit its stack, a file of the scene that cannot be used, a method that does not suit it.
    pub fn new(
        loaded: Arc<LoadedScene>,
        press: Option<(Arc<Pressed>, usize)>,
        settings: Settings,
        streams: Streams,
    ) -> Result<Self, PipelineError> {
        let start = Instant::now();
        let reached = match &press {
            Some((pressed, load)) => {
                let (load, of) = (*load, pressed.steps.len());
                Some((&**pressed, pressed.steps.get(load).ok_or(PipelineError::NoLoad { load, of })?))
            }
            None => None,
        };
        let (surface, contact, model) = model_of(&loaded, reached)?;
        Plan::choose(settings.integrator, &Kernel::of(&model))?;
        let settings = Settings { seed: streams.light(), ..settings };
        let surface_seconds = start.elapsed().as_secs_f64();
        Ok(Self { loaded, press, surface, contact, model, settings, streams, surface_seconds })
    }

    /// The same scene at another load of its press, from 0.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn at_load(&self, load: usize) -> Result<Self, PipelineError> {
        let press = self.press.as_ref().map(|(pressed, _)| (pressed.clone(), load));
        let streams = Streams { load, ..self.streams.clone() };
        Self::new(self.loaded.clone(), press, self.settings.clone(), streams)
    }

    /// The press and the load that is traced.
    pub fn pressed(&self) -> Option<(&Pressed, &PressStep)> {
        let (pressed, load) = self.press.as_ref()?;
        Some((pressed, pressed.steps.get(*load)?))
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.loaded.scene
    }
}

/// Shape, contact and model of a scene: of its press at a load, or of what it prescribes.
///
/// # Errors
/// A shape that does not fit its stack, a file of the scene that cannot be used.
pub fn model_of(
    loaded: &LoadedScene,
    pressed: Option<(&Pressed, &PressStep)>,
) -> Result<(Surface, Option<ContactMap>, Model<f64>), SurfaceError> {
    let (surface, contact) = match pressed {
        Some((pressed, step)) => (pressed_surface(loaded, pressed, step)?, pressed_contact(loaded, pressed, step)),
        None => (surface(loaded)?, contact_map(loaded)?),
    };
    let model = Model::new(loaded, &surface, contact.clone())?;
    Ok((surface, contact, model))
}
