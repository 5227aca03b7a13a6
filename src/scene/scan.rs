//! The scan scene: a rigid indenter pressed into tissue at one position after the other, in plane strain.
//!
//! It has no sensor, light or camera, so it is a file of its own kind. x runs along the scan.

use super::{Interface, Phantom};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A whole scan scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScanScene {
    /// Name of the scene; names the default output folder.
    pub name: String,
    /// What the scene is and where its numbers come from.
    #[serde(default)]
    pub description: String,
    /// The tissue: a block, as the plane section y = 0.
    pub phantom: Phantom,
    /// The indenter and its positions.
    pub scan: Scan,
}

/// The indenter, its positions and the frames that it takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scan {
    /// Shape of the indenter, rigid and symmetric.
    pub indenter: Indenter,
    /// How far the indenter is pressed in at each position, from first touch, mm.
    pub depth_mm: f64,
    /// Positions of the indenter's axis.
    pub positions_mm: Positions,
    /// Half the width of a frame about the indenter's axis, mm.
    pub frame_half_width_mm: f64,
    /// Pressures across a frame, ends included.
    pub frame_points: u32,
    /// Half the width of the window in which the parabola is fitted, about the indenter's axis, mm. Absent: the whole
    /// contact.
    pub window_mm: Option<f64>,
    /// What happens between indenter and tissue. Default: `frictionless`.
    #[serde(default)]
    pub interface: Interface,
    /// Fineness of the mesh: 2 halves the size of all elements. Default: 1.
    #[serde(default = "one")]
    pub resolution: f64,
}

/// Shape of a rigid indenter: a cylinder across a scan's section, a body of revolution about the axis of a press.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Indenter {
    /// A round head.
    Round {
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// Flat in the middle, then rounded by a quarter circle.
    RoundedFlat {
        /// Half the width of the flat part, mm.
        flat_mm: f64,
        /// Radius of the rounding, mm.
        edge_radius_mm: f64,
    },
    /// From a CSV table with columns x_mm (distance from the axis) and below_mm (how far the face lies behind the tip).
    Table {
        /// The file, relative to the scene file.
        file: PathBuf,
    },
}

/// Equally spaced positions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Positions {
    /// The first, mm.
    pub from: f64,
    /// The last, mm.
    pub to: f64,
    /// How many, ends included.
    pub count: u32,
}

/// Largest radius of a rounded flat indenter's edge, as a share of its flat's half width, at which it is meshed as a
/// flat sensor is: the same share of the whole as that of a sensor's rim.
const LARGEST_EDGE: f64 = 0.5;

impl Indenter {
    /// Half the width of one that is flat but for its edge, mm.
    pub fn flat_face_mm(&self) -> Option<f64> {
        match *self {
            Self::RoundedFlat { flat_mm, edge_radius_mm } if edge_radius_mm <= LARGEST_EDGE * flat_mm => {
                Some(flat_mm + edge_radius_mm)
            }
            _ => None,
        }
    }
}

impl Positions {
    /// The positions, ascending, mm.
    pub fn all_mm(&self) -> Vec<f64> {
        let steps = f64::from(self.count.saturating_sub(1).max(1));
        (0..self.count).map(|k| self.from + (self.to - self.from) * f64::from(k) / steps).collect()
    }
}

fn one() -> f64 {
    1.0
}
