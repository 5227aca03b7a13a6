//! Image files: radiance as EXR and `.npy`, grey images and grids from EXR, PNG, TIFF and CSV, pictures as PNG.
//!
//! Files come from anywhere, so sizes are checked against [`limits`] before anything is decoded, and a damaged file is
//! an [`ImageError`], never a panic.

mod error;
mod exr_chunks;
mod exr_header;
mod grey;
mod grid;
#[cfg(test)]
mod hostile;
pub mod limits;
mod npy;
mod pair;
mod picture;
mod radiance;
mod tiff_pages;

pub use error::ImageError;
pub use grey::{GreyFile, read_grey};
pub use grid::{Grid, grid_of};
pub use npy::write_npy;
pub use pair::Pair;
pub use picture::{write_png_grey, write_png_rgb};
pub use radiance::{Provenance, read_radiance, write_radiance, write_radiance_as};
