//! Constitutive laws.

/// A second-order tensor, row by row.
pub type Tensor = [[f64; 3]; 3];

/// What a law says of a deformation gradient F: energy per reference volume, its derivative and its second derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Strain energy, kPa (mN mm per mm^3).
    pub energy: f64,
    /// First Piola-Kirchhoff stress dW/dF, kPa; entry 3 i + J.
    pub stress: [f64; 9],
    /// d2W/dF dF, kPa; symmetric.
    pub tangent: [[f64; 9]; 9],
}
