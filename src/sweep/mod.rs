//! Sweeps: a scene, keys that vary, a design of points, and figures of each point that survive a crash.
//!
//! A sweep's folder keeps one record a point, written whole or not at all; all else there (tables, report) is made of
//! the records. Any number of workers, on one machine or many, may be in one folder: they claim points, and nothing
//! else passes between them.

pub mod by_hand;
mod file;
mod finish;
mod images;
mod kept;
mod measure;
mod parts;
mod ready;
mod record;
mod run;
mod sensitivity;
mod shard;
mod shelf;
pub mod slurm;
mod status;
mod tally;

pub use file::{NoScene, RandomNumbers, Rejected, Settings, Sweep, SweepFile, SweepFolderError, schema};
pub use kept::{Format, Images, Kept, KeptLoad, Loads};
pub use measure::{Measure, Told};
pub use parts::Parts;
pub use record::{Record, Seconds, State, Traced};
pub use run::{Options, run};
pub use sensitivity::Sensitivity;
pub use shard::Shard;
pub use status::Status;
pub use tally::SweepError;
