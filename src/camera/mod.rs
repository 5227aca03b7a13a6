//! From radiance to grey values: where each pixel looks, how many electrons it collects, what it reads.
//!
//! Pixel coordinates are (column, row) in pixels from the upper left corner of the image; the centre of the first
//! pixel is (0.5, 0.5). Columns run along +x and rows against +y, as in [`crate::film::Film`].

pub mod exposure;
pub mod noise;
pub mod projection;
pub mod reading;
pub mod saturation;
pub mod suited;

pub use exposure::{ExposureError, Frame, expected_electrons, expose, top_grey};
pub use projection::{ProjectionError, View, mm_per_pixel};
pub use reading::{Response, Signal};
pub use saturation::Saturation;
pub use suited::Suited;
