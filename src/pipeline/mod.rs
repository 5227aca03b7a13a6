//! The way from a scene to a reading, for whoever goes it once or a thousand times.
//!
//! ```text
//! LoadedScene --prepare--> Prepared --shoot--> Shot --read--> Reading
//! ```
//!
//! A [`Session`] keeps what outlives an image: devices and the kernels built on them, and the last presses. A scene
//! that differs in numbers alone finds its kernels there, one whose phantom and sensor are the same its press.
//!
//! ```
//! use tirtouch::pipeline::{Order, ReadAs, Session};
//! use tirtouch::scene;
//! use tirtouch::trace::{BackendChoice, Precision};
//!
//! let mut loaded = scene::preset("phantom-size-8mm")?;
//! loaded.scene.camera.pixels = [48, 36];
//! let mut order = Order::of(&loaded.scene);
//! order.settings.photons = Some(1 << 16);
//! let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
//! let prepared = session.prepare(loaded, &order, &mut |_| true)?;
//! let shot = session.shoot(&prepared, &mut |_| true)?;
//! let reading = shot.read(&ReadAs::default())?;
//! let (_, step) = prepared.pressed().ok_or("the scene presses")?;
//! assert!(step.force_n > 1.0 && reading.paper.lit_pixels > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod frame_files;
mod prepare;
mod read;
mod session;
mod shot;
mod summary;
mod truth;

pub use error::PipelineError;
pub use frame_files::{FrameFileError, FrameFiles, less};
pub use prepare::{Order, Prepared, model_of};
pub use read::{ReadAs, Reading, Reference};
pub use session::{Session, Shelf};
pub(crate) use session::{guides_light, look};
pub use shot::{Shot, scale_of, view_of};
pub use summary::{
    BlockError, CameraSummary, EarlierFrame, MapSummary, NO_MECHANICS, PaperSummary, PressSummary, RunSummary,
    ShotSummary, StageSeconds, StepSummary,
};
pub(crate) use summary::{method_name, segments_per_second, setting};
pub use truth::{TrueInclusion, TrueLayer, Truth};

#[cfg(test)]
mod tests;
