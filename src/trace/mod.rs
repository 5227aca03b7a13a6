//! The tracer: light from the LEDs through the stack to the camera.
//!
//! A [`Model`] holds what a scene needs, as plain numbers. Two backends trace it: [`gpu`] (WGSL through wgpu) and its
//! twin [`cpu`] (the same algorithm in Rust, in f32 or f64). Both offer two things: camera paths that add to a film,
//! and photons that fill the flux ledger and, by need, an irradiance map or a splat film. [`render()`] combines them.

pub mod backend;
pub mod batch;
pub mod cpu;
pub mod exitance;
mod finite;
pub mod gains;
pub mod gpu;
pub mod kernel;
pub mod leds;
pub mod model;
pub mod plan;
pub mod rays;
pub mod real;
pub mod render;
pub mod scatter;
mod scene_model;
mod smooth;
mod spread;
mod unfold;
pub mod unseen;

pub use backend::{Backend, BackendChoice, Devices, Precision, TraceError};
pub use kernel::Kernel;
pub use model::Model;
pub use plan::{Method, Plan};
pub use render::{Outcome, Settings, render, render_on};
