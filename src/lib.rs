//! Simulator of the multilayer total-internal-reflection tactile sensor.
//!
//! ```text
//! scene.toml -> Scene -> Pressed -> Surface -> Film -> Frame -> Estimate -> Report
//!               scene   mechanics   surface    trace   camera   estimate   report
//! ```
//!
//! One folder a stage, in the order of the data; a stage imports only earlier ones. [`pipeline`] goes through all of
//! them:
//!
//! ```
//! use tirtouch::pipeline::{Order, ReadAs, Session};
//! use tirtouch::scene::preset;
//! use tirtouch::trace::{BackendChoice, Precision};
//!
//! let mut loaded = preset("contact-disc")?;
//! loaded.scene.camera.pixels = [64, 48];
//! let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
//! let prepared = session.prepare(loaded.clone(), &Order::of(&loaded.scene), &mut |_| true)?;
//! let shot = session.shoot(&prepared, &mut |_| true)?;
//! let reading = shot.read(&ReadAs::default())?;
//! assert!(reading.paper.lit_pixels > 0 && shot.outcome.ledger.residual.abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod calibrate;
pub mod camera;
pub mod cli;
pub mod converge;
pub mod emulate;
pub mod estimate;
pub mod failure;
pub mod figure;
pub mod film;
pub mod image_io;
pub mod infer;
pub mod mechanics;
pub mod optics;
pub mod output;
pub mod pages;
pub mod pipeline;
pub mod progress;
pub mod report;
pub mod scene;
pub mod stability;
pub mod statistics;
pub mod streams;
pub mod study;
pub mod surface;
pub mod sweep;
pub mod trace;
pub mod vary;
pub mod version;
pub mod view;
