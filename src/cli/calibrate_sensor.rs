//! `calibrate SCENE`: a sensor on the bench: mm per pixel from a target, force from the sum of grey values.

use super::flags::SceneFile;
use super::job::Job;
use super::{Common, Failure, Outcome, command};
use crate::estimate::sensor::scale;
use crate::pages::sensor::{Bench, Press, at_depths};
use crate::pipeline::{PipelineError, view_of};
use crate::scene::{Invalid, open};
use std::path::Path;
use std::sync::Arc;

/// Presses the phantom without its inclusions to eight depths, the deepest that of the scene, and fits force to light.
pub(super) fn run(file: &Path, common: Common) -> Result<Outcome, Failure> {
    let refused = |Invalid { key, message, .. }: Invalid| {
        Failure::input(format!("{}: {message}", file.display())).in_file(file).at_key(key)
    };
    at_depths(&open(file)?.0).map_err(refused)?;
    let common = Common { without_inclusions: true, ..common };
    let mut job = Job::read(&SceneFile { scene: file.into(), set: Vec::new() }, &common)?;
    let loaded = Arc::new(at_depths(&job.loaded).map_err(refused)?);
    job.loaded = loaded.clone();
    let scene = &loaded.scene;
    let view = view_of(scene).map_err(|error| Failure::of_scene(PipelineError::from(error), file))?;
    let unseen = || refused(Invalid::new("camera", "the camera sees no target on the touched face"));
    let scale = scale(&view, scene.camera.pixels).ok_or_else(unseen)?;
    let folder = common.place.take(&format!("{}-sensor", scene.name))?;
    let prepared = job.prepare()?;
    let mut presses = Vec::new();
    for k in 0..prepared.pressed().map_or(0, |(pressed, _)| pressed.steps.len()) {
        let prepared = job.at_load(&prepared, k)?;
        let shot = job.shoot(&prepared)?;
        let Some((_, step)) = prepared.pressed() else { continue };
        presses.push(Press::of(&shot, step).map_err(refused)?);
    }
    let bench = Bench::of(scene, scale, presses);
    let bench = bench.map_err(|why| Failure::failed(format!("{}: {why}", file.display())))?;
    bench.write(&folder)?;
    let done = command::commit(folder, Some(&job.loaded.text), bench.json())?;
    common.talk.tell(&done.json, bench.text(&done.out))
}
