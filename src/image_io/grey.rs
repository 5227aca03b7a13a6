//! Grey images: what a camera saw, from PNG, TIFF or EXR.

use super::exr_chunks::with_exr;
use super::radiance::check_values;
use super::tiff_pages::tiff_pages;
use super::{ImageError, limits};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Weights of red, green and blue in luma (Recommendation ITU-R BT.709).
const LUMA: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// A grey image, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct GreyFile {
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

impl GreyFile {
    /// The same image of a camera of `bits` bits, whose levels lie in a file of more: levels then end at 2^bits - 1.
    /// An EXR, which has no grey levels, stays as it is.
    ///
    /// # Errors
    /// When the file has fewer bits, or a level is above that.
    pub fn with_bits(self, bits: u32, path: &Path) -> Result<Self, ImageError> {
        let Some(of_file) = self.full_scale else { return Ok(self) };
        let full_scale = 2f64.powi(bits as i32) - 1.0;
        if full_scale > of_file {
            let found = (of_file + 1.0).log2();
            let reason = format!("has {found} bits a grey value, which cannot hold the {bits} bits that are declared");
            return Err(ImageError::Unsupported { path: path.into(), reason });
        }
        // Luma of colours at full scale may round to a hair above it.
        let above = |value: &f64| *value > full_scale * (1.0 + 1e-9);
        if let Some(index) = self.values.iter().position(above) {
            let width = self.width as usize;
            return Err(ImageError::Value {
                path: path.into(),
                row: index / width + 1,
                column: index % width + 1,
                found: format!("grey level {}", self.values[index]),
                right: "within the full scale that is declared",
            });
        }
        Ok(Self { full_scale: Some(full_scale), ..self })
    }
}

/// Reads a grey image. Colour becomes luma and transparency is dropped; of an EXR the channel `mean`, else `Y`, else
/// the first one is taken.
///
/// # Errors
/// When the file is missing, damaged, too large, of another format, or holds a value that is not finite.
pub fn read_grey(path: &Path) -> Result<GreyFile, ImageError> {
    match is_exr(path) {
        true => with_exr(path, |file| {
            let names = ["mean", "Y"];
            let find = |name: &&str| file.header.channels.iter().position(|channel| channel.name == **name);
            let values = file.channel(names.iter().find_map(find).unwrap_or(0))?;
            from_exr(path, [file.header.width, file.header.height], &values)
        }),
        false => levels_of(path, &limits::read_file(path)?),
    }
}

pub(super) fn is_exr(path: &Path) -> bool {
    has_extension(path, "exr")
}

pub(super) fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

pub(super) fn from_exr(path: &Path, [width, height]: [usize; 2], values: &[f32]) -> Result<GreyFile, ImageError> {
    check_values(path, width, values, "a finite number", f32::is_finite)?;
    Ok(GreyFile {
        width: width as u32,
        height: height as u32,
        values: values.iter().map(|&value| value.into()).collect(),
        full_scale: None,
        linear: true,
    })
}

/// The grey levels of a PNG or TIFF of 8 or 16 bits.
pub(super) fn levels_of(path: &Path, bytes: &[u8]) -> Result<GreyFile, ImageError> {
    let unsupported = |reason: String| ImageError::Unsupported { path: path.into(), reason };
    let damaged = |error: image::ImageError| match error {
        image::ImageError::Unsupported(kind) => unsupported(format!("{kind}; give 8 or 16 bits a sample")),
        other => ImageError::Damaged { path: path.into(), reason: other.to_string() },
    };
    check_kind(bytes).map_err(unsupported)?;
    let mut reader = ImageReader::new(Cursor::new(bytes))
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
        _ => return Err(unsupported(FLOATING_POINT.into())),
    };
    Ok(GreyFile { width, height, values, full_scale: Some(full_scale), linear: false })
}

const FLOATING_POINT: &str = "has floating-point samples; give 8 or 16 bits a sample, or an EXR";

/// Refuses what is no PNG and no TIFF of one page of whole numbers, by its name.
fn check_kind(bytes: &[u8]) -> Result<(), String> {
    match image::guess_format(bytes) {
        Ok(ImageFormat::Png) => Ok(()),
        Ok(ImageFormat::Tiff) => match tiff_pages(bytes) {
            pages if pages.count > 1 => Err(format!(
                "has {} pages, of which only the first would be read; give each page as a file of its own",
                pages.count
            )),
            pages if pages.floating_point => Err(FLOATING_POINT.into()),
            _ => Ok(()),
        },
        Ok(ImageFormat::Jpeg) => {
            Err("is a JPEG, whose compression alters grey levels; give PNG or TIFF from the camera".into())
        }
        Ok(other) => {
            let name = other.extensions_str().first().map_or_else(String::new, |name| name.to_uppercase());
            Err(format!("is a {name} image, which is not read here; convert it to PNG, TIFF or EXR"))
        }
        Err(_) => Err("not an image that is read here; give PNG, TIFF or EXR".into()),
    }
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

    /// A grey TIFF of one row of zeros: byte order, samples a pixel's bits and format, and how often its page is told.
    fn tiff(big_endian: bool, [bits, format]: [u16; 2], pages: u32) -> Vec<u8> {
        let short = |n: u16| if big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let long = |n: u32| if big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let mut bytes = if big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        bytes.extend(short(42));
        bytes.extend(long(16));
        bytes.extend([0; 8]);
        // Width, height, bits, compression none, black is zero, place, rows, bytes of the strip, format.
        let strip = u32::from(bits) / 8;
        let entries = [
            (256, 1),
            (257, 1),
            (258, bits.into()),
            (259, 1),
            (262, 1),
            (273, 8),
            (278, 1),
            (279, strip),
            (339, format.into()),
        ];
        for page in 0..pages {
            bytes.extend(short(entries.len() as u16));
            for (tag, value) in entries {
                let is_short = tag == 258 || tag == 339;
                bytes.extend(short(tag));
                bytes.extend(short(if is_short { 3 } else { 4 }));
                bytes.extend(long(1));
                match is_short {
                    true => bytes.extend([short(value as u16), [0; 2]].concat()),
                    false => bytes.extend(long(value)),
                }
            }
            let next = if page + 1 < pages { bytes.len() as u32 + 4 } else { 0 };
            bytes.extend(long(next));
        }
        bytes
    }

    #[test]
    fn pages_and_kinds_of_sample_are_refused_by_name() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("image");
        let read = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read_grey(&path).map_err(|error| error.to_string())
        };
        for big_endian in [false, true] {
            let grey = read(&tiff(big_endian, [16, 1], 1)).unwrap();
            assert_eq!((grey.values, grey.full_scale), (vec![0.0], Some(65535.0)));
            let refused = read(&tiff(big_endian, [8, 1], 3)).unwrap_err();
            assert!(refused.contains("has 3 pages") && refused.contains("file of its own"), "{refused}");
            for bits in [32, 64] {
                let refused = read(&tiff(big_endian, [bits, 3], 1)).unwrap_err();
                assert!(refused.contains("floating-point"), "{refused}");
            }
        }
        for (start, name) in [
            (&b"\xff\xd8\xff\xe0\0\x10JFIF\0"[..], "JPEG"),
            (b"BM\x46\0\0\0", "BMP"),
            (b"GIF89a", "GIF"),
            (b"RIFF\0\0\0\0WEBP", "WEBP"),
        ] {
            let refused = read(start).unwrap_err();
            assert!(refused.contains(name) && refused.contains("PNG"), "{name}: {refused}");
        }
        assert!(read(b"what is this").unwrap_err().contains("not an image"));
    }

    #[test]
    fn directories_that_point_at_themselves_end() {
        let mut bytes = tiff(false, [8, 1], 2);
        let last = bytes.len() - 4;
        bytes[last..].copy_from_slice(&16u32.to_le_bytes());
        assert!(tiff_pages(&bytes).count > 2);
        for length in 0..bytes.len() {
            // Cut off anywhere: an answer, no panic.
            assert!(tiff_pages(&bytes[..length]).count <= 2);
        }
    }

    #[test]
    fn a_declared_full_scale_bounds_the_levels() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("grey.png");
        write_png_grey(&path, 3, 1, &[0, 4095, 16383], 16).unwrap();
        let read = || read_grey(&path).unwrap();
        assert_eq!(read().with_bits(14, &path).unwrap().full_scale, Some(16383.0));
        let refused = read().with_bits(12, &path).unwrap_err();
        assert!(matches!(refused, ImageError::Value { row: 1, column: 3, .. }), "{refused}");
        write_png_grey(&path, 1, 1, &[255], 8).unwrap();
        assert_eq!(read().with_bits(8, &path).unwrap().full_scale, Some(255.0));
        let refused = read().with_bits(12, &path).unwrap_err().to_string();
        assert!(refused.contains("has 8 bits"), "{refused}");
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
