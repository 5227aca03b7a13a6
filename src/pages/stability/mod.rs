//! The extreme cases.

pub mod pictures;
pub mod table;
