//! A scene's way through the pipeline, with progress and with words for what goes wrong.

use super::flags::SceneFile;
use super::{Common, Failure, Progress, cancel, note};
use crate::camera::Suited;
use crate::pages::exposure::unsuited;
use crate::pipeline::{Order, Prepared, Session, Shot, guides_light};
use crate::progress::{Observer, Stage};
use crate::scene::LoadedScene;
use crate::streams::Sharing;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene, how it is wanted, and what works on it.
pub(super) struct Job {
    pub loaded: Arc<LoadedScene>,
    session: Session,
    order: Order,
    file: PathBuf,
    quiet: bool,
}

/// Refuses a scene whose light cannot be traced.
pub(super) fn check_light(loaded: &LoadedScene, file: &Path) -> Result<(), Failure> {
    guides_light(loaded).map_err(|error| Failure::of_scene(error, file))
}

impl Job {
    /// Loads a scene, checks that the flags suit it, and opens what traces, before any work.
    pub fn read(source: &SceneFile, common: &Common) -> Result<Self, Failure> {
        let (loaded, file) = source.open()?;
        let order = Order {
            settings: common.settings(&loaded.scene.render),
            sharing: if common.common_random_numbers { Sharing::Common } else { Sharing::Own },
            without_inclusions: common.without_inclusions,
            ..Order::of(&loaded.scene)
        };
        if order.without_inclusions && loaded.scene.press.is_none() {
            let message = format!("{}: --without-inclusions needs a scene with a [press]", file.display());
            return Err(Failure::usage(message).in_file(&file));
        }
        let session = common.devices()?.into();
        check_light(&loaded, &file)?;
        Ok(Self { loaded: Arc::new(loaded), session, order, file, quiet: common.talk.quiet })
    }

    /// Presses the scene's phantom, if it has one, and makes its last load ready.
    pub fn prepare(&mut self) -> Result<Prepared, Failure> {
        let Self { loaded, session, order, file, quiet } = self;
        watched(*quiet, |observe| session.prepare(loaded.clone(), order, observe))
            .map_err(|error| Failure::of_scene(error, file))
    }

    /// Another load of the press.
    pub fn at_load(&self, prepared: &Prepared, load: usize) -> Result<Prepared, Failure> {
        prepared.at_load(load).map_err(|error| Failure::of_scene(error, &self.file))
    }

    /// The same load without inclusions.
    pub fn baseline(&mut self, prepared: &Prepared) -> Result<Prepared, Failure> {
        let Self { session, file, quiet, .. } = self;
        watched(*quiet, |observe| session.baseline(prepared, observe)).map_err(|error| Failure::of_scene(error, file))
    }

    /// Traces the image and exposes it.
    pub fn shoot<'a>(&self, prepared: &'a Prepared) -> Result<Shot<'a>, Failure> {
        let shot = watched(self.quiet, |observe| self.session.shoot(prepared, observe))
            .map_err(|error| Failure::of_scene(error, &self.file))?;
        if let (Some(notice), false) = (&shot.outcome.notice, self.quiet) {
            note(notice);
        }
        Ok(shot)
    }
}

/// Shows how far work is. Ctrl-C stops it.
pub(super) fn watching(quiet: bool) -> impl Fn(Stage) -> bool + Sync {
    let progress = Progress::new(quiet);
    move |stage| {
        progress.observe(stage.done, stage.what);
        !cancel::requested()
    }
}

/// Does work that shows how far it is. Ctrl-C stops it.
pub(super) fn watched<T>(quiet: bool, work: impl FnOnce(&mut Observer) -> T) -> T {
    work(&mut watching(quiet))
}

/// Notes an exposure time that does not suit the image, unless `quiet`.
pub(super) fn note_exposure(suited: &Suited, exposure_ms: f64, quiet: bool) {
    if let (Some(line), false) = (unsuited(suited, exposure_ms), quiet) {
        note(&line);
    }
}
