//! How bodies resist deformation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elastic law of a body, with its relaxation. Moduli are those of an instantaneous deformation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "law")]
pub enum Elastic {
    /// Hooke's law, for small strain.
    Linear {
        /// Young's modulus, kPa.
        youngs_kpa: f64,
        /// Poisson's ratio, 0 to 0.5 inclusive. Default: 0.4999.
        #[serde(default = "nearly_incompressible")]
        poisson: f64,
        /// Terms of relaxation. Default: none.
        #[serde(default)]
        relaxation: Vec<Relaxation>,
    },
    /// Neo-Hookean.
    NeoHookean {
        /// Young's modulus at small strain, kPa.
        youngs_kpa: f64,
        /// Poisson's ratio at small strain, 0 to 0.5 inclusive. Default: 0.4999.
        #[serde(default = "nearly_incompressible")]
        poisson: f64,
        /// Terms of relaxation. Default: none.
        #[serde(default)]
        relaxation: Vec<Relaxation>,
    },
    /// Yeoh: W = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3. The shear modulus at small strain is 2 c1.
    Yeoh {
        /// c1, c2 and c3, kPa.
        c_kpa: [f64; 3],
        /// Poisson's ratio at small strain, 0 to 0.5 inclusive. Default: 0.4999.
        #[serde(default = "nearly_incompressible")]
        poisson: f64,
        /// Terms of relaxation. Default: none.
        #[serde(default)]
        relaxation: Vec<Relaxation>,
    },
    /// Ogden: W = sum of mu/alpha (l1^alpha + l2^alpha + l3^alpha - 3) over its terms, l the principal stretches. The
    /// shear modulus at small strain is half the sum of mu alpha.
    Ogden {
        /// The terms.
        terms: Vec<OgdenTerm>,
        /// Poisson's ratio at small strain, 0 to 0.5 inclusive. Default: 0.4999.
        #[serde(default = "nearly_incompressible")]
        poisson: f64,
        /// Terms of relaxation. Default: none.
        #[serde(default)]
        relaxation: Vec<Relaxation>,
    },
    /// Soft tissue: stress (b/m) (exp(m strain) - 1) in one dimension.
    Exponential {
        /// b, Young's modulus at small strain of the incompressible tissue, kPa.
        modulus_kpa: f64,
        /// m, without unit.
        exponent: f64,
        /// Poisson's ratio at small strain, 0 to 0.5 inclusive. Default: 0.4999.
        #[serde(default = "nearly_incompressible")]
        poisson: f64,
        /// Terms of relaxation. Default: none.
        #[serde(default)]
        relaxation: Vec<Relaxation>,
    },
}

/// A term of Ogden's law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OgdenTerm {
    /// mu, kPa, of the sign of the exponent. In the normalisation 2 mu/alpha^2 (Abaqus, CalculiX) it is 2/alpha times
    /// theirs.
    pub shear_kpa: f64,
    /// alpha, not 0, without unit.
    pub exponent: f64,
}

/// A term of a Prony series: share (1 - exp(-t/time)) of the instantaneous stress is gone after t.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Relaxation {
    /// Share of the instantaneous shear modulus that this term loses, 0 to below 1.
    pub share: f64,
    /// Relaxation time, s.
    pub time_s: f64,
}

impl Elastic {
    /// Poisson's ratio.
    pub fn poisson(&self) -> f64 {
        match self {
            Self::Linear { poisson, .. }
            | Self::NeoHookean { poisson, .. }
            | Self::Yeoh { poisson, .. }
            | Self::Ogden { poisson, .. }
            | Self::Exponential { poisson, .. } => *poisson,
        }
    }

    /// Terms of relaxation.
    pub fn relaxation(&self) -> &[Relaxation] {
        match self {
            Self::Linear { relaxation, .. }
            | Self::NeoHookean { relaxation, .. }
            | Self::Yeoh { relaxation, .. }
            | Self::Ogden { relaxation, .. }
            | Self::Exponential { relaxation, .. } => relaxation,
        }
    }
}

/// Silicones and soft tissue, 0.495 to 0.4999.
fn nearly_incompressible() -> f64 {
    0.4999
}
