//! A scene to look at while its numbers change: a page on this machine with a slider for each number, the image
//! refining while one looks.
//!
//! Two threads. The **painter** owns the [`crate::pipeline::Session`]. It takes the latest scene that was wished for
//! and makes images of it, each with more work than the one before: first of a press on a coarse mesh, with little
//! light; the last is the one that `render` makes, bit for bit; then come the other loads, and what all frames say of
//! the inclusion. A new wish stops it at the next pause. The **server** answers the page. Between them lies the
//! [`Desk`]: the wish, and what there is to see.
//!
//! The server listens on the loopback address alone. A request must carry the token of the page's address, and name
//! this machine as its host: pages of other sites cannot ask in a browser's name, even by a name that is made to lead
//! here. Requests have limits in size, time and number.

mod desk;
mod knob;
mod look;
mod painter;
mod rungs;
mod server;
mod tev;
mod tokens;

pub use desk::{Desk, Seen};
pub use knob::{Knob, Span};
pub use look::Look;
pub use painter::paint;
pub use server::{Server, ViewError};
pub use tev::{Tev, TevError};

#[cfg(test)]
mod tests;
