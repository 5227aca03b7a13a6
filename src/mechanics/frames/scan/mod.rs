//! The scan: a rigid indenter pressed into tissue at one position after the other, in plane strain.
//!
//! The tissue is a block on a rigid base, its touched face down. The indenter stands still at x = position, its tip in
//! the plane of the undeformed face; the base moves towards it by the depth of the press. Each position is a press of
//! its own from the undeformed state. All positions share one mesh, with elements of one size along all of the face
//! that frames see: on a graded face the frame would jump from position to position. The eccentricity's reference is
//! pressed on the same mesh with the tissue's material in place of the inclusions', so what the mesh and the ends of
//! the strip do to a frame is in both.

mod compliance;
mod error;
mod press;
mod run;
mod sample;
mod setup;
mod shown;

pub use error::{FrameError, ScanError};
pub use run::{Held, ScanSettings, Scanned, frames, scan};
pub use setup::ScanSetup;
pub use shown::Shown;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
