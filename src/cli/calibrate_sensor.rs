//! `calibrate SCENE`: a sensor on the bench: mm per pixel from a target, force from the sum of grey values.

use super::job::Job;
use super::{Common, Failure, Outcome, command};
use crate::estimate::sensor::{ForceLaw, scale};
use crate::output::OutputFolder;
use crate::pages::sensor::{Bench, Press};
use crate::pipeline::view_of;
use crate::scene::open;
use std::path::Path;
use std::sync::Arc;

/// Presses by which forces are calibrated.
const PRESSES: u32 = 8;

/// Whether a file is a scene, not what a calibration is learnt from.
pub(super) fn is_scene(file: &Path) -> bool {
    let is_preset = file.to_str().is_some_and(|name| name.starts_with("preset:"));
    let has_stack = || {
        let text = std::fs::read_to_string(file).ok()?;
        Some(text.parse::<toml::Table>().ok()?.contains_key("stack"))
    };
    is_preset || has_stack().unwrap_or(false)
}

/// Presses the phantom without its inclusions to eight depths, the deepest that of the scene, and fits force to light.
pub(super) fn run(file: &Path, common: Common) -> Result<Outcome, Failure> {
    let refuse =
        |words: &str, key: &str| Err(Failure::input(format!("{}: {words}", file.display())).in_file(file).at_key(key));
    if open(file)?.0.scene.press.is_none() {
        return refuse("forces are calibrated by presses, and the scene has no [press]", "press");
    }
    let common = Common { without_inclusions: true, ..common };
    let mut job = Job::read(file, &common)?;
    let mut loaded = (*job.loaded).clone();
    let press = loaded.scene.press.get_or_insert_default();
    let Some(deepest) = press.depths_mm.as_ref().and_then(|depths| depths.last().copied()) else {
        return refuse("forces are calibrated by presses to depths; give depths_mm", "press.depths_mm");
    };
    let share = |k: u32| deepest * f64::from(k) / f64::from(PRESSES);
    (press.depths_mm, press.estimate_error) = (Some((1..=PRESSES).map(share).collect()), false);
    let scene = &loaded.scene;
    let view =
        view_of(scene).map_err(crate::pipeline::PipelineError::from).map_err(|error| Failure::of_scene(error, file))?;
    let Some(scale) = scale(&view, scene.camera.pixels) else {
        return refuse("the camera sees no target on the touched face", "camera");
    };
    let folder = OutputFolder::create(&common.destination(&format!("{}-sensor", job.name())), common.force)?;
    let [width, depth] = scene.stack.footprint_mm;
    job.loaded = Arc::new(loaded.clone());
    let prepared = job.prepare()?;
    let steps = prepared.pressed().map_or(0, |(pressed, _)| pressed.steps.len());
    let mut presses = Vec::with_capacity(steps);
    for k in 0..steps {
        let prepared = job.at_load(&prepared, k)?;
        let shot = job.shoot(&prepared)?;
        let Some((_, step)) = prepared.pressed() else { continue };
        let camera = shot.camera_summary();
        if camera.saturated_pixels > 0 {
            return refuse(
                &format!(
                    "the frame at {} mm has saturated pixels: its sum says too little; expose shorter",
                    step.depth_mm
                ),
                "camera.sensor.exposure_ms",
            );
        }
        presses.push(Press { depth_mm: step.depth_mm, force_n: step.force_n, sum_grey: camera.sum_grey as f64 });
    }
    let points: Vec<[f64; 2]> = presses.iter().map(|press| [press.sum_grey, press.force_n]).collect();
    let law = ForceLaw::fit(&points).map_err(|why| Failure::failed(format!("{}: {why}", file.display())))?;
    let bench = Bench { name: job.name().to_owned(), scale, bottom_area_mm2: width * depth, presses, law };
    bench.write(&folder)?;
    let done = command::commit(folder, Some(&job.loaded.text), bench.json())?;
    common.talk.tell(&done.json, bench.text(&done.out))
}
