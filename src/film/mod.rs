//! Sums of light: an image with its variance, the sums of its blocks, and the flux ledger.

pub mod blocks;
pub mod compare;
mod correlation;
mod groups;
pub mod ledger;
mod mean_error;
mod parts;
mod tails;

pub use blocks::{BlockAccumulator, BlockLevel};
pub use compare::{Comparison, compare};
pub use correlation::Correlation;
pub use groups::{Group, MOST_GROUPS};
pub use ledger::Ledger;
pub use mean_error::MeanError;
pub use parts::Parts;
pub use tails::{mean_interval, quantile_95};

/// Unit of radiance, as it is written in files, pictures and text.
pub const RADIANCE_UNIT: &str = "W/(m^2 sr)";

/// A linear radiance image in W/(m^2 sr), row 0 at positive y, column 0 at negative x.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Film {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Mean radiance, row-major, W/(m^2 sr).
    pub mean: Vec<f32>,
    /// Variance of the mean, row-major, the square of that unit.
    pub variance: Vec<f32>,
    /// Independent replicates behind the variance (0: unknown).
    pub replicates: u32,
    /// Camera paths behind each pixel (0: unknown, and there are no more than replicates).
    pub samples: u32,
    /// Means over blocks of pixels and their variances, for the edges of [`blocks::EDGES`] in that order.
    /// Empty: unknown, and pixels count as independent.
    pub blocks: Vec<BlockLevel>,
    /// Mean images of a few groups of replicates, from which a figure of the image takes its own error. Empty: unknown
    /// (a file keeps none).
    pub groups: Vec<Group>,
    /// How much pixels and blocks move together. Empty: unknown, and they count as independent.
    pub correlation: Vec<Correlation>,
    /// Mean radiances of a few regions in each of a few groups of replicates. Empty: unknown.
    pub parts: Parts,
}
