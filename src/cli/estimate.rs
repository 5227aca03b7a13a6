//! `estimate`: the paper's figures of images from anywhere.

use super::flags::positive;
use super::measure::Reading;
use super::{Failure, Outcome, Talk};
use crate::calibrate::{FORCE_ERROR, FrameModel, Frames, Inferred, Presses, check_depths, check_forces, ready};
use crate::estimate::{Estimates, GreyImage};
use crate::pages::images::{Measured, json, relative_stiffness, text};
use crate::pipeline::{FrameFiles, scale_of};
use crate::scene::{LoadedScene, open};
use clap::Args;
use std::path::{Path, PathBuf};

/// Read size, depth indicator and sum of grey values from images (PNG, TIFF, EXR); two images give a relative
/// stiffness.
#[derive(Debug, Args)]
pub(super) struct Estimate {
    /// The images; of two, the second is the one pressed harder.
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// The camera of this scene (file or preset:NAME) took the images: it exposes EXRs, taken as radiance, and gives
    /// the scale of all.
    #[arg(long, value_name = "SCENE")]
    exposure: Option<PathBuf>,
    /// Bits of the camera whose levels lie in PNG or TIFF of 16 bits: tells what is saturated.
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(8..=16))]
    full_scale_bits: Option<u32>,
    /// Depth of the press of each image, mm: with a calibration that `calibrate` learnt, all images together give size,
    /// depth and modulus of the inclusion.
    #[arg(long, value_name = "MM,..", value_delimiter = ',')]
    depths_mm: Vec<f64>,
    /// Force of the press of each image, N, where it was measured: tells more of what is unknown.
    #[arg(long, value_name = "N,..", value_delimiter = ',', requires = "depths_mm", value_parser = positive)]
    forces_n: Vec<f64>,
    /// Relative standard deviation of the forces [default: 0.01].
    #[arg(long, value_name = "SHARE", requires = "forces_n", value_parser = positive)]
    force_error: Option<f64>,
    #[command(flatten)]
    talk: Talk,
}

impl Estimate {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let model = self.reading.frame_model()?;
        let exposure = self.exposure.as_deref().map(open).transpose()?;
        let calibration = match (self.reading.calibration()?, &exposure) {
            (None, Some((loaded, file))) => {
                Some(scale_of(&loaded.scene).map_err(|error| Failure::of_scene(error.into(), file))?)
            }
            (given, _) => given,
        };
        let files =
            FrameFiles { scene: exposure.as_ref().map(|(loaded, _)| &loaded.scene), bits: self.full_scale_bits };
        let reference = self.reading.reference.as_deref();
        let reference = reference.map(|file| Ok::<_, Failure>((file, self.read(&files, file)?))).transpose()?;
        let mut measured = Vec::new();
        for file in &self.images {
            let image = self.read(&files, file)?;
            let threshold = self.threshold_grey(file, &image)?;
            measured.push(Measured::of((file, image), reference.as_ref(), threshold, calibration.as_ref())?);
        }
        // Where presses are told, by the calibration that comes with the program at least.
        let model = model.as_ref().or_else(|| (!self.depths_mm.is_empty()).then(ready).flatten());
        let (inclusion, inferred) = match model {
            Some(model) => self.inclusion(model, exposure.as_ref().map(|(loaded, _)| loaded), &measured)?,
            None => (Estimates::without_model(), Err("no calibrated model".to_owned())),
        };
        let relative = relative_stiffness(&measured, reference.is_some(), calibration.as_ref());
        let told = json(&measured, &relative, (&inclusion, &inferred), reference.as_ref().map(|(file, _)| *file));
        self.talk.tell(told, text(&measured, &relative, (&inclusion, &inferred)))
    }

    /// What all images together say of the inclusion, and of all unknowns.
    fn inclusion(
        &self,
        model: &FrameModel,
        exposure: Option<&LoadedScene>,
        measured: &[Measured],
    ) -> Result<(Estimates, Result<Inferred, String>), Failure> {
        let usage = |flag: &'static str| move |why: String| Failure::usage(format!("`{flag}` {why}"));
        let images: Vec<&GreyImage> = measured.iter().map(Measured::raw).collect();
        check_depths(&self.depths_mm, images.len()).map_err(usage("--depths-mm"))?;
        check_forces(&self.forces_n, images.len()).map_err(usage("--forces-n"))?;
        let size = images.first().map_or([0; 2], |image| [image.width() as u32, image.height() as u32]);
        let presses = Presses {
            depths_mm: &self.depths_mm,
            forces_n: &self.forces_n,
            force_error: self.force_error.unwrap_or(FORCE_ERROR),
        };
        Ok(match model.camera_of(exposure, size) {
            Ok(camera) => model.inverted(&Frames::of(&camera, &images, presses)),
            Err(why) => (Estimates::undefined(&why), Err(why)),
        })
    }

    /// The threshold in grey levels of an image.
    fn threshold_grey(&self, file: &Path, image: &GreyImage) -> Result<f64, Failure> {
        let wrong = |why| Failure::usage(format!("{}: `--threshold`: {why}", file.display())).in_file(file);
        self.reading.threshold.levels(image.top_grey()).map_err(wrong)
    }

    fn read(&self, files: &FrameFiles, file: &Path) -> Result<GreyImage, Failure> {
        let (image, linear) = files.read(file)?;
        if linear {
            self.talk.note(&format!(
                "{}: an EXR has no grey levels: its values are taken as they are, and so is the threshold; \
                 `--exposure SCENE` exposes it",
                file.display()
            ));
        }
        Ok(image)
    }
}
