//! Closed forms of the optics.
