//! PNG pictures, written.

use super::{ImageError, limits};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::path::Path;

/// Writes grey levels, row-major, as a PNG of 8 or 16 bits.
///
/// # Errors
/// When the number of levels is not width times height, a level or the depth does not fit, or the file cannot be
/// written.
pub fn write_png_grey(path: &Path, width: u32, height: u32, levels: &[u16], bit_depth: u32) -> Result<(), ImageError> {
    let unsupported = |reason: String| ImageError::Unsupported { path: path.into(), reason };
    match bit_depth {
        8 => {
            let narrow: Result<Vec<u8>, _> = levels.iter().map(|&level| u8::try_from(level)).collect();
            let narrow = narrow.map_err(|_| unsupported("a grey level above 255 in a picture of 8 bits".into()))?;
            write_png(path, width, height, &narrow, ExtendedColorType::L8)
        }
        16 => {
            let wide: Vec<u8> = levels.iter().flat_map(|level| level.to_ne_bytes()).collect();
            write_png(path, width, height, &wide, ExtendedColorType::L16)
        }
        depth => Err(unsupported(format!("a PNG of {depth} bits; write 8 or 16"))),
    }
}

/// Writes red, green and blue bytes, interleaved and row-major, as a PNG.
///
/// # Errors
/// When there are not three bytes for each pixel, or the file cannot be written.
pub fn write_png_rgb(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<(), ImageError> {
    write_png(path, width, height, rgb, ExtendedColorType::Rgb8)
}

fn write_png(path: &Path, width: u32, height: u32, bytes: &[u8], colour: ExtendedColorType) -> Result<(), ImageError> {
    let unsupported = |reason: String| ImageError::Unsupported { path: path.into(), reason };
    let expected = u64::from(width) * u64::from(height) * u64::from(colour.bits_per_pixel() / 8);
    // The encoder panics where these differ.
    if expected != bytes.len() as u64 || expected == 0 {
        return Err(unsupported(format!("{} bytes for a picture of {width}x{height} pixels", bytes.len())));
    }
    let mut file = Vec::new();
    let written = PngEncoder::new(&mut file).write_image(bytes, width, height, colour);
    written.map_err(|error| unsupported(error.to_string()))?;
    limits::write_file(path, &file)
}
