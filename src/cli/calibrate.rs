//! `calibrate`: learn what a sensor's frames say of an inclusion; of a scene, calibrate its sensor.

use super::calibrate_sensor;
use super::command::described;
use super::flags::positive;
use super::job::watching;
use super::sweep::How;
use super::{Failure, Outcome, cancel};
use crate::calibrate::{CalibrationFile, FrameModel, Protocol, left_out_text, odd_text};
use crate::pages::bound;
use crate::scene::is_scene;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Learn what a sensor's frames say of an inclusion, from phantoms that sweeps press and trace; or, of a scene,
/// calibrate its sensor: mm per pixel from a target, force from the sum of grey values. `estimate --calibration` and
/// `run --calibration` read frames by either.
#[derive(Debug, Args)]
pub(super) struct Calibrate {
    /// Calibration file: the sweeps to learn from; with --bound what was learnt (JSON). Or a scene that presses, or
    /// preset:NAME.
    calibration: PathBuf,
    /// Print how well size, depth and modulus can be known at best by what a calibration reads of frames: the
    /// Cramér-Rao bound.
    #[arg(long)]
    bound: bool,
    /// Frames at each load of the calibration, as in 1,1,8 [default: one at each].
    #[arg(long, value_name = "N,N..", value_delimiter = ',', requires = "bound")]
    frames: Vec<u32>,
    /// Exposure of the frames, ms [default: for each inclusion the longest that saturates nothing].
    #[arg(long, value_name = "MS", requires = "bound", value_parser = positive)]
    exposure_ms: Option<f64>,
    /// Bits of a grey level [default: the scene's].
    #[arg(long, value_name = "BITS", requires = "bound", value_parser = clap::value_parser!(u32).range(8..=16))]
    bits: Option<u32>,
    /// The force of each load is measured too, with this relative standard deviation [default: it is not].
    #[arg(long, value_name = "SHARE", requires = "bound", value_parser = positive)]
    force_error: Option<f64>,
    #[command(flatten)]
    how: How,
}

impl Calibrate {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        if self.bound {
            return self.bounds();
        }
        if is_scene(&self.calibration) {
            return calibrate_sensor::run(&self.calibration, self.how.as_common());
        }
        let parts = CalibrationFile::load(&self.calibration)?.calibrate;
        let out = self.how.folder_of_parts(&self.calibration.file_stem().unwrap_or_default().to_string_lossy())?;
        let folders = self.how.parts(&out, |work| parts.folders(work))?;
        if !folders.is_whole {
            let told = json!({"phantoms": null, "scores": null, "odd": null, "left_out": null, "file": null});
            let next = "the same command without --engine and --shard goes on, and learns";
            let said = format!("{}: not all points are there yet; {next}", out.display());
            return self.how.talk.tell(described(told, Some(&out)), said);
        }
        let trainings = folders.read()?;
        let phantoms = trainings.design.points.len();
        self.how.talk.note(&format!("learning from {phantoms} phantoms"));
        let watch = watching(self.how.talk.quiet);
        let model = trainings.learn(&mut |stage| watch(stage))?.ok_or_else(Failure::cancelled)?;
        let file = out.join("calibration.json");
        model.write(&file)?;
        let (odd, left_out) = (trainings.odd(&model)?, &model.left_out);
        let told = json!({
            "phantoms": phantoms, "scores": model.scores(), "odd": odd, "left_out": left_out, "file": file
        });
        let held = left_out_text(left_out.as_ref());
        let said = format!("learnt from {phantoms} phantoms, by {} scores{}{held}", model.scores(), odd_text(&odd));
        self.how.talk.tell(described(told, Some(&out)), format!("{said}\n{}", file.display()))
    }

    /// Bounds by the calibration, for inclusions over its range.
    fn bounds(&self) -> Result<Outcome, Failure> {
        let model = FrameModel::load(&self.calibration)?;
        let loads = model.depths_mm.len();
        let frames = if self.frames.is_empty() { vec![1; loads] } else { self.frames.clone() };
        if frames.len() != loads || frames.iter().all(|count| *count == 0) {
            let message = format!("--frames: give {loads} numbers, one for each load, and not only 0");
            return Err(Failure::usage(message));
        }
        let (mut camera, wavelength_nm) = model.own_camera()?;
        camera.sensor.bit_depth = self.bits.unwrap_or(camera.sensor.bit_depth);
        let protocol =
            Protocol { camera, wavelength_nm, exposure_ms: self.exposure_ms, frames, force_error: self.force_error };
        let rows = bound::rows(&model, &protocol, &|| !cancel::requested())?.ok_or_else(Failure::cancelled)?;
        let told = json!({"depths_mm": model.depths_mm, "frames": protocol.frames, "bounds": rows});
        self.how.talk.tell(described(told, None), bound::text(&rows))
    }
}
