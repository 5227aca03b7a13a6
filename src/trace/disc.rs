//! Discs on the touched face.

use super::real::Real;

/// A disc, seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc<T> {
    /// Centre, mm.
    pub center: [T; 2],
    /// Square of its radius, mm^2.
    pub radius_sq: T,
}

impl<T: Real> Disc<T> {
    /// Whether a point lies in it.
    pub fn holds(&self, x: T, y: T) -> bool {
        let (dx, dy) = (x - self.center[0], y - self.center[1]);
        dx * dx + dy * dy <= self.radius_sq
    }
}
