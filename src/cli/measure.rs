//! The paper's figures of a camera frame.

use super::Failure;
use crate::calibrate::FrameModel;
use crate::camera::top_grey;
use crate::estimate::{Calibration, Threshold};
use crate::pipeline::{self, ReadAs, Reference, Shot};
use crate::scene::Camera;
use clap::Args;
use std::path::{Path, PathBuf};

/// Flags of the commands that read figures from images.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct Reading {
    /// Threshold k: brighter pixels are lit, in grey levels, or as a share of full scale (`2%`).
    #[arg(long, value_name = "K", default_value_t)]
    pub threshold: Threshold,
    /// Image to subtract first: a frame without inclusion, or without press.
    #[arg(long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,
    /// Calibration: the scale of the frame (TOML), or what `calibrate` learnt of the sensor (JSON).
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
}

/// The same for commands that make their image, and can make its reference too.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct SceneReading {
    #[command(flatten)]
    pub image: Reading,
    /// Subtract the frame of the same press without inclusions, made along the way (scenes with a press).
    #[arg(long, conflicts_with = "reference")]
    pub subtract_baseline: bool,
}

/// Whether a calibration is what `calibrate` learnt, not a scale.
fn is_model(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

impl Reading {
    /// The calibration, where one is given.
    pub fn calibration(&self) -> Result<Option<Calibration>, Failure> {
        let scale = self.calibration.as_deref().filter(|file| !is_model(file));
        Ok(scale.map(Calibration::load).transpose()?)
    }

    /// What was learnt of the sensor's frames, where that is given.
    pub fn frame_model(&self) -> Result<Option<FrameModel>, Failure> {
        let model = self.calibration.as_deref().filter(|file| is_model(file));
        Ok(model.map(FrameModel::load).transpose()?)
    }
}

impl SceneReading {
    /// The reference image, where one is given, for a camera of as many pixels and bits, which the threshold suits.
    pub fn reference(&self, camera: &Camera) -> Result<Option<Reference>, Failure> {
        let wrong = |why| Failure::usage(format!("`--threshold`: {why}"));
        self.image.threshold.levels(Some(top_grey(camera.sensor.bit_depth).into())).map_err(wrong)?;
        Ok(self.image.reference.as_deref().map(|path| Reference::of_file(path, camera)).transpose()?)
    }

    /// What is subtracted, if anything.
    pub fn reference_name(&self) -> Option<String> {
        match (&self.image.reference, self.subtract_baseline) {
            (Some(path), _) => Some(path.display().to_string()),
            (None, true) => Some("baseline.png".into()),
            (None, false) => None,
        }
    }

    /// Reads the figures of a shot: its camera frame, raw or less the reference.
    pub fn of_shot(
        &self,
        shot: &Shot,
        reference: Option<&Reference>,
        calibration: Option<&Calibration>,
    ) -> Result<pipeline::Reading, Failure> {
        let threshold_grey = self.image.threshold.of(f64::from(shot.frame.top_grey()));
        let path = self.image.reference.as_deref().unwrap_or(Path::new("reference"));
        shot.read(&ReadAs { threshold_grey, reference, calibration }).map_err(|error| Failure::of_scene(error, path))
    }
}
