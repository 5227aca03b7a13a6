//! Rules of the camera: image, place, lens, sensor.

use super::bounds::{NOT_NEGATIVE, POSITIVE, above, number, whole};
use super::{Invalid, all};
use crate::scene::{Camera, Lens, Sensor};
use std::ops::Bound;

/// Pixels of an image: mean and variance in f32 are then half a gigabyte.
const MAX_PIXELS: u64 = 64_000_000;

pub(super) fn check(camera: &Camera) -> Result<(), Invalid> {
    // The lens is a disc parallel to the lowest face, which does not deform: with a positive distance no part of it is
    // in the glass.
    let focus = match camera.lens {
        Lens::ThinLens { focus_mm } => number("camera.lens.focus_mm", focus_mm, POSITIVE, 25.0),
        Lens::Pinhole => Ok(()),
    };
    all([
        pixels(camera),
        number("camera.pixel_pitch_um", camera.pixel_pitch_um, POSITIVE, 4.65),
        number("camera.view_angle_deg", camera.view_angle_deg, above(0.0, 179.0, false), 60.0),
        distance(camera.distance_mm),
        focus,
        sensor(&camera.sensor),
    ])
}

fn pixels(camera: &Camera) -> Result<(), Invalid> {
    let side = |axis: usize| whole(&format!("camera.pixels[{axis}]"), camera.pixels[axis].into(), 1..=8192, 1024);
    all([side(0), side(1)])?;
    let pixels = u64::from(camera.pixels[0]) * u64::from(camera.pixels[1]);
    if pixels > MAX_PIXELS {
        let message = format!("must be at most {MAX_PIXELS} pixels together, are {pixels}; for example [1392, 1042]");
        return Err(Invalid::new("camera.pixels", message));
    }
    Ok(())
}

fn distance(distance_mm: f64) -> Result<(), Invalid> {
    if distance_mm <= 0.0 {
        let message =
            format!("the camera would be inside the glass: must be positive, is {distance_mm}; for example 17.32");
        return Err(Invalid::new("camera.distance_mm", message));
    }
    number("camera.distance_mm", distance_mm, POSITIVE, 17.32)
}

fn sensor(sensor: &Sensor) -> Result<(), Invalid> {
    let black_level = match whole("camera.sensor.bit_depth", sensor.bit_depth.into(), 8..=16, 8) {
        Ok(()) => {
            let white = f64::from((1_u32 << sensor.bit_depth) - 1);
            let below_white = (Bound::Included(0.0), Bound::Excluded(white));
            number("camera.sensor.black_level", sensor.black_level, below_white, 0.0)
        }
        wrong_depth => wrong_depth,
    };
    all([
        // No lens in air is faster than f/0.5 (the sine condition).
        number("camera.sensor.f_number", sensor.f_number, (Bound::Excluded(0.5), Bound::Unbounded), 2.8),
        number("camera.sensor.exposure_ms", sensor.exposure_ms, POSITIVE, 10.0),
        number("camera.sensor.quantum_efficiency", sensor.quantum_efficiency, 0.0..=1.0, 0.47),
        number("camera.sensor.full_well_e", sensor.full_well_e, POSITIVE, 15_000.0),
        number("camera.sensor.read_noise_e", sensor.read_noise_e, NOT_NEGATIVE, 9.0),
        number("camera.sensor.dark_current_e_per_s", sensor.dark_current_e_per_s, NOT_NEGATIVE, 1.0),
        black_level,
        number("camera.sensor.vignetting_corner_loss", sensor.vignetting_corner_loss, 0.0..=1.0, 0.1),
        number("camera.sensor.ambient_w_per_m2_sr", sensor.ambient_w_per_m2_sr, NOT_NEGATIVE, 0.0),
    ])
}
