//! Pictures and files of a shot.

use super::PageError;
use super::side::side_picture;
use crate::film::RADIANCE_UNIT;
use crate::output::OutputFolder;
use crate::pipeline::{Reading, Shot};
use crate::report::{ColorScale, Marks, Raster, false_color, false_color_with, relief};
use std::time::Instant;

/// Pictures of the camera's frame, as SVG.
pub struct CameraPictures {
    pub false_color: String,
    pub relief: String,
}

/// The pictures of a shot, as SVG.
pub struct Pictures {
    pub radiance: String,
    pub relief: String,
    pub side: String,
    /// Time to draw and write all files of the shot, seconds.
    pub files_seconds: f64,
}

impl Shot<'_> {
    /// Writes radiance, camera image and pictures; `command` goes into the header of the radiance.
    pub(crate) fn write_pictured(&self, folder: &OutputFolder, command: &str) -> Result<Pictures, PageError> {
        let start = Instant::now();
        folder.write_image("radiance.exr", |path| self.write_radiance(path, command))?;
        folder.write_image("camera.png", |path| self.frame.write_png(path))?;
        let mut pictures = self.pictures()?;
        folder.write("radiance.svg", &pictures.radiance)?;
        folder.write("relief.svg", &pictures.relief)?;
        folder.write("side.svg", &pictures.side)?;
        pictures.files_seconds = start.elapsed().as_secs_f64();
        Ok(pictures)
    }

    fn pictures(&self) -> Result<Pictures, PageError> {
        let values: Vec<f64> = self.outcome.film.mean.iter().map(|&v| f64::from(v)).collect();
        let raster = self.raster(&values, "radiance", RADIANCE_UNIT);
        let title = format!("{}: radiance", self.prepared.scene().name);
        let scale = scale_of(&values);
        Ok(Pictures {
            radiance: false_color(&title, &raster, scale)?,
            relief: relief(&title, &raster, scale)?,
            side: side_picture(self.prepared, self.prepared.streams.seed)?,
            files_seconds: 0.0,
        })
    }

    /// The frame that was measured, in false colour with what was measured, and as a relief. `less` is what was
    /// subtracted.
    pub(crate) fn camera_pictures(&self, figures: &Reading, less: Option<&str>) -> Result<CameraPictures, PageError> {
        let raster = self.raster(figures.image.grey(), "grey level", "");
        let less = less.map_or_else(String::new, |name| format!(" less {name}"));
        let title = format!("{}: camera{less}", self.prepared.scene().name);
        Ok(CameraPictures {
            false_color: false_color_with(&title, &raster, ColorScale::Linear, &marks(figures))?,
            relief: relief(&title, &raster, ColorScale::Linear)?,
        })
    }

    pub(super) fn raster<'v>(&self, values: &'v [f64], quantity: &'v str, unit: &'v str) -> Raster<'v> {
        let (width, height) = (self.frame.width as usize, self.frame.height as usize);
        Raster { width, height, values, quantity, unit, mm_per_pixel: Some(self.mm_per_pixel) }
    }
}

/// What is drawn on the frame that was measured.
pub fn marks(reading: &Reading) -> Marks {
    Marks { threshold: reading.threshold_grey, centroid_px: reading.paper.centroid_px.best().copied() }
}

/// Logarithmic where a few pixels (glints) are far brighter than the hundredth brightest and dimmer ones lie more than
/// a decade below: on a linear scale the glints alone would show.
pub(super) fn scale_of(values: &[f64]) -> ColorScale {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let percentile = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0);
    let dimmest = sorted.iter().copied().find(|&value| value > 0.0).unwrap_or(0.0);
    match sorted.last() {
        Some(&most) if most > 10.0 * percentile.max(dimmest) => ColorScale::Log,
        _ => ColorScale::Linear,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glints_beside_something_dimmer_ask_for_a_logarithmic_scale() {
        let image = |dim: f64, glint: f64| {
            let mut values = vec![0.0; 1000];
            values[..100].fill(dim);
            values[999] = glint;
            scale_of(&values)
        };
        assert_eq!(image(1.0, 20.0), ColorScale::Log);
        assert_eq!(image(1.0, 5.0), ColorScale::Linear);
        // Glints alone, or darkness.
        assert_eq!(image(0.0, 5.0), ColorScale::Linear);
        assert_eq!(image(0.0, 0.0), ColorScale::Linear);
    }
}
