//! How far a run of a sweep came, and why no further.

use crate::output::OutputError;
use crate::trace::TraceError;

/// Why a sweep came to no end.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A record could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The device, not a point, is to blame.
    #[error("point {row}: {error}")]
    Device {
        /// The point that was traced.
        row: usize,
        /// What the tracer says.
        error: TraceError,
    },
    /// The caller stopped it.
    #[error("stopped")]
    Stopped,
}

/// Points that ended, of those asked for.
pub(super) struct Tally {
    pub done: usize,
    /// Of these, by this run.
    pub computed: usize,
    pub of: usize,
}

impl Tally {
    /// Share of them, 0 to 1.
    pub fn share(&self) -> f64 {
        self.done as f64 / self.of.max(1) as f64
    }
}
