//! What can go wrong with an image file.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why an image file could not be read or written. Each message names the file.
#[derive(Debug, Error)]
pub enum ImageError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file could not be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Larger than this program accepts.
    #[error("{}: {what} is {found}; at most {limit} is read", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What is too large.
        what: &'static str,
        /// How large it is.
        found: u64,
        /// The most that is accepted.
        limit: u64,
    },
    /// Not what its format says it should be: cut off, altered, or no image at all.
    #[error("{}: damaged or not an image: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A valid file of a kind that is not read or written here.
    #[error("{}: {reason}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Which kind, and what would be right.
        reason: String,
    },
    /// A value that an image cannot have.
    #[error("{}: row {row}, column {column}: {found} is not {right}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Row, counted from 1 at the top of the file.
        row: usize,
        /// Column, counted from 1.
        column: usize,
        /// What stands there.
        found: String,
        /// What would be right.
        right: &'static str,
    },
}

impl ImageError {
    /// The file it is about.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::Read { path, .. }
            | Self::Write { path, .. }
            | Self::TooLarge { path, .. }
            | Self::Damaged { path, .. }
            | Self::Unsupported { path, .. }
            | Self::Value { path, .. } => path,
        }
    }
}
