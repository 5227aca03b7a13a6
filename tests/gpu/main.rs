//! The tracers against each other, against their stored images, and against trouble: what needs a GPU or its twin.
//!
//! Without an adapter the tests of the GPU say so and pass, unless `TIRTOUCH_REQUIRE_GPU=1` makes that a failure. Two
//! longer jobs are run on purpose, each by a variable:
//!
//! ```text
//! TIRTOUCH_LEAK_SEGMENTS=1e8 cargo test --profile ci --test gpu leaks -- --nocapture
//! TIRTOUCH_REGENERATE_GOLDEN=1 cargo test --profile ci --test gpu golden::
//! ```

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod adapter;
mod alarms;
mod device;
mod extremes;
mod fates;
mod figures;
mod films;
mod golden;
mod lamps;
mod leaks;
mod rounding;
mod scenes;
mod splits;
mod twins;
mod watch;
