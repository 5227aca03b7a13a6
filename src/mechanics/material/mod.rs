//! Constitutive laws.
//!
//! The energy of a material is split: W(F) = W_iso(Fbar) + W_vol(J), with J = det F and Fbar = J^(-1/3) F. This module
//! holds W_iso; the elements hold W_vol, through their pressure. Every law is a function of Fbar alone, so its
//! Kirchhoff stress is a deviator. The one exception is [`Law::Linear`], the same split at small strain.
//!
//! | file | what it holds |
//! |---|---|
//! | `law.rs` | the laws and their parameters |
//! | `linear.rs` | Hooke's law |
//! | `invariant.rs` | the laws that are functions of the first invariant |
//! | `ogden.rs` | the law in principal stretches, `spectrum.rs` its eigenvalues |
//! | `viscous.rs` | Prony series |
//! | `check.rs` | which parameters make sense |
//! | `algebra.rs` | determinant, cofactor, strain |

mod algebra;
mod check;
mod invariant;
mod law;
mod linear;
mod ogden;
mod spectrum;
#[cfg(test)]
mod tests;
mod viscous;

pub use check::MaterialError;
pub use law::Law;
pub use ogden::OgdenTerm;
pub use viscous::{History, Prony};

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

/// A material: an isochoric law, its compressibility, its relaxation.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The isochoric law. Its moduli are those of an instantaneous deformation.
    pub law: Law,
    /// Poisson's ratio at small strain, 0 to 0.5 inclusive.
    pub poisson: f64,
    /// Relaxation of the isochoric stress; empty for an elastic material.
    pub relaxation: Vec<Prony>,
}

/// Shear modulus, kPa, of Young's modulus and Poisson's ratio: E / (2 (1 + nu)).
pub fn shear_from_youngs(youngs_kpa: f64, poisson: f64) -> f64 {
    youngs_kpa / (2.0 * (1.0 + poisson))
}

impl Material {
    /// An elastic material.
    ///
    /// # Errors
    /// When the law or Poisson's ratio make no sense.
    pub fn elastic(law: Law, poisson: f64) -> Result<Self, MaterialError> {
        let material = Self { law, poisson, relaxation: Vec::new() };
        material.check()?;
        Ok(material)
    }

    /// Hooke's law, small strain.
    ///
    /// # Errors
    /// When Young's modulus is not positive or Poisson's ratio is outside 0 to 0.5.
    pub fn linear(youngs_kpa: f64, poisson: f64) -> Result<Self, MaterialError> {
        Self::elastic(Law::Linear { shear_kpa: shear_from_youngs(youngs_kpa, poisson) }, poisson)
    }

    /// Neo-Hookean, by its moduli at small strain.
    ///
    /// # Errors
    /// When Young's modulus is not positive or Poisson's ratio is outside 0 to 0.5.
    pub fn neo_hookean(youngs_kpa: f64, poisson: f64) -> Result<Self, MaterialError> {
        Self::elastic(Law::NeoHookean { shear_kpa: shear_from_youngs(youngs_kpa, poisson) }, poisson)
    }

    /// The same material with relaxation. Its given moduli stay the instantaneous ones.
    ///
    /// # Errors
    /// When a share, their sum or a time makes no sense.
    pub fn with_relaxation(self, relaxation: Vec<Prony>) -> Result<Self, MaterialError> {
        let material = Self { relaxation, ..self };
        material.check()?;
        Ok(material)
    }

    /// Bulk modulus, kPa: 2 mu (1 + nu) / (3 (1 - 2 nu)); infinite at nu = 0.5. It does not relax.
    pub fn bulk_kpa(&self) -> f64 {
        2.0 * self.law.shear_kpa() * (1.0 + self.poisson) / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// Young's modulus at small, instantaneous strain, kPa.
    pub fn youngs_kpa(&self) -> f64 {
        2.0 * self.law.shear_kpa() * (1.0 + self.poisson)
    }

    /// Shear modulus at small strain after full relaxation, kPa.
    pub fn relaxed_shear_kpa(&self) -> f64 {
        self.law.shear_kpa() * (1.0 - self.relaxation.iter().map(|term| term.share).sum::<f64>())
    }
}
