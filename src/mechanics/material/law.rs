//! The laws and their parameters.

use super::ogden::{self, OgdenTerm};
use super::{Response, Tensor, invariant, linear};

/// An isochoric elastic law, moduli in kPa. I1 is the trace of Fbar^T Fbar; l1, l2, l3 are its isochoric stretches.
///
/// Neo-Hookean, Yeoh with coefficients that are not negative, and the exponential law are polyconvex: I1 is a
/// polyconvex function of F (Hartmann and Neff, Int. J. Solids Struct. 40, 2003) and they are convex and rising in it.
/// Ogden's law is elliptic at fixed volume where all exponents are at least 1 in size.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Hooke's law for small strain: stress 2 mu dev(eps). No rotation, no difference between the stress measures.
    Linear {
        /// Shear modulus mu.
        shear_kpa: f64,
    },
    /// W = mu/2 (I1 - 3).
    NeoHookean {
        /// Shear modulus mu.
        shear_kpa: f64,
    },
    /// W = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3 (Yeoh, Rubber Chem. Technol. 66, 1993). mu = 2 c1.
    Yeoh {
        /// c1, c2, c3.
        c_kpa: [f64; 3],
    },
    /// W = sum of mu_k / alpha_k (l1^alpha_k + l2^alpha_k + l3^alpha_k - 3), in the normalisation of Ogden (Proc. R.
    /// Soc. A 326, 1972): mu = 1/2 sum of mu_k alpha_k. Programs that write 2 mu_k / alpha_k^2 (Abaqus, CalculiX) have
    /// other mu_k: theirs times 2 / alpha_k are ours.
    Ogden {
        /// The terms.
        terms: Vec<OgdenTerm>,
    },
    /// Soft tissue: sigma = (b/m) (exp(m eps) - 1) in one dimension, made objective.
    ///
    /// W = (b/m) ((exp(m e) - 1)/m - e) with e = sqrt((I1 - 3)/3), which is |eps| for a small uniaxial strain of an
    /// incompressible body. dW/dI1 = (b/m) (exp(m e) - 1)/(6 e) is positive and rises with I1: W is polyconvex. The
    /// one-dimensional law was fitted in compression, eps > 0 there. This form stiffens in tension in the same manner,
    /// as soft tissue does (Fung, Am. J. Physiol. 213, 1967); the one-dimensional law itself would soften there. mu = b
    /// / 3.
    Exponential {
        /// b, Young's modulus at small strain of the incompressible body.
        modulus_kpa: f64,
        /// m, dimensionless.
        exponent: f64,
    },
}

impl Law {
    /// Shear modulus at small strain, kPa.
    pub fn shear_kpa(&self) -> f64 {
        match self {
            Self::Linear { shear_kpa } | Self::NeoHookean { shear_kpa } => *shear_kpa,
            Self::Yeoh { c_kpa } => 2.0 * c_kpa[0],
            Self::Ogden { terms } => 0.5 * terms.iter().map(|term| term.shear_kpa * term.exponent).sum::<f64>(),
            Self::Exponential { modulus_kpa, .. } => modulus_kpa / 3.0,
        }
    }

    /// Whether the law is for small strain only: the element then is geometrically linear.
    pub fn is_small_strain(&self) -> bool {
        matches!(self, Self::Linear { .. })
    }

    /// Isochoric energy, stress and tangent at the deformation gradient `f`, without the volumetric part.
    ///
    /// `None` when det F is not positive or when something is not finite (the exponential overflows). Hooke's law knows
    /// no det F: it takes every finite F.
    #[inline]
    pub fn isochoric(&self, f: &Tensor) -> Option<Response> {
        let response = match self {
            Self::Linear { shear_kpa } => linear::respond(f, *shear_kpa),
            Self::NeoHookean { shear_kpa } => invariant::respond(f, |x| invariant::neo_hookean(x, *shear_kpa))?,
            Self::Yeoh { c_kpa } => invariant::respond(f, |x| invariant::yeoh(x, c_kpa))?,
            Self::Ogden { terms } => ogden::respond(f, terms)?,
            Self::Exponential { modulus_kpa, exponent } => {
                invariant::respond(f, |x| invariant::exponential(x, *modulus_kpa, *exponent))?
            }
        };
        response.is_finite().then_some(response)
    }
}

impl Response {
    /// Whether no number is infinite or undefined: then their sum is finite too, and the other way round.
    #[inline]
    pub(super) fn is_finite(&self) -> bool {
        let mut columns = self.stress;
        for row in &self.tangent {
            for (column, entry) in columns.iter_mut().zip(row) {
                *column += entry.abs();
            }
        }
        (self.energy + columns.iter().sum::<f64>()).is_finite()
    }
}
