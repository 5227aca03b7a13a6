//! The files beside a scene: one error type, and reading with a limit.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// A mesh, lamp or table file that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{}: {message}", file.display(), line.map(|n| format!(":{n}")).unwrap_or_default())]
pub struct DataFileError {
    /// Class of the error: `io`, `too_large` or `bad_file`.
    pub kind: &'static str,
    /// The file.
    pub file: PathBuf,
    /// Line in it, from 1, where it has lines.
    pub line: Option<usize>,
    /// What is wrong and what would be right.
    pub message: String,
}

/// What is wrong inside a file, before it is known which file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Defect {
    pub line: Option<usize>,
    pub message: String,
}

impl Defect {
    pub(super) fn new(line: impl Into<Option<usize>>, message: impl Into<String>) -> Self {
        Self { line: line.into(), message: message.into() }
    }

    pub(super) fn in_file(self, file: &Path) -> DataFileError {
        DataFileError { kind: "bad_file", file: file.to_path_buf(), line: self.line, message: self.message }
    }
}

impl DataFileError {
    pub(super) fn too_large(file: &Path, max_bytes: u64) -> Self {
        let message = format!("is larger than the limit of {max_bytes} bytes");
        Self { kind: "too_large", file: file.to_path_buf(), line: None, message }
    }
}

/// The bytes of a file that is at most `max_bytes` large.
pub(super) fn read_limited(path: &Path, max_bytes: u64) -> Result<Vec<u8>, DataFileError> {
    let unreadable = |cause: std::io::Error| {
        let message = format!("cannot be read: {cause}");
        DataFileError { kind: "io", file: path.to_path_buf(), line: None, message }
    };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(max_bytes + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > max_bytes {
        return Err(DataFileError::too_large(path, max_bytes));
    }
    Ok(bytes)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_file_over_the_limit_is_refused_and_one_at_it_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data");
        std::fs::write(&path, b"12345").unwrap();
        assert_eq!(read_limited(&path, 5).unwrap(), b"12345");
        assert_eq!(read_limited(&path, 4).unwrap_err().kind, "too_large");
        assert_eq!(read_limited(&folder.path().join("none"), 4).unwrap_err().kind, "io");
    }
}
