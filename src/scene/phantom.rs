//! The phantom: what is pressed against the sensor, and the inclusions in it.
//!
//! It touches the sensor with its lower face; its axis is the sensor's. Depths count from that face into the phantom.

use super::Elastic;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The phantom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Phantom {
    /// Its outer shape.
    pub shape: PhantomBody,
    /// What it is made of, below its layers.
    pub material: Elastic,
    /// Bodies inside, none overlapping another, each in one layer. Default: none.
    #[serde(default)]
    pub inclusion: Vec<Inclusion>,
    /// Layers between the touched face and the body of `material`, the touched one first: skin over fat. Default: none.
    #[serde(default)]
    pub layer: Vec<PhantomLayer>,
}

/// A layer of the phantom, bonded to what lies below it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PhantomLayer {
    /// Its thickness, mm.
    pub thickness_mm: f64,
    /// What it is made of.
    pub material: Elastic,
}

/// Outer shape of a phantom. The face away from the sensor is held by a rigid base.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum PhantomBody {
    /// A round cylinder.
    Cylinder {
        /// Its radius, mm.
        radius_mm: f64,
        /// Its height, mm.
        height_mm: f64,
    },
    /// A block.
    Block {
        /// Its size along x and y, mm. In a plane section (scan scenes) the second plays no part.
        size_mm: [f64; 2],
        /// Its height, mm.
        height_mm: f64,
    },
}

/// A body inside the phantom, bonded to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inclusion {
    /// Its shape.
    pub shape: InclusionBody,
    /// Depth below the phantom's touched face, mm, of the point that `depth_to` names.
    pub depth_mm: f64,
    /// What the depth is counted to. Default: `top`.
    #[serde(default)]
    pub depth_to: DepthTo,
    /// Place of its centre along x and y, mm. Default: on the axis.
    #[serde(default)]
    pub center_mm: [f64; 2],
    /// What it is made of.
    pub material: Elastic,
}

/// Shape of an inclusion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum InclusionBody {
    /// A sphere; in a plane section a round bar.
    Sphere {
        /// Its diameter, mm.
        diameter_mm: f64,
    },
    /// An ellipsoid along the axes.
    Ellipsoid {
        /// Half its widths along x, y and z, mm.
        semi_axes_mm: [f64; 3],
    },
    /// A closed triangle mesh (OBJ, STL or PLY). Its origin is the inclusion's centre, from which every ray meets the
    /// surface once; z points into the phantom.
    Mesh {
        /// The file, relative to the scene file.
        file: PathBuf,
        /// Millimetres for one unit of the file. Default: 1.
        #[serde(default = "one")]
        scale: f64,
    },
}

/// What the depth of an inclusion is counted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DepthTo {
    /// Its point nearest to the touched face: the only reading that fits all nine phantoms of the TSIS paper.
    #[default]
    Top,
    /// Its centre.
    Center,
}

impl PhantomBody {
    /// Height, mm.
    pub fn height_mm(&self) -> f64 {
        match self {
            Self::Cylinder { height_mm, .. } | Self::Block { height_mm, .. } => *height_mm,
        }
    }
}

impl InclusionBody {
    /// Half the widths along x, y and z, mm, of a sphere or an ellipsoid.
    pub fn semi_axes_mm(&self) -> Option<[f64; 3]> {
        match self {
            Self::Sphere { diameter_mm } => Some([diameter_mm / 2.0; 3]),
            Self::Ellipsoid { semi_axes_mm } => Some(*semi_axes_mm),
            Self::Mesh { .. } => None,
        }
    }
}

impl Inclusion {
    /// Depth of the centre below the touched face, mm, where the nearest point is `reach_mm` nearer than the centre.
    pub fn center_depth_mm(&self, reach_mm: f64) -> f64 {
        match self.depth_to {
            DepthTo::Top => self.depth_mm + reach_mm,
            DepthTo::Center => self.depth_mm,
        }
    }
}

fn one() -> f64 {
    1.0
}
