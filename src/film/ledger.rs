//! Where the light went: emitted = absorbed + escaped + detected + terminated + roulette.

use serde::Serialize;

/// Flux of photons sent forward from the LEDs, as shares of the emitted power (`emitted` is 1 where there is light).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Ledger {
    /// Sent out by the LEDs.
    pub emitted: f64,
    /// Absorbed in layers, tissue, walls and LED faces.
    pub absorbed: f64,
    /// Left through the touched side.
    pub escaped_top: f64,
    /// Left towards the camera side, past the lens.
    pub escaped_bottom: f64,
    /// Left through the side walls.
    pub escaped_sides: f64,
    /// Entered the lens' pupil (0 for a pinhole).
    pub detected: f64,
    /// Cut off by the cap on interactions.
    pub terminated: f64,
    /// Net loss of Russian roulette, zero on average.
    pub roulette: f64,
    /// What is missing: emitted minus all the others.
    pub residual: f64,
}
