//! Vectors generic over the precision.

use crate::trace::model::Real;
use std::ops::{Add, Mul, Neg, Sub};

/// A vector of three components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct V3<T> {
    /// Along an image row.
    pub x: T,
    /// Against the image columns.
    pub y: T,
    /// Up, from the camera to what is touched.
    pub z: T,
}

/// Makes a vector.
pub fn v3<T>(x: T, y: T, z: T) -> V3<T> {
    V3 { x, y, z }
}

impl<T: Real> V3<T> {
    /// The null vector.
    pub fn zero() -> Self {
        v3(T::zero(), T::zero(), T::zero())
    }

    /// The unit vector along z.
    pub fn up() -> Self {
        v3(T::zero(), T::zero(), T::one())
    }

    /// From an array.
    pub fn from_array(a: [T; 3]) -> Self {
        v3(a[0], a[1], a[2])
    }

    /// Scalar product.
    pub fn dot(self, b: Self) -> T {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    /// Vector product.
    pub fn cross(self, b: Self) -> Self {
        v3(self.y * b.z - self.z * b.y, self.z * b.x - self.x * b.z, self.x * b.y - self.y * b.x)
    }

    /// The unit vector along this one.
    pub fn normalize(self) -> Self {
        self * (T::one() / self.dot(self).sqrt())
    }
}

impl<T: Real> Add for V3<T> {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        v3(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}

impl<T: Real> Sub for V3<T> {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        v3(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}

impl<T: Real> Mul<T> for V3<T> {
    type Output = Self;
    fn mul(self, k: T) -> Self {
        v3(self.x * k, self.y * k, self.z * k)
    }
}

impl<T: Real> Neg for V3<T> {
    type Output = Self;
    fn neg(self) -> Self {
        v3(-self.x, -self.y, -self.z)
    }
}
