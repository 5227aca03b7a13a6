//! `estimate`: the paper's figures of images from anywhere.

use super::flags::positive;
use super::measure::{Reading, grey_image, less};
use super::{Failure, Outcome, Talk, note};
use crate::calibrate::{FORCE_ERROR, FrameModel, Frames, Inferred, PressFrame};
use crate::camera::expose;
use crate::estimate::{Calibration, Estimates, GreyImage, Settings, Threshold, estimate, scattered};
use crate::image_io::read_radiance;
use crate::pages::images::{Measured, json, relative_stiffness, text};
use crate::pipeline::view_of;
use crate::scene::{LoadedScene, Scene, open};
use crate::streams::Streams;
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
    #[arg(
        long,
        value_name = "BITS",
        value_parser = clap::value_parser!(u32).range(8..=16),
        allow_negative_numbers = true
    )]
    full_scale_bits: Option<u32>,
    /// Depth of the press of each image, mm: with a calibration that `calibrate` learnt, all images together give size,
    /// depth and modulus of the inclusion.
    #[arg(long, value_name = "MM,..", value_delimiter = ',', allow_negative_numbers = true)]
    depths_mm: Vec<f64>,
    /// Force of the press of each image, N, where it was measured: tells more of what is unknown.
    #[arg(
        long,
        value_name = "N,..",
        value_delimiter = ',',
        requires = "depths_mm",
        value_parser = positive,
        allow_negative_numbers = true
    )]
    forces_n: Vec<f64>,
    /// Relative standard deviation of the forces [default: 0.01].
    #[arg(long, value_name = "SHARE", requires = "forces_n", value_parser = positive, allow_negative_numbers = true)]
    force_error: Option<f64>,
    #[command(flatten)]
    talk: Talk,
}

impl Estimate {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let model = self.reading.frame_model()?;
        let exposure = self.exposure.as_deref().map(open).transpose()?.map(|(loaded, _)| loaded);
        let camera = exposure.as_ref().map(|loaded| loaded.scene.clone());
        let calibration = match (self.reading.calibration()?, &camera) {
            (None, Some(scene)) => Some(Calibration {
                mm_per_pixel: view_of(scene)?.mm_per_pixel(),
                bottom_area_mm2: None,
                force_n_from_sum_grey: None,
            }),
            (given, _) => given,
        };
        let reference = match &self.reading.reference {
            Some(path) => Some(self.read(path, camera.as_ref())?),
            None => None,
        };
        // An image less another is rounded twice.
        let rounded = if reference.is_some() { std::f64::consts::SQRT_2 } else { 1.0 };
        let settings = |threshold_grey: f64| {
            let noise_grey = rounded * Settings::default().noise_grey;
            Settings { threshold_grey, noise_grey }
        };
        let measure = |path: &PathBuf| {
            let raw = self.read(path, camera.as_ref())?;
            let image = match &reference {
                Some(reference) => less(&raw, reference, self.reading.reference.as_deref())?,
                None => raw,
            };
            let threshold_grey = self.threshold_grey(path, &image)?;
            let mut paper = estimate(&image, &settings(threshold_grey));
            paper.warnings.extend(scattered(&image, threshold_grey));
            let paper = match &calibration {
                Some(calibration) => paper.scaled(calibration.mm_per_pixel),
                None => paper,
            };
            Ok(Measured { path: path.clone(), image, threshold_grey, paper })
        };
        let measured = self.images.iter().map(measure).collect::<Result<Vec<_>, Failure>>()?;
        let (inclusion, inferred) = match &model {
            Some(model) => self.inclusion(model, exposure.as_ref())?,
            None => (Estimates::without_model(), Err("no calibrated model".to_owned())),
        };
        let relative = relative_stiffness(&measured, &settings, calibration.as_ref());
        let told = json(&measured, &relative, (&inclusion, &inferred), self.reading.reference.as_deref());
        self.talk.tell(told, text(&measured, &relative, (&inclusion, &inferred)))
    }

    /// What all images together say of the inclusion, and of all unknowns.
    fn inclusion(
        &self,
        model: &FrameModel,
        exposure: Option<&LoadedScene>,
    ) -> Result<(Estimates, Result<Inferred, String>), Failure> {
        let nothing = |why: String| Ok((Estimates::undefined(&why), Err(why)));
        if self.depths_mm.len() != self.images.len() {
            let message = format!(
                "`--depths-mm` gives {} depths for {} images: each image needs the depth of its press",
                self.depths_mm.len(),
                self.images.len()
            );
            return Err(Failure::usage(message));
        }
        if let Some(twice) = self.depths_mm.iter().enumerate().find(|(k, depth)| self.depths_mm[..*k].contains(depth)) {
            return Err(Failure::usage(format!("`--depths-mm` gives {} twice", twice.1)));
        }
        if !self.forces_n.is_empty() && self.forces_n.len() != self.images.len() {
            let (forces, images) = (self.forces_n.len(), self.images.len());
            return Err(Failure::usage(format!("`--forces-n` gives {forces} forces for {images} images")));
        }
        if let Some(Err(why)) = exposure.map(|loaded| model.suits(loaded)) {
            return nothing(format!("the calibration does not suit: {why}"));
        }
        let scene = exposure.map(|loaded| &loaded.scene);
        let frames = self.images.iter().map(|image| self.read(image, scene)).collect::<Result<Vec<_>, _>>()?;
        let size = frames.first().map_or([0; 2], |frame| [frame.width() as u32, frame.height() as u32]);
        let camera = match scene {
            Some(scene) => Some((scene.camera.clone(), scene.light.wavelength_nm)),
            None => model.camera(size),
        };
        let Some((camera, wavelength_nm)) = camera else {
            let [width, height] = size;
            return nothing(format!("{width} x {height} pixels do not fill the calibration's sensor"));
        };
        let frame = |(k, image)| {
            let depth_mm = self.depths_mm.get(k).copied()?;
            Some(PressFrame { depth_mm, image, force_n: self.forces_n.get(k).copied() })
        };
        let frames = frames.iter().enumerate().filter_map(frame).collect();
        let force_error = self.force_error.unwrap_or(FORCE_ERROR);
        Ok(model.inverted(&Frames { camera: &camera, wavelength_nm, frames, force_error }))
    }

    /// The threshold in grey levels of an image.
    fn threshold_grey(&self, path: &Path, image: &GreyImage) -> Result<f64, Failure> {
        match (self.reading.threshold, image.top_grey()) {
            (Threshold::Levels(levels), Some(top)) if levels >= top => {
                let message = format!(
                    "{}: `--threshold {levels}` is not below its top grey level of {top}: no pixel could be lit",
                    path.display()
                );
                Err(Failure::usage(message).in_file(path))
            }
            (Threshold::Levels(levels), _) => Ok(levels),
            (share, Some(top)) => Ok(share.of(top)),
            (share, None) => {
                let message = format!(
                    "{}: has no full scale that `--threshold {share}` could be a share of; give the threshold as a \
                     number, or `--exposure SCENE`",
                    path.display()
                );
                Err(Failure::usage(message).in_file(path))
            }
        }
    }

    /// Grey levels of an image; an EXR is exposed where a camera is given.
    fn read(&self, path: &Path, camera: Option<&Scene>) -> Result<GreyImage, Failure> {
        let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        if let (true, Some(scene)) = (is_exr, camera) {
            let (film, _) = read_radiance(path)?;
            let streams = Streams::of_image(scene.render.seed, &film.mean);
            let frame = expose(&film, &scene.camera, scene.light.wavelength_nm, streams.sensor())
                .map_err(|error| Failure::input(format!("{}: {error}", path.display())).in_file(path))?;
            return Ok(GreyImage::from_frame(&frame)?);
        }
        let (image, linear) = grey_image(path, self.full_scale_bits)?;
        if let Some(scene) = camera {
            same_pixels(path, &image, scene)?;
        }
        if linear && !self.talk.quiet {
            note(&format!(
                "{}: an EXR has no grey levels: its values are taken as they are, and so is the threshold; \
                 `--exposure SCENE` exposes it",
                path.display()
            ));
        }
        Ok(image)
    }
}

/// An image of as many pixels as the camera that is said to have taken it.
fn same_pixels(path: &Path, image: &GreyImage, scene: &Scene) -> Result<(), Failure> {
    let [width, height] = scene.camera.pixels;
    let (found_width, found_height) = (image.width(), image.height());
    if (found_width, found_height) == (width as usize, height as usize) {
        return Ok(());
    }
    let message = format!(
        "{}: has {found_width} x {found_height} pixels, the camera of {} has {width} x {height}",
        path.display(),
        scene.name
    );
    Err(Failure::input(message).in_file(path))
}
