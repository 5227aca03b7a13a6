//! What was computed, for people: words, tables, pictures and pages.
//!
//! The command line prints and writes them; `report` draws. Nothing here knows of flags or terminals.

pub mod bound;
pub mod comparison;
pub mod converge;
pub mod difference;
mod error;
mod explore;
pub mod exposure;
pub mod facts;
pub mod frames;
pub mod images;
pub mod inspection;
pub mod paper_study;
pub mod press;
pub mod press_files;
mod press_vtu;
pub mod regimes;
pub mod run;
pub mod sensor;
pub mod shot;
pub mod side;
pub mod stability;
pub mod study;
pub mod sweep;
mod tables;
pub mod truth;

pub use error::PageError;
