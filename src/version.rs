//! Which program it is.

/// Version of the crate.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// A hash of all sources that decide figures, 16 hexadecimal digits: the same wherever they are compiled.
pub const SOURCES: &str = env!("TIRTOUCH_SOURCES");
