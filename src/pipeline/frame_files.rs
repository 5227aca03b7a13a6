//! Images of files, as frames of a camera.

use super::Reference;
use crate::camera::exposure::ExposureError;
use crate::camera::{expose, top_grey};
use crate::estimate::{GreyImage, GreyImageError};
use crate::image_io::{ImageError, read_grey, read_radiance};
use crate::scene::{Camera, Scene};
use crate::streams::Streams;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why an image is no frame.
#[derive(Debug, Error)]
pub enum FrameFileError {
    /// It cannot be read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// It does not suit: other pixels, other levels.
    #[error("{}: {why}", file.display())]
    Unsuited {
        /// The file.
        file: PathBuf,
        /// Why.
        why: String,
    },
}

impl FrameFileError {
    fn of(file: &Path, why: impl ToString) -> Self {
        Self::Unsuited { file: file.into(), why: why.to_string() }
    }
}

/// How images of files are read.
#[derive(Debug, Clone, Copy, Default)]
pub struct FrameFiles<'a> {
    /// The scene whose camera took them: it exposes radiance.
    pub scene: Option<&'a Scene>,
    /// Bits of the camera whose levels lie in images of more.
    pub bits: Option<u32>,
}

impl FrameFiles<'_> {
    /// An image, and whether its values are no grey levels but radiance as it is: that of an EXR without a camera.
    ///
    /// # Errors
    /// When it cannot be read, or has other pixels than the camera, or levels that it cannot have.
    pub fn read(&self, file: &Path) -> Result<(GreyImage, bool), FrameFileError> {
        let is_exr = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        if let (true, Some(scene)) = (is_exr, self.scene) {
            let (film, _) = read_radiance(file)?;
            let streams = Streams::of_image(scene.render.seed, &film.mean);
            let frame = expose(&film, &scene.camera, scene.light.wavelength_nm, streams.sensor())
                .map_err(|error: ExposureError| FrameFileError::of(file, error))?;
            return GreyImage::from_frame(&frame).map(|image| (image, false)).map_err(|e| FrameFileError::of(file, e));
        }
        let (image, linear) = grey_image(file, self.bits)?;
        if let Some(scene) = self.scene {
            same_pixels(file, &image, &scene.camera)?;
        }
        Ok((image, linear))
    }
}

impl Reference {
    /// What is subtracted from the frames of a camera, from a file.
    ///
    /// # Errors
    /// When it cannot be read, or has other pixels or levels than the camera.
    pub fn of_file(file: &Path, camera: &Camera) -> Result<Self, FrameFileError> {
        let (image, _) = grey_image(file, Some(camera.sensor.bit_depth))?;
        same_pixels(file, &image, camera)?;
        // What does not fit is told before the work.
        let top = f64::from(top_grey(camera.sensor.bit_depth));
        let dark = vec![0.0; image.grey().len()];
        let frame = GreyImage::new(image.width(), image.height(), &dark, Some(top));
        frame.and_then(|frame| frame.minus(&image)).map_err(|error| FrameFileError::of(file, error))?;
        Ok(Self { image, film: None })
    }
}

/// An image less that of a file.
///
/// # Errors
/// When they have other pixels or levels.
pub fn less(image: &GreyImage, reference: &GreyImage, file: &Path) -> Result<GreyImage, FrameFileError> {
    image.minus(reference).map_err(|error: GreyImageError| FrameFileError::of(file, error))
}

/// Grey levels of an image, of a camera of so many bits where that is known; also whether its values are radiances and
/// not grey levels.
fn grey_image(file: &Path, bits: Option<u32>) -> Result<(GreyImage, bool), FrameFileError> {
    let read = read_grey(file)?;
    let read = match bits {
        Some(bits) => read.with_bits(bits, file)?,
        None => read,
    };
    let image = GreyImage::new(read.width as usize, read.height as usize, &read.values, read.full_scale)
        .map_err(|error| FrameFileError::of(file, error))?;
    Ok((image, read.linear))
}

fn same_pixels(file: &Path, image: &GreyImage, camera: &Camera) -> Result<(), FrameFileError> {
    let ([width, height], found) = (camera.pixels, [image.width(), image.height()]);
    if found == [width as usize, height as usize] {
        return Ok(());
    }
    let [columns, rows] = found;
    Err(FrameFileError::of(file, format!("has {columns} x {rows} pixels, the camera {width} x {height}")))
}
