//! Why films cannot be compared.

use thiserror::Error;

/// Why two films cannot be compared.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CompareError {
    /// Their sizes differ.
    #[error("the first is {}x{} pixels, the second {}x{}", .first[0], .first[1], .second[0], .second[1])]
    Size {
        /// Columns and rows of the first film.
        first: [u32; 2],
        /// Columns and rows of the second film.
        second: [u32; 2],
    },
    /// Without two replicates a film has no variance.
    #[error("the {film} film has one replicate and so no variance; render at least two")]
    OneReplicate {
        /// Which: `first` or `second`.
        film: &'static str,
    },
    /// A value that no film can have.
    #[error("the {film} film has the {what} {value} at cell {index}; it must be {right}")]
    Value {
        /// Which: `first` or `second`.
        film: &'static str,
        /// `mean` or `variance`.
        what: &'static str,
        /// The value.
        value: f32,
        /// Its place, row-major.
        index: usize,
        /// What would be right.
        right: &'static str,
    },
    /// Its arrays do not fit its size.
    #[error("the {film} film's arrays do not fit its size")]
    Shape {
        /// Which: `first` or `second`.
        film: &'static str,
    },
    /// The level is no probability.
    #[error("the level {0} must lie between 0 and 1")]
    Level(f64),
}
