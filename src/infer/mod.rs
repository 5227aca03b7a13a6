//! Inference of unknowns from frames: what is learnt from simulated frames, what seen frames say, what follows.
//!
//! ```text
//! points, frames --Learnt::from--> Learnt;   frames --told--> Told (scores) --posterior--> Posterior
//! ```

mod bound;
mod ensemble;
mod importance;
mod learnt;
mod posterior;
mod seen;
mod unknown;

pub use crate::emulate::FitError;
pub use learnt::{Learnt, Nuisance, Scored};
pub use posterior::{Posterior, TAILS};
pub use seen::{Seen, Told};
pub use unknown::{Followed, Prior, Unknown};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
