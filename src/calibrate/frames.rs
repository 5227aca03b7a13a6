//! Seen frames as a calibration reads them: logarithms of the radiance of blocks, with the camera's noise.

use super::Blocks;
use super::reader::{Read, Reader};
use crate::camera::top_grey;
use crate::estimate::GreyImage;
use crate::scene::Camera;

/// Depths this close, as a share, are of one load.
const SAME_DEPTH: f64 = 2e-3;

/// Frames of one press, taken by one camera.
#[derive(Debug, Clone)]
pub struct Frames<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Wavelength of the light, nm.
    pub wavelength_nm: f64,
    /// Each load.
    pub frames: Vec<PressFrame<'a>>,
    /// Relative standard deviation of the forces, where they were measured.
    pub force_error: f64,
}

/// The frame of a load.
#[derive(Debug, Clone, Copy)]
pub struct PressFrame<'a> {
    /// Depth of the press, mm.
    pub depth_mm: f64,
    /// The raw frame.
    pub image: &'a GreyImage,
    /// Force of the press, N, where it was measured.
    pub force_n: Option<f64>,
}

/// Whether a depth is that of a load.
pub(crate) fn same_depth(depth_mm: f64, of_load: f64) -> bool {
    (depth_mm - of_load).abs() <= SAME_DEPTH * of_load
}

/// Relative standard deviation of a force, where nothing is said of it.
pub const FORCE_ERROR: f64 = 0.01;

/// Whether depths are those of so many frames.
///
/// # Errors
/// Says what of them is not.
pub fn check_depths(depths_mm: &[f64], frames: usize) -> Result<(), String> {
    let depths = depths_mm.len();
    if depths != frames || frames == 0 {
        return Err(format!("gives {depths} depths for {frames} frames: each frame needs the depth of its press"));
    }
    let mut twice = depths_mm.iter().enumerate().filter(|(k, depth)| depths_mm[..*k].contains(depth));
    twice.next().map_or(Ok(()), |(_, depth)| Err(format!("gives {depth} twice")))
}

/// Whether forces are those of so many frames, or none are given.
///
/// # Errors
/// Says that they are not.
pub fn check_forces(forces_n: &[f64], frames: usize) -> Result<(), String> {
    let forces = forces_n.len();
    match forces == 0 || forces == frames {
        true => Ok(()),
        false => Err(format!("gives {forces} forces for {frames} frames")),
    }
}

impl<'a> Frames<'a> {
    /// Frames with the depth, mm, and where it was measured the force, N, of each one's press.
    pub fn of((camera, wavelength_nm): &'a (Camera, f64), images: &[&'a GreyImage], press: Presses<'_>) -> Self {
        let Presses { depths_mm, forces_n, force_error } = press;
        let frame = |(k, image): (usize, &&'a GreyImage)| {
            let depth_mm = depths_mm.get(k).copied()?;
            Some(PressFrame { depth_mm, image, force_n: forces_n.get(k).copied() })
        };
        let frames = images.iter().enumerate().filter_map(frame).collect();
        Self { camera, wavelength_nm: *wavelength_nm, frames, force_error }
    }
}

/// What is known of the presses of frames.
#[derive(Debug, Clone, Copy)]
pub struct Presses<'a> {
    /// Their depths, mm.
    pub depths_mm: &'a [f64],
    /// Their forces, N; none where they were not measured.
    pub forces_n: &'a [f64],
    /// Relative standard deviation of the forces.
    pub force_error: f64,
}

impl PressFrame<'_> {
    /// Whether it is of the press to a depth, mm.
    pub(super) fn is_of(&self, depth_mm: f64) -> bool {
        same_depth(self.depth_mm, depth_mm)
    }
}

impl Frames<'_> {
    /// The frame of a load.
    pub(super) fn at(&self, depth_mm: f64) -> Option<&PressFrame<'_>> {
        self.frames.iter().find(|frame| frame.is_of(depth_mm))
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
        let reader = Reader::new(self.camera, self.wavelength_nm)?;
        let read = |pixels: Vec<usize>| {
            if pixels.iter().any(|&pixel| frame.is_saturated(pixel)) {
                return None;
            }
            let mean = pixels.iter().filter_map(|&pixel| frame.grey().get(pixel)).sum::<f64>() / pixels.len() as f64;
            reader.read(mean, &pixels)
        };
        Ok(blocks.pixels(self.camera.pixels).into_iter().map(read).collect())
    }
}
