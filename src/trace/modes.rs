//! What camera paths and photons do, method by method, and what became of them.

use super::constants::book;
use super::model::{Model, Real};

/// What a camera path does at tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CameraMode {
    /// Follows the path until it meets an LED.
    Path,
    /// Reads the exitance map.
    Mapped,
    /// Leaves out paths whose first tissue is reached straight, which `splat` finds.
    Complement,
}

/// What photons leave behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PhotonMode {
    /// Only the ledger.
    Ledger,
    /// The irradiance map.
    Map,
    /// The splat film.
    Splat,
}

/// What became of camera paths beside their light.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Fates {
    /// Segments traced.
    pub segments: u64,
    /// Lost paths.
    pub lost: u64,
    /// Weight that the cap on interactions cut off, in units of 1 / [`UNIT`](super::constants::UNIT) path.
    pub cut_off: u64,
}

impl Fates {
    /// Of the bookings of some paths.
    pub fn of(tally: &[i64; book::SLOTS]) -> Self {
        let [segments, lost, cut_off] =
            [book::SEGMENTS, book::LOST, book::TERMINATED].map(|slot| tally[slot].max(0) as u64);
        Self { segments, lost, cut_off }
    }

    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            segments: self.segments + other.segments,
            lost: self.lost + other.lost,
            cut_off: self.cut_off + other.cut_off,
        }
    }
}

/// Cells that photons deposit into: two per texel, or one per pixel.
pub fn deposit_cells<T: Real>(model: &Model<T>, mode: PhotonMode) -> usize {
    match mode {
        PhotonMode::Ledger => 1,
        PhotonMode::Map => 2 * model.map_size[0] * model.map_size[1],
        PhotonMode::Splat => model.camera.size[0] as usize * model.camera.size[1] as usize,
    }
}
