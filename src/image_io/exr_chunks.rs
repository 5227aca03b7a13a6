//! The pixels of a plain EXR: its table of chunks checked first, then one chunk decompressed after the other.

use super::exr_header::{self, Bytes, Header, Refusal};
use super::{ImageError, limits};
use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::meta::attribute::{ChannelDescription, LineOrder, SampleType, Text};
use exr::meta::{BlockDescription, MetaData, Requirements};
use exr::prelude::f16;
use std::path::Path;

/// Deflate makes at most 1032 bytes of one (zlib.net, "zlib Technical Details"), PIZ and RLE less.
const MOST_EXPANSION: u64 = 1032;

/// An EXR whose header and chunks have been checked but not decoded.
#[derive(Debug)]
pub(super) struct ExrFile<'a> {
    path: &'a Path,
    pub header: Header,
    chunks: Vec<&'a [u8]>,
}

impl<'a> ExrFile<'a> {
    /// Checks the bytes of the file at `path`.
    pub fn open(path: &'a Path, file: &'a [u8]) -> Result<Self, ImageError> {
        let refused = |refusal| refuse(path, refusal);
        let header = exr_header::read(file).map_err(refused)?;
        let chunks = read_chunks(&header, file).map_err(refused)?;
        Ok(Self { path, header, chunks })
    }

    /// The values of one channel, row-major.
    pub fn channel(&self, index: usize) -> Result<Vec<f32>, ImageError> {
        Ok(self.channels(&[index])?.pop().unwrap_or_default())
    }

    /// The values of these channels, row-major.
    pub fn channels(&self, wanted: &[usize]) -> Result<Vec<Vec<f32>>, ImageError> {
        let damaged = |reason: String| ImageError::Damaged { path: self.path.into(), reason };
        let meta = self.meta_data();
        let size_of = |channel: &exr_header::Channel| channel.kind.bytes_per_sample() * self.header.width;
        let line: usize = self.header.channels.iter().map(size_of).sum();
        let find = |&index: &usize| {
            let before: usize = self.header.channels.iter().take(index).map(size_of).sum();
            let channel = self.header.channels.get(index).ok_or_else(|| damaged("a channel is missing".into()))?;
            Ok((channel.kind, before..before + size_of(channel)))
        };
        let places = wanted.iter().map(find).collect::<Result<Vec<_>, ImageError>>()?;
        let pixels = self.header.width * self.header.height;
        let mut values = vec![Vec::with_capacity(pixels); wanted.len()];
        let lines_per_chunk = self.header.compression.scan_lines_per_block();
        for (number, compressed) in self.chunks.iter().enumerate() {
            let block = CompressedScanLineBlock {
                y_coordinate: (number * lines_per_chunk) as i32,
                compressed_pixels_le: compressed.to_vec(),
            };
            let chunk = Chunk { layer_index: 0, compressed_block: CompressedBlock::ScanLine(block) };
            let block = UncompressedBlock::decompress_chunk(chunk, &meta, false);
            let block = block.map_err(|error| damaged(format!("chunk {number}: {error}")))?;
            for bytes in block.data.chunks_exact(line) {
                for (values, (kind, place)) in values.iter_mut().zip(&places) {
                    values.extend(decode(*kind, bytes.get(place.clone()).unwrap_or_default()));
                }
            }
        }
        match values.iter().all(|values| values.len() == pixels) {
            true => Ok(values),
            false => Err(damaged("it holds fewer pixels than its size says".into())),
        }
    }

    /// The header as the exr crate wants it, of nothing but checked values; the data window starts at 0, 0.
    fn meta_data(&self) -> MetaData {
        let channels = self.header.channels.iter().map(|channel| {
            // Names do not matter for decompression, and the crate refuses some.
            ChannelDescription::new(Text::from("channel"), channel.kind, true)
        });
        let size = (self.header.width, self.header.height);
        let header = exr::meta::header::Header::new(Text::from("layer"), size, channels.collect()).with_encoding(
            self.header.compression,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        );
        let requirements = Requirements {
            file_format_version: 2,
            is_single_layer_and_tiled: false,
            has_long_names: false,
            has_deep_data: false,
            has_multiple_layers: false,
        };
        MetaData { requirements, headers: std::iter::once(header).collect() }
    }
}

fn refuse(path: &Path, refusal: Refusal) -> ImageError {
    let path = path.into();
    match refusal {
        Refusal::Damaged(reason) => ImageError::Damaged { path, reason },
        Refusal::Unsupported(reason) => ImageError::Unsupported { path, reason },
        Refusal::TooLarge { what, found, limit } => ImageError::TooLarge { path, what, found, limit },
    }
}

/// Samples in native byte order, as the exr crate leaves them.
fn decode(kind: SampleType, bytes: &[u8]) -> impl Iterator<Item = f32> {
    let value = move |sample: &[u8]| match (kind, sample) {
        (SampleType::F16, &[a, b]) => f16::from_ne_bytes([a, b]).to_f32(),
        (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
        (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
        _ => f32::NAN,
    };
    bytes.chunks_exact(kind.bytes_per_sample()).map(value)
}

/// The compressed chunks in the order of their lines.
fn read_chunks<'a>(header: &Header, file: &'a [u8]) -> Result<Vec<&'a [u8]>, Refusal> {
    let pixel: usize = header.channels.iter().map(|channel| channel.kind.bytes_per_sample()).sum();
    let decoded = (header.width * header.height * pixel) as u64;
    let limit = MOST_EXPANSION * file.len() as u64;
    if decoded > limit {
        return Err(Refusal::TooLarge { what: "its decoded size for the bytes it has", found: decoded, limit });
    }
    let lines = header.compression.scan_lines_per_block();
    let mut table = Bytes { rest: file.get(header.length..).unwrap_or_default() };
    let chunk = |number: usize| -> Result<&'a [u8], Refusal> {
        let wrong = |what: &str| Refusal::Damaged(format!("chunk {number} {what}"));
        let offset = table.u64()?;
        let start = usize::try_from(offset).ok().filter(|&start| start >= header.length);
        let rest = start.and_then(|start| file.get(start..)).ok_or_else(|| wrong("is missing"))?;
        let mut chunk = Bytes { rest };
        let expected_line = i64::from(header.first_line) + (number * lines) as i64;
        if i64::from(chunk.i32()?) != expected_line {
            return Err(wrong("is not where the table says"));
        }
        let length = chunk.length()?;
        let raw = header.width * pixel * lines.min(header.height - number * lines);
        // A chunk that would grow is stored as it is; all others are smaller.
        let plain = header.compression == exr::meta::attribute::Compression::Uncompressed;
        if length == 0 || length > raw || (plain && length != raw) {
            return Err(wrong("has a wrong size"));
        }
        chunk.take(length)
    };
    (0..header.height.div_ceil(lines)).map(chunk).collect()
}

/// Opens the file at `path` and hands its checked form to `read`.
pub(super) fn with_exr<T>(path: &Path, read: impl FnOnce(&ExrFile) -> Result<T, ImageError>) -> Result<T, ImageError> {
    let file = limits::read_file(path)?;
    read(&ExrFile::open(path, &file)?)
}
