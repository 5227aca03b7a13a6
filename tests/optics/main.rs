//! The closed forms of geometrical optics and radiometry, reproduced by the tracer itself: its kernels on the GPU and
//! their twin in f32 and f64. `src/optics` holds the formulas; here the light finds the same numbers.
//!
//! A share found by counting is held to four binomial standard errors (a false alarm in 16,000 runs), and the count is
//! large enough that these are below half a unit of the digit stated. Seeds are fixed, so a test that passes stays so.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod angles;
mod beams;
mod bench;
mod films;
mod flat;
mod fresnel;
mod furnace;
mod ledger;
mod leds;
mod lens;
mod meshes;
mod rough;
mod tissue;
