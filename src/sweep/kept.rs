//! Which images of its points a sweep keeps, and what is known of one that was kept.

use crate::camera::noise::PixelRandom;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Apart from all else that a seed is used for.
const SPLIT: u32 = 0x7e57_5917;

/// Which images of a point are kept.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Images {
    /// The camera's grey frame, or the radiance.
    #[serde(default)]
    pub format: Format,
    /// Of the press's last load, or of all. Default: `last`.
    #[serde(default)]
    pub loads: Loads,
    /// The frame of the phantom without inclusions too, at the last load.
    #[serde(default)]
    pub baseline: bool,
    /// A mask of what lies over an inclusion: its true outline, as the camera would see it on the touched face.
    #[serde(default)]
    pub masks: bool,
    /// The contact pressure of each image's load where its pixels see the touched face, kPa: an array of NumPy's.
    #[serde(default)]
    pub pressures: bool,
    /// Share of the points whose images are for testing. Default: 0.
    #[serde(default)]
    pub test_share: f64,
}

/// What an image file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// Grey levels, as the camera gives them.
    #[default]
    Png,
    /// Radiance with its variance, W/(m^2 sr).
    Exr,
    /// Radiance, W/(m^2 sr), as an array of NumPy's: (rows, columns), 32-bit floats.
    Npy,
}

/// Which loads are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Loads {
    /// The last.
    #[default]
    Last,
    /// Each one.
    All,
}

/// An image that was kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Its file, within its split.
    pub file: String,
    /// Its load; none where nothing is pressed.
    pub load: Option<KeptLoad>,
    /// Millimetres on the touched face a pixel, on the axis.
    pub mm_per_pixel: f64,
    /// The random streams of light and sensor.
    pub streams: [u32; 2],
}

impl Kept {
    /// Force of its load, N; none where nothing is pressed.
    pub fn force_n(&self) -> Option<f64> {
        self.load.map(|load| load.force_n)
    }
}

/// The load of an image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "Recorded")]
pub struct KeptLoad {
    /// Which, from 0.
    pub number: usize,
    /// Motion of the phantom's base towards the sensor, mm.
    pub depth_mm: f64,
    /// Total force, N.
    pub force_n: f64,
    /// Motion of the base along x and y, mm.
    pub slide_mm: [f64; 2],
    /// Time for which it was held before, s.
    pub hold_s: f64,
}

/// As records have it: before slides were kept as three numbers.
#[derive(Deserialize)]
#[serde(untagged)]
enum Recorded {
    Whole { number: usize, depth_mm: f64, force_n: f64, slide_mm: [f64; 2], hold_s: f64 },
    Numbers(usize, f64, f64),
}

impl From<Recorded> for KeptLoad {
    fn from(recorded: Recorded) -> Self {
        match recorded {
            Recorded::Whole { number, depth_mm, force_n, slide_mm, hold_s } => {
                Self { number, depth_mm, force_n, slide_mm, hold_s }
            }
            Recorded::Numbers(number, depth_mm, force_n) => {
                Self { number, depth_mm, force_n, slide_mm: [0.0; 2], hold_s: 0.0 }
            }
        }
    }
}

impl Images {
    /// Whether a point's images are for testing: by its row alone, so that a larger sweep splits the same.
    pub fn is_test(&self, row: usize) -> bool {
        PixelRandom::new(SPLIT, row as u32).uniform() < self.test_share
    }

    /// Folder of a point's images.
    pub fn split(&self, row: usize) -> &'static str {
        if self.is_test(row) { "test" } else { "train" }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn loads_of_earlier_records_are_read() {
        let load = KeptLoad { number: 1, depth_mm: 2.0, force_n: 0.5, slide_mm: [3.0, 0.0], hold_s: 1.0 };
        let read = |text: &str| serde_json::from_str::<KeptLoad>(text).unwrap();
        assert_eq!(read(&serde_json::to_string(&load).unwrap()), load);
        assert_eq!(read("[1, 2.0, 0.5]"), KeptLoad { slide_mm: [0.0; 2], hold_s: 0.0, ..load });
    }

    #[test]
    fn a_split_is_of_the_row_alone() {
        let images = |test_share| Images { test_share, ..Images::default() };
        let count = |share| (0..10_000).filter(|&row| images(share).is_test(row)).count();
        assert_eq!(count(0.0), 0);
        // 2000 and three standard deviations of 40.
        assert!((1880..=2120).contains(&count(0.2)), "{}", count(0.2));
        assert!((0..1000).all(|row| !images(0.2).is_test(row) || images(0.3).is_test(row)));
    }
}
