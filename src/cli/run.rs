//! `run`: from a scene to estimates and a report.

use super::command::{self, command_line, command_of_light};
use super::flags::SceneFile;
use super::job::{Job, note_exposure};
use super::measure::SceneReading;
use super::{Common, Failure, Outcome};
use crate::calibrate::estimates_of;
use crate::estimate::GreyImage;
use crate::output::OutputFolder;
use crate::pages;
use crate::pipeline::{EarlierFrame, Prepared, Reference, Truth};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Press, trace, expose and estimate: what render writes, the camera image in false colour, and report.html.
#[derive(Debug, Args)]
pub(super) struct Run {
    #[command(flatten)]
    scene: SceneFile,
    #[command(flatten)]
    reading: SceneReading,
    #[command(flatten)]
    common: Common,
}

impl Run {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let job = Job::read(&self.scene, &self.common)?;
        let folder = self.common.place.take(&job.loaded.scene.name)?;
        whole_job(job, &self.reading, &self.common, folder).map(|_| Outcome::Done)
    }
}

/// Does the whole job, writes its folder and prints its figures; gives the folder's place.
pub(super) fn whole_job(
    mut job: Job,
    reading: &SceneReading,
    common: &Common,
    folder: OutputFolder,
) -> Result<PathBuf, Failure> {
    let calibration = reading.image.calibration()?;
    let model = reading.image.frame_model()?;
    let given = reading.reference(&job.loaded.scene.camera)?;
    let prepared = job.prepare()?;
    let scene = prepared.scene();
    let truth = Truth::of(scene.phantom.as_ref(), &job.loaded.files, common.without_inclusions)?;
    let reference = match reading.subtract_baseline {
        true => Some(baseline(&mut job, &prepared, &folder)?),
        false => given,
    };
    let (earlier, mut frames) = earlier_loads(&job, &prepared, &folder)?;
    let shot = job.shoot(&prepared)?;
    note_exposure(&shot.suited, scene.camera.sensor.exposure_ms, common.talk.quiet);
    let mut figures = reading.of_shot(&shot, reference.as_ref(), calibration.as_ref())?;
    if let Some((_, step)) = prepared.pressed() {
        frames.push((step.depth_mm, GreyImage::from_frame(&shot.frame)?));
    }
    figures.estimates = estimates_of(model.as_ref(), &job.loaded, &frames);
    let reference = reading.reference_name();
    let page = pages::run::Run {
        shot: &shot,
        figures: &figures,
        reference: reference.as_deref(),
        truth: &truth,
        frames: &frames,
        earlier: &earlier,
        command: command_line(),
        command_of_light: command_of_light(),
    };
    let files_seconds = pages::run::write(&page, &folder)?;
    let mut summary = shot.run_summary(&figures, reference, truth);
    summary.shot.stages_seconds.files = files_seconds;
    summary.earlier_frames = earlier;
    let done = command::commit(folder, Some(&job.loaded.text), json!(summary))?;
    common.talk.tell(&done.json, pages::run::text(&shot, &figures, &summary.truth, &done.out))?;
    Ok(PathBuf::from(done.out))
}

/// The frame of the same press without inclusions, with random numbers of its own; written as baseline.png.
fn baseline(job: &mut Job, prepared: &Prepared, folder: &OutputFolder) -> Result<Reference, Failure> {
    let baseline = job.baseline(prepared)?;
    let shot = job.shoot(&baseline)?;
    folder.write_image("baseline.png", |path| shot.frame.write_png(path))?;
    Ok(shot.as_reference()?)
}

/// Frames by the depth of their press, mm.
type ByDepth = Vec<(f64, GreyImage)>;

/// Frames of the loads before the last, written as camera_DEPTHmm.png, or of the steps as camera_NUMBER.png.
fn earlier_loads(
    job: &Job,
    prepared: &Prepared,
    folder: &OutputFolder,
) -> Result<(Vec<EarlierFrame>, ByDepth), Failure> {
    let Some((pressed, _)) = prepared.pressed() else { return Ok(Default::default()) };
    let before = pressed.steps.len().saturating_sub(1);
    let (mut earlier, mut frames) = (Vec::with_capacity(before), Vec::with_capacity(before));
    for (k, step) in pressed.steps[..before].iter().enumerate() {
        let prepared = job.at_load(prepared, k)?;
        let shot = job.shoot(&prepared)?;
        let file = EarlierFrame::file_of(pressed, k, step);
        folder.write_image(&file, |path| shot.frame.write_png(path))?;
        frames.push((step.depth_mm, GreyImage::from_frame(&shot.frame)?));
        earlier.push(EarlierFrame::of(&shot, step, file));
    }
    Ok((earlier, frames))
}
