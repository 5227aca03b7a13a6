//! The most that is read from a file, and whole files in and out of memory.

use super::ImageError;
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

/// Bytes of a file.
pub const FILE_BYTES: u64 = 1 << 30;
/// Columns or rows of an image.
pub const DIMENSION: u64 = 16_384;
/// Pixels of an image.
pub const PIXELS: u64 = 64 << 20;
/// Channels of an EXR.
pub const CHANNELS: u64 = 16;
/// Bytes a PNG or TIFF decoder may hold: 64 Mi pixels of four 16-bit channels, twice.
pub const DECODER_BYTES: u64 = 1 << 30;

/// Refuses an image of more columns, rows or pixels than are read.
pub(super) fn check_size(path: &Path, width: u64, height: u64) -> Result<(), ImageError> {
    let within = |what, found, limit| match found <= limit {
        true => Ok(()),
        false => Err(ImageError::TooLarge { path: path.into(), what, found, limit }),
    };
    within("the width", width, DIMENSION)?;
    within("the height", height, DIMENSION)?;
    within("the number of pixels", width * height, PIXELS)
}

/// Reads a whole file of at most [`FILE_BYTES`].
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, ImageError> {
    let failed = |source| ImageError::Read { path: path.into(), source };
    let file = File::open(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    let too_large =
        |found| ImageError::TooLarge { path: path.into(), what: "the file's size", found, limit: FILE_BYTES };
    if length > FILE_BYTES {
        return Err(too_large(length));
    }
    // A pipe or a growing file has no length to trust.
    let mut bytes = Vec::new();
    file.take(FILE_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    match bytes.len() as u64 {
        length if length > FILE_BYTES => Err(too_large(length)),
        _ => Ok(bytes),
    }
}

/// Writes a whole file and waits until the disk has it, so that a full disk is an error here. Callers write into a
/// folder that is renamed when complete.
pub(super) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    let write = || {
        let mut file = File::create(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    };
    write().map_err(|source| ImageError::Write { path: path.into(), source })
}
