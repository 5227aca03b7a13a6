//! The scene: everything a user says about one sensor, or one scan (`scan.rs`), as read from a TOML file.
//!
//! Lengths are millimetres unless the key says otherwise. The origin is the centre of the lower face of the
//! lowest layer (the glass); z points up, from the camera to what is touched; x runs along an image row, y against
//! the columns. Every key names its unit and unknown keys are refused.

#[cfg(test)]
mod bad_scenes;
pub mod begin;
pub mod contact;
pub mod data_file;
pub mod elastic;
pub mod error;
mod files;
pub mod ies;
mod inputs;
pub mod load;
mod locate;
mod materials;
pub mod mesh_file;
pub mod phantom;
pub mod presets;
pub mod press;
pub mod reference;
pub mod scan;
mod schema;
pub mod sensor;
mod structure;
pub mod table;
pub mod validate;
pub mod view;

pub use contact::*;
pub use data_file::DataFileError;
pub use elastic::*;
pub use error::SceneError;
pub use ies::{IesTable, read_ies};
pub(crate) use inputs::sha256;
pub use inputs::{Input, Inputs};
pub use load::{Loaded, LoadedScan, LoadedScene, load, load_alone, load_scan, parse, parse_scan};
pub(crate) use load::{at_its_place, parse_file, read_text};
pub use mesh_file::{TriangleMesh, read_mesh};
pub use phantom::*;
pub use presets::{PRESETS, SCAN_PRESETS, is_scene, open, open_scan, preset, scan_preset};
pub use press::*;
pub use scan::*;
pub use schema::{scan_schema, schema};
pub use sensor::*;
pub use table::{read_indenter_table, read_pressure_table};
pub use validate::{Invalid, validate, validate_scan};
pub use view::*;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name of the scene; names the default output folder.
    pub name: String,
    /// What the scene is and where its numbers come from.
    #[serde(default)]
    pub description: String,
    /// Wavelength of the light, one per scene.
    pub light: Light,
    /// The layers, their footprint and their side walls.
    pub stack: Stack,
    /// The LEDs at the edge of the stack.
    pub led: Vec<Led>,
    /// The camera under the stack.
    pub camera: Camera,
    /// What deforms the touched face and what makes optical contact with it. Absent: nothing touches.
    #[serde(default)]
    pub touch: Touch,
    /// The phantom that is pressed against the sensor. Absent: none.
    pub phantom: Option<Phantom>,
    /// How it is pressed; shape and pressure of the touched face then follow. Absent: nothing is pressed.
    pub press: Option<Press>,
    /// How the image is computed by default.
    #[serde(default)]
    pub render: Render,
}

/// How the image is computed unless the command line says otherwise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Render {
    /// Light-transport method.
    pub integrator: IntegratorChoice,
    /// Camera paths per pixel.
    pub spp: u32,
    /// Photons sent from the LEDs; used by `splat`, `map` and the ledger. Absent: chosen from `spp`.
    pub photons: Option<u64>,
    /// Edge of a texel of the irradiance map, mm. The default keeps its bias below the noise (docs/decisions).
    pub map_texel_mm: f64,
    /// Whether the irradiance map is smoothed. That leaves little noise, and a bias that is small beside it but that
    /// all renders of a scene share: where many images are averaged, or learnt from, leave it out.
    pub map_smoothing: bool,
    /// Whether photons count for all places that mirror images make alike, in scenes that have such. The noise of the
    /// map is then its own mirror image too.
    pub symmetry: bool,
    /// Control points along the longer side of a deformed interface held as a height field.
    pub height_field_points: u32,
    /// Seed of all random numbers.
    pub seed: u32,
}

impl Default for Render {
    fn default() -> Self {
        Self {
            integrator: IntegratorChoice::Auto,
            spp: 64,
            photons: None,
            map_texel_mm: 0.125,
            map_smoothing: true,
            symmetry: true,
            height_field_points: 256,
            seed: 1,
        }
    }
}

/// Which light-transport method is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum IntegratorChoice {
    /// Chosen from the scene; the reason is reported.
    Auto,
    /// From the camera through everything until a ray meets an LED. Unbiased; the reference.
    Path,
    /// Photons from the LEDs, connected to the pinhole at each diffuse vertex. Flat stacks only.
    Splat,
    /// Photons fill an irradiance map on the touched face; camera rays read it.
    Map,
}

impl std::str::FromStr for IntegratorChoice {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "auto" => Ok(Self::Auto),
            "path" => Ok(Self::Path),
            "splat" => Ok(Self::Splat),
            "map" => Ok(Self::Map),
            _ => Err("it must be auto, path, splat or map"),
        }
    }
}
