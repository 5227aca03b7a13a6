//! Why there is no image.

use thiserror::Error;

/// Why a render failed.
#[derive(Debug, Error)]
pub enum TraceError {
    /// A GPU was asked for and none is there.
    #[error(
        "no Vulkan, Metal or DX12 adapter found; use the backend `cpu`, or install a driver (lavapipe: \
         mesa-vulkan-drivers)"
    )]
    NoAdapter,
    /// The device went away.
    #[error("the GPU device was lost ({0})")]
    DeviceLost(String),
    /// A buffer exceeds what the device offers.
    #[error(
        "{what} needs {needed} bytes, the device allows {allowed}; use fewer pixels or texels, or the backend `cpu`"
    )]
    Memory {
        /// What needs it.
        what: &'static str,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        allowed: u64,
    },
    /// The driver refused something.
    #[error("the GPU driver refused a command: {0}")]
    Driver(String),
    /// Paths got lost: an error of geometry or of the program.
    #[error("{lost} of {sent} {what} were lost in the geometry; the image cannot be trusted")]
    Lost {
        /// Photons or camera paths.
        what: &'static str,
        /// Lost ones.
        lost: u64,
        /// All of them.
        sent: u64,
    },
    /// Too much light was cut off.
    #[error("{share:.1e} of the {what} was cut off by the cap on interactions; the image cannot be trusted")]
    Truncated {
        /// The light, or the weight of the camera paths.
        what: &'static str,
        /// Share of it.
        share: f64,
    },
    /// Sums of light that do not hold it.
    #[error("{full} of {of} {what} were given more light than their sums hold; the image cannot be trusted")]
    Overflow {
        /// Pixels, or cells of the map.
        what: &'static str,
        /// Sums that are full.
        full: usize,
        /// All of them.
        of: usize,
    },
    /// A number of the model that is none.
    #[error(
        "{what} comes to {value} in the tracer's {precision}: it must be finite; check what the scene gives for it"
    )]
    NotFinite {
        /// Which number.
        what: String,
        /// What it is.
        value: f64,
        /// `f32` or `f64`.
        precision: &'static str,
    },
    /// The driver ended loops before their time.
    #[error("the GPU driver ended loops early: {finished} of {sent} paths were traced; use the backend `cpu`")]
    CutShort {
        /// Paths that came to their end.
        finished: u64,
        /// Paths asked for.
        sent: u64,
    },
    /// The user stopped it.
    #[error("stopped")]
    Stopped,
    /// The method does not fit the scene.
    #[error("{0}")]
    Unsuited(String),
}
