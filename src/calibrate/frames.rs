//! Seen frames as a calibration reads them: logarithms of the radiance of blocks, with the camera's noise.

use super::Blocks;
use crate::camera::{expected_electrons, top_grey};
use crate::estimate::GreyImage;
use crate::film::Film;
use crate::scene::Camera;
use std::f64::consts::PI;

/// Darker blocks are not read, grey levels above black: rounding hides what they hold.
const LEAST_GREY: f64 = 3.0;
/// Depths this close, as a share, are of one load.
const SAME_DEPTH: f64 = 2e-3;

/// Frames of one press, taken by one camera.
#[derive(Debug, Clone)]
pub struct Frames<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Wavelength of the light, nm.
    pub wavelength_nm: f64,
    /// Depth of the press, mm, and the raw frame, for each load.
    pub frames: Vec<(f64, &'a GreyImage)>,
}

/// A block of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Read {
    /// Logarithm of its mean radiance, W/(m^2 sr).
    pub log_light: f64,
    /// Variance of that by the camera.
    pub variance: f64,
}

impl Frames<'_> {
    /// The frame of a load.
    pub(super) fn at(&self, depth_mm: f64) -> Option<&GreyImage> {
        let close = |(depth, _): &&(f64, &GreyImage)| (depth - depth_mm).abs() <= SAME_DEPTH * depth_mm;
        self.frames.iter().find(close).map(|(_, frame)| *frame)
    }

    /// The blocks of a frame; none where a pixel of the block is saturated, or the block too dark.
    ///
    /// # Errors
    /// Says why the frame cannot be read.
    pub(super) fn blocks(&self, frame: &GreyImage, blocks: Blocks) -> Result<Vec<Option<Read>>, String> {
        let [width, height] = self.camera.pixels;
        if [frame.width(), frame.height()] != [width as usize, height as usize] {
            return Err(format!("the frame has {} x {} pixels, the camera others", frame.width(), frame.height()));
        }
        let top = f64::from(top_grey(self.camera.sensor.bit_depth));
        if frame.top_grey() != Some(top) {
            let ends =
                frame.top_grey().map_or("has no grey levels".to_owned(), |ends| format!("has levels up to {ends}"));
            return Err(format!("the frame {ends}, the camera's end at {top}"));
        }
        if !blocks.fits(self.camera.pixels) {
            let [columns, rows] = blocks.count;
            return Err(format!("{width} x {height} pixels do not fall into {columns} x {rows} equal blocks"));
        }
        let even = |radiance| Film {
            width,
            height,
            mean: vec![radiance; width as usize * height as usize],
            ..Film::default()
        };
        let electrons = |radiance| expected_electrons(&even(radiance), self.camera, self.wavelength_nm);
        let (dark, lit) = (electrons(0.0), electrons(1.0));
        let (Ok(dark), Ok(lit)) = (dark, lit) else { return Err("the camera's exposure makes no sense".into()) };
        let sensor = &self.camera.sensor;
        let gain = top / sensor.full_well_e;
        let background = dark.first().copied().unwrap_or(0.0);
        let read = |pixels: Vec<usize>| {
            let count = pixels.len() as f64;
            if pixels.iter().any(|&pixel| frame.is_saturated(pixel)) {
                return None;
            }
            let mean = |of: &[f64]| pixels.iter().filter_map(|&pixel| of.get(pixel)).sum::<f64>() / count;
            let grey = mean(frame.grey()) - sensor.black_level - background * gain;
            if grey < LEAST_GREY {
                return None;
            }
            let electrons = grey / gain;
            let of_pixel = (electrons + background + sensor.read_noise_e.powi(2)) * gain * gain;
            // What rounding shifts the mean of a normal signal of this deviation by, at most (first harmonic).
            let rounded = (-2.0 * PI * PI * of_pixel).exp() / PI;
            let variance = (of_pixel + 1.0 / 12.0) / count + 0.5 * rounded * rounded;
            let log_light = (electrons / (mean(&lit) - background)).ln();
            Some(Read { log_light, variance: variance / (grey * grey) })
        };
        Ok(blocks.pixels(self.camera.pixels).into_iter().map(read).collect())
    }
}
