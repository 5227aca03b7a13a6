//! Any bytes as an image file: a typed error or an image, never a panic, and never more memory than the limits allow.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::PathBuf;
use std::sync::LazyLock;
use tirtouch::image_io::{grid_of, read_grey, read_radiance};

/// The readers take paths. In memory where the system has such a folder: a million files are not for a disk.
static SCRATCH: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    folder.join(format!("tirtouch-fuzz-image-{}", std::process::id()))
});

/// The readers choose the format by the extension; choose it as a user would name such a file.
fn extension(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x76, 0x2f, 0x31, 0x01, ..] => "exr",
        [0x89, b'P', b'N', b'G', ..] => "png",
        [b'I', b'I', ..] | [b'M', b'M', ..] => "tiff",
        _ => "csv",
    }
}

fuzz_target!(|bytes: &[u8]| {
    let path = SCRATCH.with_extension(extension(bytes));
    if std::fs::write(&path, bytes).is_err() {
        return;
    }
    let _ = grid_of(&path, bytes);
    let _ = read_grey(&path);
    let _ = read_radiance(&path);
});
