//! What touches the sensor: deformation of the interfaces and optical contact.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Deformation and contact of the touched face.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Touch {
    /// Shape of the touched face.
    pub shape: Shape,
    /// What the interfaces below the touched face do.
    pub inner: Inner,
    /// Optical contact with tissue. Absent: none.
    pub contact: Option<Contact>,
}

/// Shape of the touched face.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Shape {
    /// Flat.
    #[default]
    Flat,
    /// A spherical cap pressed in.
    SphericalDent {
        /// Depth at the centre, mm.
        depth_mm: f64,
        /// Radius of the rim, mm.
        radius_mm: f64,
        /// Centre, mm.
        #[serde(default)]
        center_mm: [f64; 2],
    },
    /// A Gaussian pressed in.
    GaussianDent {
        /// Depth at the centre, mm.
        depth_mm: f64,
        /// Standard deviation, mm.
        sigma_mm: f64,
        /// Centre, mm.
        #[serde(default)]
        center_mm: [f64; 2],
    },
    /// Heights from an EXR (first channel), a PNG (grey) or a CSV grid, spanning the footprint; row 0 at positive y.
    HeightMap {
        /// The file, relative to the scene file.
        file: PathBuf,
        /// Upward displacement in mm for a value of 1 (of 65535 or 255 for PNG: full scale is 1).
        scale_mm: f64,
    },
    /// The touched face as a triangle mesh (OBJ, STL or PLY; mm, in the scene's coordinates) spanning the footprint.
    Mesh {
        /// The file, relative to the scene file.
        file: PathBuf,
        /// Flat facets or normals interpolated between vertices.
        #[serde(default)]
        normals: Normals,
    },
}

/// Normals of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Normals {
    /// Of the facet.
    Flat,
    /// Interpolated between the vertices.
    #[default]
    Smooth,
}

/// What the interfaces below the touched face do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Inner {
    /// Follow the touched face, in proportion to their height above the top of the lowest layer (the rigid glass).
    #[default]
    Follow,
    /// Stay flat.
    Flat,
}

/// Optical contact of the touched face with tissue.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Where the pressure acts, and how much.
    pub pressure: Pressure,
    /// How the share of true contact follows from the pressure.
    #[serde(default)]
    pub law: ContactLaw,
    /// The tissue.
    pub tissue: Tissue,
}

/// Contact pressure on the touched face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Pressure {
    /// A uniform disc. Tissue exists only there.
    Disc {
        /// Radius, mm.
        radius_mm: f64,
        /// Centre, mm.
        #[serde(default)]
        center_mm: [f64; 2],
        /// Pressure, kPa.
        pressure_kpa: f64,
    },
    /// Hertz: p = peak sqrt(1 - r^2/a^2) on top of a base pressure.
    Hertz {
        /// Peak pressure of the bump, kPa.
        peak_kpa: f64,
        /// Contact radius a, mm.
        radius_mm: f64,
        /// Centre, mm.
        #[serde(default)]
        center_mm: [f64; 2],
        /// Pressure everywhere, kPa.
        #[serde(default)]
        base_kpa: f64,
    },
    /// A Gaussian bump on top of a base pressure.
    Gaussian {
        /// Peak pressure of the bump, kPa.
        peak_kpa: f64,
        /// Standard deviation, mm.
        sigma_mm: f64,
        /// Centre, mm.
        #[serde(default)]
        center_mm: [f64; 2],
        /// Pressure everywhere, kPa.
        #[serde(default)]
        base_kpa: f64,
    },
    /// Pressure against radius from a CSV table with columns r_mm and pressure_kpa, linear between rows.
    Table {
        /// The file, relative to the scene file.
        file: PathBuf,
        /// Centre, mm.
        #[serde(default)]
        center_mm: [f64; 2],
    },
    /// Pressure from an EXR (first channel), PNG (grey) or CSV grid spanning the footprint; row 0 at positive y.
    Map {
        /// The file, relative to the scene file.
        file: PathBuf,
        /// Pressure for a value of 1, kPa.
        scale_kpa: f64,
    },
    /// As the press of the phantom gives it; for scenes with a press.
    Press,
}

/// Share of true contact against pressure.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum ContactLaw {
    /// Full contact wherever there is pressure.
    #[default]
    Full,
    /// Persson: erf(sqrt(2) p / (E* rms slope)).
    Persson {
        /// Reduced modulus E*, kPa.
        reduced_modulus_kpa: f64,
        /// Root-mean-square slope of the rougher surface.
        rms_slope: f64,
    },
    /// Greenwood and Williamson, exponential heights: proportional to pressure, 1 - exp(-p/p0) where it saturates.
    GreenwoodWilliamson {
        /// Pressure scale p0, kPa.
        pressure_scale_kpa: f64,
    },
    /// Sticky contact on the way back from a higher pressure: Persson's share at a pressure higher by
    /// `hold_kpa`, never more than at the peak.
    PerssonUnloading {
        /// Reduced modulus E*, kPa.
        reduced_modulus_kpa: f64,
        /// Root-mean-square slope of the rougher surface.
        rms_slope: f64,
        /// Highest pressure reached before, as a multiple of the present one (1 or more).
        peak_ratio: f64,
        /// Adhesive hold, kPa.
        hold_kpa: f64,
    },
}

/// The tissue as the light sees it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tissue {
    /// Refractive index.
    pub n: f64,
    /// Diffuse reflectance of an index-matched surface, 0 to 1, alike for all light. Give this or the two coefficients.
    pub diffuse_reflectance: Option<f64>,
    /// Reduced scattering coefficient, per mm. With the absorption: a half space that returns what the angle of the
    /// light asks for.
    pub reduced_scattering_per_mm: Option<f64>,
    /// Absorption coefficient, per mm.
    pub absorption_per_mm: Option<f64>,
    /// Mean lateral distance between entry and exit of the light, mm. 0: it leaves where it entered.
    #[serde(default)]
    pub spread_mm: f64,
}
