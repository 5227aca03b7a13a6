//! The camera: geometry, lens and sensor.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The camera under the stack, on the axis, looking up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Pixel pitch, um.
    pub pixel_pitch_um: f64,
    /// Full view angle, degrees, across `view_axis`.
    pub view_angle_deg: f64,
    /// Which extent of the image the view angle spans.
    #[serde(default)]
    pub view_axis: ViewAxis,
    /// Distance from the pinhole (or lens) to the lowest face of the stack, mm.
    pub distance_mm: f64,
    /// Pinhole or thin lens.
    #[serde(default)]
    pub lens: Lens,
    /// Sensor and exposure; used for the camera image, not for the radiance.
    #[serde(default)]
    pub sensor: Sensor,
}

impl Camera {
    /// Divides the columns and rows by so many, to 4 at the least, over the same view.
    pub fn shrink(&mut self, by: u32) {
        let before = self.pixels[0];
        self.pixels = self.pixels.map(|pixels| (pixels / by.max(1)).max(4));
        self.pixel_pitch_um *= f64::from(before) / f64::from(self.pixels[0]);
    }
}

/// Which extent of the image the view angle spans.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ViewAxis {
    /// Across the columns.
    #[default]
    Width,
    /// Across the rows.
    Height,
    /// From corner to corner.
    Diagonal,
}

/// How the camera gathers light.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Lens {
    /// Everything sharp; sees without taking light.
    #[default]
    Pinhole,
    /// A thin lens of the sensor's f-number.
    ThinLens {
        /// Distance from the lens to the plane in focus, measured in air, mm.
        focus_mm: f64,
    },
}

/// Sensor and exposure. Defaults are placeholders of the sensor class (docs/PHYSICS.md).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Focal ratio of the lens; sets the irradiance on the sensor (and the pupil of a thin lens).
    pub f_number: f64,
    /// Exposure time, ms.
    pub exposure_ms: f64,
    /// Share of photons that become electrons, 0 to 1.
    pub quantum_efficiency: f64,
    /// Electrons at saturation.
    pub full_well_e: f64,
    /// Read noise, electrons rms.
    pub read_noise_e: f64,
    /// Dark current, electrons per second and pixel.
    pub dark_current_e_per_s: f64,
    /// Bits per grey value, 8 to 16.
    pub bit_depth: u32,
    /// Grey levels added before quantisation.
    pub black_level: f64,
    /// Light lost at the corner of the image beside the cos^4 law, 0 to 1.
    pub vignetting_corner_loss: f64,
    /// Stray light that reaches every pixel alike, as radiance, W/(m^2 sr).
    pub ambient_w_per_m2_sr: f64,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            f_number: 2.8,
            exposure_ms: 10.0,
            quantum_efficiency: 0.47,
            full_well_e: 15_000.0,
            read_noise_e: 9.0,
            dark_current_e_per_s: 1.0,
            bit_depth: 8,
            black_level: 0.0,
            vignetting_corner_loss: 0.0,
            ambient_w_per_m2_sr: 0.0,
        }
    }
}
