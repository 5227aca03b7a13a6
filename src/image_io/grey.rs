//! Grey images: what a camera saw, from PNG, TIFF or EXR.

use super::exr_chunks::with_exr;
use super::radiance::check_values;
use super::{ImageError, limits};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Weights of red, green and blue in luma (Recommendation ITU-R BT.709).
const LUMA: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// A grey image, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct GreyImage {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major: grey levels of a PNG or TIFF, the values of an EXR as they are.
    pub values: Vec<f64>,
    /// The highest grey level; none for an EXR, which has no end.
    pub full_scale: Option<f64>,
    /// Whether the values are known to be proportional to the light (EXR).
    pub linear: bool,
}

/// Reads a grey image. Colour becomes luma and transparency is dropped; of an EXR the channel `mean`, else `Y`, else the
/// first one is taken.
///
/// # Errors
/// When the file is missing, damaged, too large, of another format, or holds a value that is not finite.
pub fn read_grey(path: &Path) -> Result<GreyImage, ImageError> {
    match is_exr(path) {
        true => with_exr(path, |file| {
            let names = ["mean", "Y"];
            let find = |name: &&str| file.header.channels.iter().position(|channel| channel.name == **name);
            let values = file.channel(names.iter().find_map(find).unwrap_or(0))?;
            from_exr(path, [file.header.width, file.header.height], &values)
        }),
        false => read_levels(path),
    }
}

pub(super) fn is_exr(path: &Path) -> bool {
    has_extension(path, "exr")
}

pub(super) fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

pub(super) fn from_exr(path: &Path, [width, height]: [usize; 2], values: &[f32]) -> Result<GreyImage, ImageError> {
    check_values(path, width, values, "a finite number", f32::is_finite)?;
    Ok(GreyImage {
        width: width as u32,
        height: height as u32,
        values: values.iter().map(|&value| value.into()).collect(),
        full_scale: None,
        linear: true,
    })
}

/// Reads a PNG or TIFF of 8 or 16 bits.
pub(super) fn read_levels(path: &Path) -> Result<GreyImage, ImageError> {
    let damaged = |error: image::ImageError| ImageError::Damaged { path: path.into(), reason: error.to_string() };
    let unsupported = |reason: &str| ImageError::Unsupported { path: path.into(), reason: reason.into() };
    let bytes = limits::read_file(path)?;
    let format = image::guess_format(&bytes).ok();
    if !matches!(format, Some(ImageFormat::Png | ImageFormat::Tiff)) {
        return Err(unsupported("not an image that is read here; give PNG, TIFF or EXR"));
    }
    let mut reader = ImageReader::new(Cursor::new(&bytes))
        .with_guessed_format()
        .map_err(|source| ImageError::Read { path: path.into(), source })?;
    let mut bounds = Limits::default();
    bounds.max_image_width = Some(limits::DIMENSION as u32);
    bounds.max_image_height = Some(limits::DIMENSION as u32);
    bounds.max_alloc = Some(limits::DECODER_BYTES);
    reader.limits(bounds);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    limits::check_size(path, width.into(), height.into())?;
    let image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let (full_scale, values) = match &image {
        DynamicImage::ImageLuma8(grey) => (255.0, levels(grey, 1)),
        DynamicImage::ImageLumaA8(grey) => (255.0, levels(grey, 2)),
        DynamicImage::ImageRgb8(colour) => (255.0, levels(colour, 3)),
        DynamicImage::ImageRgba8(colour) => (255.0, levels(colour, 4)),
        DynamicImage::ImageLuma16(grey) => (65535.0, levels(grey, 1)),
        DynamicImage::ImageLumaA16(grey) => (65535.0, levels(grey, 2)),
        DynamicImage::ImageRgb16(colour) => (65535.0, levels(colour, 3)),
        DynamicImage::ImageRgba16(colour) => (65535.0, levels(colour, 4)),
        _ => {
            return Err(unsupported("an image of floating-point samples; give 8 or 16 bits, or EXR"));
        }
    };
    Ok(GreyImage { width, height, values, full_scale: Some(full_scale), linear: false })
}

/// Grey levels of interleaved samples of 1 (grey), 2 (grey, alpha), 3 (colour) or 4 (colour, alpha) channels.
fn levels<T: Copy + Into<f64>>(samples: &[T], channels: usize) -> Vec<f64> {
    let level = |pixel: &[T]| match *pixel {
        [red, green, blue, ..] => {
            let [r, g, b] = [red, green, blue].map(Into::into);
            // Grey stored as colour stays exactly what it is.
            if r == g && g == b { r } else { LUMA[0] * r + LUMA[1] * g + LUMA[2] * b }
        }
        [grey, ..] => grey.into(),
        [] => 0.0,
    };
    samples.chunks_exact(channels).map(level).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{write_png_grey, write_png_rgb};
    use super::*;

    #[test]
    fn grey_levels_come_back_in_both_depths() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("grey.png");
        for (depth, levels, full) in
            [(8, [0, 1, 2, 128, 254, 255], 255.0), (16, [0, 1, 255, 256, 65534, 65535], 65535.0)]
        {
            write_png_grey(&path, 3, 2, &levels, depth).unwrap();
            let grey = read_grey(&path).unwrap();
            assert_eq!((grey.width, grey.height, grey.full_scale, grey.linear), (3, 2, Some(full), false));
            assert_eq!(grey.values, levels.map(f64::from));
        }
    }

    #[test]
    fn colour_becomes_luma_and_grey_in_colour_stays() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("colour.png");
        write_png_rgb(&path, 2, 1, &[100, 200, 50, 77, 77, 77]).unwrap();
        let values = read_grey(&path).unwrap().values;
        // 0.2126 * 100 + 0.7152 * 200 + 0.0722 * 50, to the rounding of three products.
        assert!((values[0] - 167.91).abs() < 1e-12, "{values:?}");
        assert_eq!(values[1], 77.0);
    }

    #[test]
    fn pictures_that_do_not_fit_are_refused_on_writing() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("grey.png");
        let unsupported = |result: Result<(), ImageError>| matches!(result, Err(ImageError::Unsupported { .. }));
        assert!(unsupported(write_png_grey(&path, 2, 1, &[0, 256], 8)));
        assert!(unsupported(write_png_grey(&path, 2, 1, &[0, 1], 12)));
        assert!(unsupported(write_png_grey(&path, 2, 2, &[0, 1], 8)));
        assert!(unsupported(write_png_rgb(&path, 2, 2, &[0; 11])));
        assert!(!path.exists());
    }
}
