//! The tracer: light from the LEDs through the stack to the camera.
//!
//! A [`Model`] holds what a scene needs, as plain numbers; a [`Kernel`] says which pieces of the tracer that takes. Two
//! backends trace it: [`gpu`] (WGSL through wgpu) and its twin [`cpu`] (the same algorithm in Rust, in f32 or f64).
//! Both offer two things, in chunks of well under a second: camera paths that add to a film, and photons that fill the
//! flux ledger and, by need, an irradiance map or a splat film. [`render()`] combines them.
//!
//! A path is a position, an optical momentum p = n d, and the layer it is in. Between events p.xy does not change in a
//! flat stack, so Snell's invariant does not drift. One walk serves photons and camera paths; it stops at walls, exits
//! and tissue.
//!
//! - `path`: camera paths find all light, each going on until it meets an LED; photons fill the ledger only.
//! - `map`: camera paths find light that has met no tissue, by meeting an LED, and all other light at the first tissue
//!   they meet, from the map; photons find the exitance of the tissue.
//! - `splat`: photons find light whose last tissue is seen straight through the layers, connected to the pinhole;
//!   camera paths find all other light.
//!
//! So every path from an LED to the camera is found by exactly one pass.

mod asked;
pub mod backend;
pub mod batch;
pub mod constants;
pub mod cpu;
pub mod disc;
pub mod drivers;
mod error;
pub mod exitance;
mod finite;
pub mod gains;
pub mod gpu;
pub mod kernel;
pub mod launch;
pub mod leds;
pub mod model;
mod model_symmetry;
pub mod modes;
mod pcg;
pub mod plan;
pub mod rays;
pub mod real;
pub mod render;
pub mod scatter;
mod scene_model;
mod smooth;
mod spread;
pub mod symmetry;
mod unfold;
pub mod unseen;

pub use asked::render;
pub use backend::{Backend, BackendChoice, Devices, Precision};
pub use error::TraceError;
pub use kernel::Kernel;
pub use model::Model;
pub use plan::{Integrator, Plan};
pub use render::{Outcome, REPLICATES, Settings, render_on};
