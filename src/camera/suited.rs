//! Which exposure time would suit an image.
//!
//! All electrons that are expected of a pixel grow with the exposure time: signal, ambient light and dark current. So
//! the time at which a pixel fills a given share of its well follows from one frame, saturated or not.

use super::exposure::{ExposureError, expected_electrons, top_grey};
use crate::film::Film;
use crate::scene::Camera;

/// The pixel that is exposed for: this share of those that get light are dimmer. The brightest hundredth may be glints.
const PERCENTILE: f64 = 0.99;
/// How full its well is then: shot noise of a well of 15,000 electrons is 1 % there, so that noise does not clip.
const WANTED: f64 = 0.8;
/// Largest share of dark current in it.
const MOST_DARK: f64 = 0.5;
/// Below this it is too dark: 25 of 255 grey levels, where rounding alone is 1 % of them.
const DIM: f64 = 0.1;

/// How an image suits its exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Suited {
    /// No time would suit: the reason.
    Undefined(&'static str),
    /// The brightest lit percentile fills this share of its well; `suggested_ms` would suit it.
    Filled {
        /// Expected electrons over those at the top grey level.
        share: f64,
        /// Exposure time at which the share is 0.8, ms.
        suggested_ms: f64,
    },
}

impl Suited {
    /// What exposure suits a film and its camera.
    ///
    /// # Errors
    /// As [`expected_electrons`].
    pub fn of(film: &Film, camera: &Camera, wavelength_nm: f64) -> Result<Self, ExposureError> {
        let electrons = expected_electrons(film, camera, wavelength_nm)?;
        let lit = electrons.iter().zip(&film.mean).filter(|(_, radiance)| **radiance > 0.0);
        let mut lit: Vec<f64> = lit.map(|(&electrons, _)| electrons).collect();
        lit.sort_by(f64::total_cmp);
        let Some(&brightest) = lit.get((lit.len().saturating_sub(1) as f64 * PERCENTILE) as usize) else {
            return Ok(Self::Undefined("no pixel gets light"));
        };
        let sensor = &camera.sensor;
        // The black level takes grey levels from the top.
        let usable = sensor.full_well_e * (1.0 - sensor.black_level / f64::from(top_grey(sensor.bit_depth)));
        let share = brightest / usable;
        let suggested_ms = WANTED / share * sensor.exposure_ms;
        let dark = sensor.dark_current_e_per_s * 1e-3 * suggested_ms;
        if dark > MOST_DARK * WANTED * usable {
            return Ok(Self::Undefined("the light is too dim: dark current would fill the wells before it"));
        }
        Ok(match suggested_ms.is_finite() && suggested_ms > 0.0 {
            true => Self::Filled { share, suggested_ms },
            false => Self::Undefined("no electrons are expected of the light"),
        })
    }

    /// The time that would suit, ms.
    pub fn suggested_ms(&self) -> Option<f64> {
        match self {
            Self::Filled { suggested_ms, .. } => Some(*suggested_ms),
            Self::Undefined(_) => None,
        }
    }

    /// Whether the image is too dark.
    pub fn is_dim(&self) -> bool {
        matches!(self, Self::Filled { share, .. } if *share < DIM)
    }

    /// Whether a hundredth of what is lit, or more, is expected to saturate.
    pub fn is_saturated(&self) -> bool {
        matches!(self, Self::Filled { share, .. } if *share > 1.0)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{Camera, preset};

    fn camera(exposure_ms: f64) -> Camera {
        let mut camera = preset("tsis-paper").unwrap().scene.camera;
        camera.pixels = [50, 40];
        camera.sensor.exposure_ms = exposure_ms;
        (camera.sensor.black_level, camera.sensor.dark_current_e_per_s) = (10.0, 100.0);
        camera
    }

    /// A ramp of radiance over the lit half; the other is dark.
    fn film(most: f32) -> Film {
        let pixel = |i: u32| if i < 1000 { most * (i + 1) as f32 / 1000.0 } else { 0.0 };
        Film { width: 50, height: 40, mean: (0..2000).map(pixel).collect(), ..Film::default() }
    }

    #[test]
    fn at_the_suggested_time_the_brightest_lit_percentile_is_at_four_fifths_of_the_levels() {
        for most in [1e-4f32, 1.0, 1e3] {
            let suited = Suited::of(&film(most), &camera(10.0), 532.0).unwrap();
            let suggested = camera(suited.suggested_ms().unwrap());
            let Suited::Filled { share, suggested_ms } = Suited::of(&film(most), &suggested, 532.0).unwrap() else {
                panic!("lit");
            };
            assert!((share - WANTED).abs() < 1e-12, "{most}: {share}");
            assert!((suggested_ms / suggested.sensor.exposure_ms - 1.0).abs() < 1e-12, "it is its own suggestion");
            // By the electrons themselves: the hundredth brightest of the 1000 lit pixels.
            let mut electrons = expected_electrons(&film(most), &suggested, 532.0).unwrap();
            electrons.truncate(1000);
            electrons.sort_by(f64::total_cmp);
            let levels = electrons[989] / suggested.sensor.full_well_e * 255.0;
            assert!((levels - WANTED * 245.0).abs() < 1e-9, "{most}: {levels}");
        }
    }

    #[test]
    fn too_dark_and_too_bright_are_told_apart_and_darkness_has_no_answer() {
        let suited = |film: &Film, ms: f64| Suited::of(film, &camera(ms), 532.0).unwrap();
        let right = suited(&film(1.0), 10.0).suggested_ms().unwrap();
        let verdict = |ms: f64| (suited(&film(1.0), ms).is_dim(), suited(&film(1.0), ms).is_saturated());
        assert_eq!(verdict(right), (false, false));
        assert_eq!(verdict(0.12 * right), (true, false));
        assert_eq!(verdict(1.26 * right), (false, true));
        assert!(matches!(suited(&film(0.0), 10.0), Suited::Undefined(_)));
        let mut blind = camera(10.0);
        (blind.sensor.quantum_efficiency, blind.sensor.dark_current_e_per_s) = (0.0, 0.0);
        assert!(matches!(Suited::of(&film(1.0), &blind, 532.0).unwrap(), Suited::Undefined(_)));
    }
}
