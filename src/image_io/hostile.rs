//! Files from anywhere: cut off, altered, or made to ask for too much. An error each time, never a panic.
#![allow(clippy::unwrap_used)]

use super::*;
use exr::prelude::*;
use proptest::prelude::*;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const SIZE: (usize, usize) = (37, 41);

/// An EXR of smooth light with a little texture, so that every compressor has something to do.
fn exr_bytes(compression: Compression, half: bool) -> Vec<u8> {
    let value = |index: usize| ((index % 37) as f32 * 0.1).sin() + (index * 7919 % 13) as f32 * 0.01 + 2.0;
    let pixels: Vec<f32> = (0..SIZE.0 * SIZE.1).map(value).collect();
    let samples = |scale: f32| match half {
        true => FlatSamples::F16(pixels.iter().map(|&v| f16::from_f32(v * scale)).collect()),
        false => FlatSamples::F32(pixels.iter().map(|&v| v * scale).collect()),
    };
    let list = [("mean", 1.0), ("variance", 0.1)].map(|(name, scale)| AnyChannel::new(name, samples(scale)));
    let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let channels = AnyChannels::sort(list.into_iter().collect());
    let layer = Layer::new(SIZE, LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn picture_bytes(format: image::ImageFormat, wide: bool) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let level = |x: u32, y: u32| (x * 5 + y * 3) % 251;
    let picture: image::DynamicImage = match wide {
        true => image::ImageBuffer::from_fn(31, 23, |x, y| image::Luma([level(x, y) as u16 * 257])).into(),
        false => image::RgbImage::from_fn(31, 23, |x, y| image::Rgb([level(x, y) as u8, 7, y as u8])).into(),
    };
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Name and bytes of a sound file of each kind.
static FILES: LazyLock<Vec<(&str, Vec<u8>)>> = LazyLock::new(|| {
    vec![
        ("none.exr", exr_bytes(Compression::Uncompressed, false)),
        ("rle.exr", exr_bytes(Compression::RLE, false)),
        ("zips.exr", exr_bytes(Compression::ZIP1, false)),
        ("zip.exr", exr_bytes(Compression::ZIP16, true)),
        ("piz.exr", exr_bytes(Compression::PIZ, false)),
        ("piz_half.exr", exr_bytes(Compression::PIZ, true)),
        ("grey.png", picture_bytes(image::ImageFormat::Png, true)),
        ("colour.png", picture_bytes(image::ImageFormat::Png, false)),
        ("grey.tiff", picture_bytes(image::ImageFormat::Tiff, true)),
        ("colour.tiff", picture_bytes(image::ImageFormat::Tiff, false)),
        ("grid.csv", b"1, 2.5, -3e4\n4, 5, 6\n".to_vec()),
    ]
});

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

/// Reads by every reader; the results must be whole where there are any.
fn read_all(path: &Path) -> [bool; 3] {
    let film = read_radiance(path).map(|(film, _)| assert_eq!(film.mean.len(), film.variance.len()));
    let grey = read_grey(path).map(|grey| assert_eq!(grey.values.len(), (grey.width * grey.height) as usize));
    let grid = grid_of(path, &std::fs::read(path).unwrap())
        .map(|grid| assert!(grid.values.iter().all(|value| value.is_finite())));
    [film.is_ok(), grey.is_ok(), grid.is_ok()]
}

#[test]
fn every_sound_file_is_read() {
    let place = Place::new();
    for (name, bytes) in FILES.iter() {
        let [film, grey, grid] = read_all(&place.file(name, bytes));
        assert_eq!(film, name.ends_with("exr"), "{name}");
        assert_eq!(grey, !name.ends_with("csv"), "{name}");
        assert!(grid, "{name}");
    }
}

#[test]
fn all_lossless_compressions_give_the_same_pixels() {
    let place = Place::new();
    let read =
        |name: &str, compression| read_radiance(&place.file(name, &exr_bytes(compression, false))).unwrap().0.mean;
    let plain = read("none.exr", Compression::Uncompressed);
    for compression in [Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ] {
        assert_eq!(read("other.exr", compression), plain, "{compression:?}");
    }
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let place = Place::new();
    for (name, bytes) in FILES.iter().filter(|(name, _)| !name.ends_with("csv")) {
        // TIFF and PNG may end in bytes that carry no pixels: the last eighth is only required not to panic.
        let needed = if name.ends_with("exr") { bytes.len() } else { bytes.len() * 7 / 8 };
        for cut in (0..bytes.len()).step_by(bytes.len() / 150 + 1) {
            let results = read_all(&place.file(name, &bytes[..cut]));
            assert!(cut >= needed || results == [false; 3], "{name} cut to {cut} of {} was read", bytes.len());
        }
    }
}

#[test]
fn a_small_exr_that_asks_for_a_large_image_is_refused() {
    let (name, bytes) = &FILES[4];
    let mut bytes = bytes.clone();
    let key = b"dataWindow\0box2i\0";
    let start = bytes.windows(key.len()).position(|window| window == key).unwrap() + key.len() + 4;
    let window = [0_i32, 0, 8191, 8191].map(i32::to_le_bytes).concat();
    bytes[start..start + 16].copy_from_slice(&window);
    let refused = read_radiance(&Place::new().file(name, &bytes)).unwrap_err();
    assert!(matches!(refused, ImageError::TooLarge { .. }), "{refused}");
}

#[test]
fn a_picture_wider_than_the_limit_is_refused() {
    let place = Place::new();
    for (name, format) in [("wide.png", image::ImageFormat::Png), ("wide.tiff", image::ImageFormat::Tiff)] {
        let mut bytes = Cursor::new(Vec::new());
        image::GrayImage::new(limits::DIMENSION as u32 + 1, 1).write_to(&mut bytes, format).unwrap();
        assert!(read_grey(&place.file(name, bytes.get_ref())).is_err(), "{name}");
        let mut bytes = Cursor::new(Vec::new());
        image::GrayImage::new(limits::DIMENSION as u32, 1).write_to(&mut bytes, format).unwrap();
        assert!(read_grey(&place.file(name, bytes.get_ref())).is_ok(), "{name}");
    }
}

/// /dev/full takes no byte.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let full = Path::new("/dev/full");
    assert!(matches!(write_png_grey(full, 1, 1, &[7], 8), Err(ImageError::Write { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn altered_bytes_never_panic(
        file in 0_usize..11,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        front in any::<bool>(),
    ) {
        let (name, bytes) = &FILES[file];
        let mut bytes = bytes.clone();
        // Headers are short: half of the cases go there.
        let reach = if front { bytes.len().min(400) } else { bytes.len() };
        for (index, value) in changes {
            let place = index.index(reach);
            bytes[place] = value;
        }
        read_all(&Place::new().file(name, &bytes));
    }

    #[test]
    fn noise_is_no_image(bytes in prop::collection::vec(any::<u8>(), 0..300), file in 0_usize..10) {
        prop_assert_eq!(read_all(&Place::new().file(FILES[file].0, &bytes)), [false; 3]);
    }
}
