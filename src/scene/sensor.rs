//! The sensor itself: light, layers, walls and LEDs.

use super::Elastic;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Vacuum wavelength, nm (200 to 2000).
    pub wavelength_nm: f64,
}

/// The stack of layers between the camera and what is touched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stack {
    /// Size along x and y, mm.
    pub footprint_mm: [f64; 2],
    /// The four side walls.
    #[serde(default)]
    pub walls: Walls,
    /// Refractive index of what surrounds the stack and fills the gaps above it.
    #[serde(default = "one")]
    pub surround_n: f64,
    /// The layers, touch side first, camera side last.
    pub layer: Vec<Layer>,
    /// Roughness of the lowest face (of the last layer, towards the camera).
    #[serde(default)]
    pub lower_roughness: Roughness,
}

/// One layer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// Name for reports.
    pub name: String,
    /// Thickness where undeformed, mm.
    pub thickness_mm: f64,
    /// Refractive index at the scene's wavelength. Give this or `material`.
    pub n: Option<f64>,
    /// A material with known dispersion. Give this or `n`.
    pub material: Option<Material>,
    /// Absorption coefficient, per mm.
    #[serde(default)]
    pub absorption_per_mm: f64,
    /// Roughness of the layer's upper face (towards the touch side).
    #[serde(default)]
    pub upper_roughness: Roughness,
    /// How the layer deforms in a press. Absent: rigid (glass); only the lowest layers may be.
    pub elastic: Option<Elastic>,
}

/// Materials with a dispersion formula (sources in docs/PHYSICS.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Material {
    /// PDMS, Sylgard 184.
    PdmsSylgard184,
    /// Schott N-BK7.
    NBk7,
    /// Schott Borofloat 33.
    Borofloat33,
    /// Schott D263T eco.
    D263t,
}

/// Side walls.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Walls {
    /// Absorb all light.
    #[default]
    Black,
    /// Smooth faces against the surround: Snell and Fresnel.
    Clear,
    /// Specular mirrors.
    Mirror {
        /// Share of the light that is reflected, 0 to 1.
        reflectance: f64,
    },
}

/// Roughness of an interface.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Roughness {
    /// Mirror smooth.
    #[default]
    None,
    /// Heights well below the wavelength: a share of the light leaves the mirror direction for a lobe.
    Small {
        /// Root-mean-square height, nm.
        rms_nm: f64,
        /// Root-mean-square slope of the lobe's facets.
        lobe_slope: f64,
    },
    /// Facets of a wavelength and more: GGX microfacets.
    Microfacet {
        /// GGX width parameter (about sqrt(2) times the rms slope).
        alpha: f64,
    },
}

/// One LED: a disc facing into the stack through a side wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Led {
    /// The wall it stands at.
    pub wall: Wall,
    /// Centre along the wall from its middle, mm: along y at the x walls, along x at the y walls.
    #[serde(default)]
    pub along_mm: f64,
    /// Height of the centre above the lowest face of the stack, mm.
    pub height_mm: f64,
    /// Diameter of the emitting disc, mm.
    pub diameter_mm: f64,
    /// Optically bonded to the wall or in the surround before it.
    pub mount: Mount,
    /// Optical power emitted inside the cut-off cone, mW. Give this or `radiance_w_per_m2_sr`.
    pub power_mw: Option<f64>,
    /// Radiance along the normal, W/(m^2 sr), in the medium the disc sits in. Give this or `power_mw`; a lamp that is
    /// dark along its normal takes `power_mw`.
    pub radiance_w_per_m2_sr: Option<f64>,
    /// Angular pattern.
    #[serde(default)]
    pub pattern: Pattern,
    /// Half-angle of the cone outside which nothing is emitted, degrees. Absent: 90.
    pub cutoff_half_angle_deg: Option<f64>,
}

/// A side wall, named by its outward direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Wall {
    /// The wall at positive x.
    #[serde(rename = "+x")]
    PlusX,
    /// The wall at negative x.
    #[serde(rename = "-x")]
    MinusX,
    /// The wall at positive y.
    #[serde(rename = "+y")]
    PlusY,
    /// The wall at negative y.
    #[serde(rename = "-y")]
    MinusY,
}

impl Wall {
    /// The wall across an axis, 0 for x and 1 for y, at its lower end or at its upper one.
    #[must_use]
    pub fn across(axis: usize, low: bool) -> Self {
        match (axis, low) {
            (0, false) => Self::PlusX,
            (0, true) => Self::MinusX,
            (_, false) => Self::PlusY,
            (_, true) => Self::MinusY,
        }
    }

    /// The axis that it lies across: 0 for x, 1 for y.
    #[must_use]
    pub fn axis(self) -> usize {
        usize::from(matches!(self, Self::PlusY | Self::MinusY))
    }

    /// Whether it is at the lower end of that axis.
    #[must_use]
    pub fn is_low(self) -> bool {
        matches!(self, Self::MinusX | Self::MinusY)
    }
}

/// How an LED meets the wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Mount {
    /// The disc lies on the wall inside the stack's media.
    Bonded,
    /// The disc stands in the surround before a clear wall.
    Air {
        /// Distance from the disc to the wall, mm.
        #[serde(default)]
        gap_mm: f64,
    },
}

/// Angular pattern of an LED's radiant intensity.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Pattern {
    /// Intensity as the cosine: constant radiance.
    #[default]
    Lambertian,
    /// Intensity as a power of the cosine, m = -ln 2 / ln cos(half-power angle).
    CosinePower {
        /// Angle at which the intensity is half of that on the axis, degrees.
        half_power_deg: f64,
    },
    /// Tabulated intensity from an IES LM-63 file (type C); the vertical angle is taken from the disc's normal.
    Ies {
        /// The file, relative to the scene file.
        file: PathBuf,
    },
}

fn one() -> f64 {
    1.0
}
