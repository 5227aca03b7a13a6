//! What was computed, for people: words, tables, pictures and pages.
//!
//! The command line prints and writes them; `report` draws. Nothing here knows of flags or terminals.

pub(crate) mod bound;
pub(crate) mod comparison;
pub(crate) mod converge;
pub(crate) mod difference;
mod error;
mod explore;
pub mod exposure;
pub(crate) mod facts;
pub mod frames;
pub(crate) mod images;
pub mod inspection;
pub(crate) mod paper_study;
pub(crate) mod press;
pub(crate) mod press_files;
mod press_vtu;
pub(crate) mod regimes;
pub(crate) mod run;
pub(crate) mod said;
pub(crate) mod sensor;
pub(crate) mod shot;
pub(crate) mod side;
pub(crate) mod stability;
pub(crate) mod study;
pub mod sweep;
mod tables;
pub(crate) mod truth;

pub use error::PageError;
