//! Any bytes as one of the files that a scene names: a mesh, a lamp, a pressure table, an indenter's shape. A typed
//! error or a value, never a panic.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::PathBuf;
use std::sync::LazyLock;
use tirtouch::scene::{read_ies, read_indenter_table, read_mesh, read_pressure_table};

/// The readers take paths. In memory where the system has such a folder: a million files are not for a disk.
static SCRATCH: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    folder.join(format!("tirtouch-fuzz-data-{}", std::process::id()))
});

fuzz_target!(|bytes: &[u8]| {
    let write = |extension: &str| {
        let path = SCRATCH.with_extension(extension);
        std::fs::write(&path, bytes).ok().map(|()| path)
    };
    for path in ["obj", "stl", "ply"].into_iter().filter_map(write) {
        let _ = read_mesh(&path);
    }
    if let Some(path) = write("ies") {
        let _ = read_ies(&path);
    }
    if let Some(path) = write("csv") {
        let _ = read_pressure_table(&path);
        let _ = read_indenter_table(&path);
    }
});
