//! Pressure frames of a scanned indenter and their features (Galea and Howe, "Tissue stiffness from tactile imaging").
//!
//! A frame is the pressure under the indenter at one position; frames stacked by position make the tactile image. Each
//! frame is reduced to four features: peak, base (the pressure at its edges), width, and eccentricity.
//!
//! The paper fits a parabola p(x) = c0 + c1 x + c2 x² to the frame and does not say over which window, nor how one
//! parabola gives four numbers. A parabola has three. Its width at half height above a base, taken from the same fit or
//! from the frame, is about a fixed share of the window and hardly feels an inclusion. So here:
//!
//! - peak = c0 - c1²/(4 c2) and its place x0 = -c1/(2 c2) come from the fit, over a window that [`Settings`] states;
//! - base is the mean of the raw pressures at the two ends of that window, 0 where an end lies beyond the contact;
//! - width is the full width of the parabola at half of its peak, sqrt(2 peak / -c2);
//! - eccentricity compares the raw frame with a reference: with D = frame - reference,
//!   e = (integral of D over x > 0 - integral of D over x < 0) / integral of |D|, from -1 to 1.
//!
//! The best reference is the frame at the same position without the inclusion: it holds what the tissue's ends do to
//! the frame. The paper's reference, the frame farthest from the inclusion, is what a measurement has.

mod eccentricity;
mod features;
mod parabola;
pub mod scan;
mod table;

pub(crate) use features::of_frame;
pub use features::{Features, Reference, Settings, features};
pub use parabola::Parabola;
pub use table::{features_csv, frames_csv, read_frames};

/// The pressure under the indenter at one position.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Position of the indenter's centre, mm; 0 over the inclusion.
    pub position_mm: f64,
    /// Places along the indenter, ascending, mm; 0 at its centre.
    pub x_mm: Vec<f64>,
    /// Pressure at these places, kPa; 0 where there is no contact.
    pub pressure_kpa: Vec<f64>,
}

/// Frames at ascending positions, all at the same places along the indenter.
#[derive(Debug, Clone, PartialEq)]
pub struct Frames(Vec<Frame>);

/// Frames that do not belong together.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("frame {frame}, counted from 0: {rule}")]
pub struct FramesError {
    /// Which frame, from 0.
    pub frame: usize,
    /// The rule that it breaks.
    pub rule: &'static str,
}

impl Frames {
    /// Frames in their order.
    ///
    /// # Errors
    /// Where there is no frame, a frame has fewer than two places or not one pressure for each, a number is not finite,
    /// places or positions do not ascend, or the places are not those of the first frame.
    pub fn new(frames: Vec<Frame>) -> Result<Self, FramesError> {
        let broken = |frame, rule| Err(FramesError { frame, rule });
        let Some(first) = frames.first() else {
            return broken(0, "there must be one at least");
        };
        for (i, frame) in frames.iter().enumerate() {
            let numbers = frame.x_mm.iter().chain(&frame.pressure_kpa).chain([&frame.position_mm]);
            if frame.x_mm.len() < 2 || frame.x_mm.len() != frame.pressure_kpa.len() {
                return broken(i, "must have one pressure at each of two places at least");
            }
            if numbers.into_iter().any(|v| !v.is_finite()) {
                return broken(i, "numbers must be finite");
            }
            if frame.x_mm.windows(2).any(|pair| pair[0] >= pair[1]) {
                return broken(i, "places must ascend");
            }
            if frame.x_mm != first.x_mm {
                return broken(i, "places must be those of the first frame");
            }
            if i > 0 && frames[i - 1].position_mm >= frame.position_mm {
                return broken(i, "positions must ascend");
            }
        }
        Ok(Self(frames))
    }

    /// The frames, one at least.
    pub fn as_slice(&self) -> &[Frame] {
        &self.0
    }

    /// The frame at the greatest distance from position 0, the first of two at the same distance.
    pub fn farthest(&self) -> &Frame {
        self.0.iter().fold(
            &self.0[0],
            |best, frame| {
                if frame.position_mm.abs() > best.position_mm.abs() { frame } else { best }
            },
        )
    }
}
