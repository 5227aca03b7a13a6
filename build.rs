//! What the program is made of, as one number: records of another program are not gone on with.

use std::path::{Path, PathBuf};

/// What only says and shows, and decides no figure.
const WORDS: [&str; 5] = ["src/cli", "src/failure", "src/pages", "src/report", "src/view"];

fn main() {
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rerun-if-changed=shaders");
    let mut files = Vec::new();
    ["src", "shaders"].into_iter().for_each(|folder| find(Path::new(folder), &mut files));
    files.sort();
    let hash = files.iter().fold(BASIS, |hash, file| {
        let name = file.to_string_lossy().replace('\\', "/");
        fnv_1a(fnv_1a(hash, name.as_bytes()), &std::fs::read(file).unwrap_or_default())
    });
    println!("cargo::rustc-env=TIRTOUCH_SOURCES={hash:016x}");
}

/// All files of a folder but tests and [`WORDS`].
fn find(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let is_test = stem == "tests" || stem.ends_with("_tests");
        if is_test || WORDS.iter().any(|words| path == Path::new(words)) {
            continue;
        }
        if path.is_dir() { find(&path, files) } else { files.push(path) }
    }
}

const BASIS: u64 = 0xcbf2_9ce4_8422_2325;

/// Fowler, Noll and Vo's hash, 64 bits.
fn fnv_1a(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
