//! Simulator of the multilayer total-internal-reflection tactile sensor.
//!
//! ```text
//! scene.toml -> Scene -> Pressed -> Surface -> Film -> Frame -> Estimate -> Report
//!               scene   mechanics   surface    trace   camera   estimate   report
//! ```
//!
//! One folder a stage, in the order of the data; a stage imports only earlier ones. From a scene to an estimate:
//!
//! ```
//! use tirtouch::{camera, estimate, scene, surface, trace};
//!
//! let mut loaded = scene::preset("contact-disc")?;
//! loaded.scene.camera.pixels = [64, 48];
//! let shape = surface::surface(&loaded)?;
//! let contact = surface::contact_map(&loaded)?;
//! let model = trace::Model::new(&loaded, &shape, contact)?;
//! let settings = trace::Settings {
//!     photons: Some(1 << 16),
//!     ..trace::Settings::of(&loaded.scene.render)
//! };
//! let devices = trace::Devices::open(trace::BackendChoice::Auto, trace::Precision::F32)?;
//! let render = trace::render(&devices, &model, &settings, &mut |_| true)?;
//! let frame = camera::expose(&render.film, &loaded.scene.camera, loaded.scene.light.wavelength_nm, 1)?;
//! let image = estimate::GreyImage::from_frame(&frame)?;
//! let paper = estimate::estimate(&image, &estimate::Settings::default());
//! assert!(paper.lit_pixels > 0 && render.ledger.residual.abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod camera;
pub mod cli;
pub mod converge;
pub mod estimate;
pub mod film;
pub mod image_io;
pub mod mechanics;
pub mod optics;
pub mod report;
pub mod scene;
pub mod stability;
pub mod streams;
pub mod surface;
pub mod trace;
