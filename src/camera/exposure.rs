//! From radiance to a camera frame: irradiance, photons, electrons, grey values.
//!
//! A lens of focal ratio N that images radiance L puts on the sensor, at field angle theta,
//!
//! ```text
//! E = pi L cos^4(theta) / (4 N^2)
//! ```
//!
//! (Kolb, Mitchell and Hanrahan, "A realistic camera model for computer graphics", SIGGRAPH 1995, section 2, for a
//! far object). This is the form for distant objects: at magnification m the working focal ratio is N (1 + m), so a
//! lens focused close by gathers less, by (1 + m)^2. The scene's `f_number` is therefore the working one. Beside
//! the cos^4 law the lens loses light towards the corner in proportion to the squared distance from the image's
//! centre (`vignetting_corner_loss`). Ambient light reaches all pixels alike: neither law applies to it.
//!
//! Electrons are Poisson(QE photons + dark current x time) plus normal read noise, clipped at the full well, which the
//! gain maps to the top grey level; the black level is added before rounding and clipping.

use super::noise::PixelRandom;
use super::projection::{ProjectionError, focal_px};
use crate::film::Film;
use crate::image_io::{ImageError, write_png_grey};
use crate::scene::{Camera, Sensor};
use rayon::prelude::*;
use std::path::Path;

/// Planck's constant, J s (exact in the SI).
pub const PLANCK_J_S: f64 = 6.626_070_15e-34;
/// Speed of light in vacuum, m/s (exact in the SI).
pub const LIGHT_SPEED_M_PER_S: f64 = 299_792_458.0;
/// Largest full well that the Poisson draws resolve to one electron.
const LARGEST_FULL_WELL_E: f64 = 1e9;

/// A camera image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bits per grey value, 8 to 16.
    pub bit_depth: u32,
    /// Grey values, row-major, row 0 at positive y.
    pub grey: Vec<u16>,
}

impl Frame {
    /// Writes it as a grey PNG: of 8 bits, or of 16 where a level takes more; levels are written as they are.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<(), ImageError> {
        let bits = if self.bit_depth > 8 { 16 } else { 8 };
        write_png_grey(path, self.width, self.height, &self.grey, bits)
    }

    /// The top grey level, 2^bits - 1.
    pub fn top_grey(&self) -> u16 {
        top_grey(self.bit_depth)
    }

    /// The highest grey level in it.
    pub fn max_grey(&self) -> u16 {
        self.grey.iter().copied().max().unwrap_or(0)
    }

    /// Pixels at the top grey level.
    pub fn saturated_pixels(&self) -> usize {
        self.grey.iter().filter(|&&grey| grey >= self.top_grey()).count()
    }
}

/// The top grey level of a camera of so many bits, 2^bits - 1.
pub fn top_grey(bit_depth: u32) -> u16 {
    ((1u32 << bit_depth.min(16)) - 1) as u16
}

/// Why there is no exposure.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExposureError {
    /// The film and the camera do not have the same pixels.
    #[error(
        "the film has {film_width} x {film_height} pixels and {values} values, the camera {width} x {height} pixels"
    )]
    Size {
        /// Columns of the film.
        film_width: u32,
        /// Rows of the film.
        film_height: u32,
        /// Values on the film.
        values: usize,
        /// Columns of the camera.
        width: u32,
        /// Rows of the camera.
        height: u32,
    },
    /// A radiance that is no radiance.
    #[error("radiance of column {column}, row {row} is {value}: it must be finite and 0 or more")]
    Radiance {
        /// Column.
        column: u32,
        /// Row.
        row: u32,
        /// Its value, W/(m^2 sr).
        value: f32,
    },
    /// A camera or sensor setting outside its range.
    #[error("camera {key} is {value}: it must be {allowed}")]
    Setting {
        /// Key in the scene file.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        allowed: &'static str,
    },
    /// The camera's geometry.
    #[error(transparent)]
    Projection(#[from] ProjectionError),
}

/// Expected electrons of every pixel, row-major: signal, ambient light and dark current, before noise and clipping.
///
/// # Errors
/// Where film and camera differ in size, a radiance is negative or not finite, or a setting is out of range.
pub fn expected_electrons(film: &Film, camera: &Camera, wavelength_nm: f64) -> Result<Vec<f64>, ExposureError> {
    let [width, height] = camera.pixels;
    let same_pixels = [film.width, film.height] == camera.pixels;
    if !same_pixels || film.mean.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(ExposureError::Size {
            film_width: film.width,
            film_height: film.height,
            values: film.mean.len(),
            width,
            height,
        });
    }
    check_settings(camera, wavelength_nm)?;
    let focal_px = focal_px(camera)?;
    let sensor = &camera.sensor;
    let electrons_per_radiance = electrons_per_radiance(camera, wavelength_nm);
    let background =
        electrons_per_radiance * sensor.ambient_w_per_m2_sr + sensor.dark_current_e_per_s * sensor.exposure_ms * 1e-3;
    let (half_width, half_height) = (0.5 * f64::from(width), 0.5 * f64::from(height));
    let corner2 = half_width.powi(2) + half_height.powi(2);
    let pixel = |(index, &radiance): (usize, &f32)| {
        let (column, row) = (index as u32 % width, index as u32 / width);
        if !(radiance >= 0.0 && radiance.is_finite()) {
            return Err(ExposureError::Radiance { column, row, value: radiance });
        }
        let radius2 = (f64::from(column) + 0.5 - half_width).powi(2) + (f64::from(row) + 0.5 - half_height).powi(2);
        let cos2 = 1.0 / (1.0 + radius2 / (focal_px * focal_px));
        let vignetting = 1.0 - sensor.vignetting_corner_loss * radius2 / corner2;
        Ok(f64::from(radiance) * cos2 * cos2 * vignetting * electrons_per_radiance + background)
    };
    film.mean.par_iter().enumerate().map(pixel).collect()
}

/// Electrons on the axis for a radiance of 1 W/(m^2 sr).
fn electrons_per_radiance(camera: &Camera, wavelength_nm: f64) -> f64 {
    let sensor = &camera.sensor;
    let irradiance = std::f64::consts::PI / (4.0 * sensor.f_number * sensor.f_number);
    let pixel_m2 = (camera.pixel_pitch_um * 1e-6).powi(2);
    let photon_j = PLANCK_J_S * LIGHT_SPEED_M_PER_S / (wavelength_nm * 1e-9);
    sensor.quantum_efficiency * irradiance * pixel_m2 * sensor.exposure_ms * 1e-3 / photon_j
}

/// The camera's image of a film: electrons with noise, quantised. The same seed gives the same bits on any number of
/// threads.
///
/// # Errors
/// As [`expected_electrons`].
pub fn expose(film: &Film, camera: &Camera, wavelength_nm: f64, seed: u32) -> Result<Frame, ExposureError> {
    let electrons = expected_electrons(film, camera, wavelength_nm)?;
    let pixel = |(index, &mean): (usize, &f64)| {
        let mut random = PixelRandom::new(seed, index as u32);
        read_out(mean, &camera.sensor, &mut random)
    };
    Ok(Frame {
        width: film.width,
        height: film.height,
        bit_depth: camera.sensor.bit_depth,
        grey: electrons.par_iter().enumerate().map(pixel).collect(),
    })
}

/// The grey value that a pixel of the given expected electrons reads.
pub(super) fn read_out(mean_electrons: f64, sensor: &Sensor, random: &mut PixelRandom) -> u16 {
    // Above twice the full well the pixel saturates whatever the draw; a bounded mean keeps the draw exact.
    let mean = mean_electrons.min(2.0 * sensor.full_well_e + 1000.0);
    let electrons = random.poisson(mean) + sensor.read_noise_e * random.normal();
    let top = f64::from(top_grey(sensor.bit_depth));
    let grey = electrons.min(sensor.full_well_e) * top / sensor.full_well_e + sensor.black_level;
    grey.round().clamp(0.0, top) as u16
}

fn check_settings(camera: &Camera, wavelength_nm: f64) -> Result<(), ExposureError> {
    const POSITIVE: &str = "finite and above 0";
    const NOT_NEGATIVE: &str = "finite and 0 or more";
    const SHARE: &str = "between 0 and 1";
    let sensor = &camera.sensor;
    let positive = |v: f64| v > 0.0 && v.is_finite();
    let not_negative = |v: f64| v >= 0.0 && v.is_finite();
    let share = |v: f64| (0.0..=1.0).contains(&v);
    let well = sensor.full_well_e;
    let rules = [
        ("wavelength_nm", wavelength_nm, positive(wavelength_nm), POSITIVE),
        ("pixel_pitch_um", camera.pixel_pitch_um, positive(camera.pixel_pitch_um), POSITIVE),
        ("f_number", sensor.f_number, positive(sensor.f_number), POSITIVE),
        ("exposure_ms", sensor.exposure_ms, not_negative(sensor.exposure_ms), NOT_NEGATIVE),
        ("quantum_efficiency", sensor.quantum_efficiency, share(sensor.quantum_efficiency), SHARE),
        ("full_well_e", well, (1.0..=LARGEST_FULL_WELL_E).contains(&well), "between 1 and 1e9"),
        ("read_noise_e", sensor.read_noise_e, not_negative(sensor.read_noise_e), NOT_NEGATIVE),
        ("dark_current_e_per_s", sensor.dark_current_e_per_s, not_negative(sensor.dark_current_e_per_s), NOT_NEGATIVE),
        ("bit_depth", f64::from(sensor.bit_depth), (8..=16).contains(&sensor.bit_depth), "between 8 and 16"),
        ("black_level", sensor.black_level, not_negative(sensor.black_level), NOT_NEGATIVE),
        ("vignetting_corner_loss", sensor.vignetting_corner_loss, share(sensor.vignetting_corner_loss), SHARE),
        ("ambient_w_per_m2_sr", sensor.ambient_w_per_m2_sr, not_negative(sensor.ambient_w_per_m2_sr), NOT_NEGATIVE),
    ];
    match rules.into_iter().find(|(_, _, holds, _)| !holds) {
        Some((key, value, _, allowed)) => Err(ExposureError::Setting { key, value, allowed }),
        None => Ok(()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
#[path = "exposure_tests.rs"]
mod tests;
