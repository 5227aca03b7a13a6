//! The precisions of the CPU twin.

use num_traits::{Float, FromPrimitive};

/// A floating-point type the CPU twin runs in.
pub trait Real: Float + FromPrimitive + Send + Sync + std::fmt::Debug + 'static {
    /// Rounds an f64 to this type.
    fn of(v: f64) -> Self;
    /// Widens to f64.
    fn wide(self) -> f64;
}

impl Real for f32 {
    #[inline]
    fn of(v: f64) -> Self {
        v as f32
    }
    #[inline]
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    #[inline]
    fn of(v: f64) -> Self {
        v
    }
    #[inline]
    fn wide(self) -> f64 {
        self
    }
}
