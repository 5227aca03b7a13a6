//! What long work tells of itself, and how it is stopped.

/// Where a piece of work stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage<'a> {
    /// Share of the work done, 0 to 1.
    pub done: f64,
    /// What is being done.
    pub what: &'a str,
}

/// Who hears of it, between chunks of well under a second; false stops the work.
pub type Observer<'a> = dyn FnMut(Stage<'_>) -> bool + 'a;
