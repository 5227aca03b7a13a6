//! What is kept of a point.

use super::{Kept, Told};
use crate::vary::Scalar;
use serde::{Deserialize, Serialize};

/// How a point ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Its figures are there.
    Done,
    /// It breaks a constraint, or a rule of scenes.
    Rejected,
    /// It could not be computed.
    Failed,
}

impl State {
    /// In tables and reports; a point without a record is missing.
    pub fn word(of: Option<Self>) -> &'static str {
        match of {
            Some(Self::Done) => "done",
            Some(Self::Rejected) => "rejected",
            Some(Self::Failed) => "failed",
            None => "missing",
        }
    }
}

/// What is kept of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its row, from 0.
    pub row: usize,
    /// How it ended.
    pub status: State,
    /// Why, where it has no figures.
    pub reason: Option<String>,
    /// SHA-256 of its scene file, as `sweep scene` writes it; none where it makes none.
    pub scene_sha256: Option<String>,
    /// A value for each variable; none where not all of them have one.
    pub values: Vec<Scalar>,
    /// Figures, in the order of the measures and their columns.
    pub figures: Vec<Told>,
    /// Of its image.
    pub traced: Option<Traced>,
    /// Its images that were kept.
    #[serde(default)]
    pub images: Vec<Kept>,
    /// What computed it.
    pub version: String,
    /// Where its time went.
    pub seconds: Seconds,
}

/// How an image was traced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Traced {
    /// The light's random stream, and the sensor's.
    pub streams: [u32; 2],
    /// Camera paths a pixel.
    pub spp: u64,
    /// Photons.
    pub photons: u64,
    /// Relative error of a lit pixel.
    pub relative_error: Option<f64>,
    /// What traced it.
    pub adapter: String,
}

/// Where a point's time went, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Seconds {
    /// Scene, press and surfaces.
    pub press: f64,
    /// Tracing, and compiling where that had to be.
    pub light: f64,
    /// Figures.
    pub figures: f64,
}

/// Name of a point's record.
pub(super) fn item(row: usize) -> String {
    format!("{row:07}")
}
