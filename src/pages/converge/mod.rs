//! Ladders of error against run time.

pub mod pictures;
pub mod table;
