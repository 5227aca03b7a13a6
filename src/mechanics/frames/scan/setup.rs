//! From a scan scene to a mesh, materials and an indenter.

use super::ScanError;
use crate::mechanics::contact::{Grip, Profile};
use crate::mechanics::from_scene;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, PhantomMesh, Resolution};
use crate::scene::LoadedScan;

/// Description of a scan.
#[derive(Debug, Clone)]
pub struct ScanSetup {
    /// The tissue and its mesh; the footprint is all that frames see.
    pub tissue: PhantomMesh,
    /// Material of the tissue, then of each inclusion.
    pub materials: Vec<Material>,
    /// Shape of the indenter.
    pub indenter: Profile,
    /// What happens between indenter and tissue: frictionless or Coulomb.
    pub grip: Grip,
    /// How far the indenter is pressed in from first touch, mm.
    pub depth_mm: f64,
    /// Positions of the indenter's axis, ascending, mm.
    pub positions_mm: Vec<f64>,
    /// Places of a frame about the indenter's axis, ascending, mm.
    pub places_mm: Vec<f64>,
}

/// Sizes of elements at resolution 1. Along the face they are 0.4 mm: the contact ends with a vertical tangent of the
/// pressure somewhere between two nodes, half an element apart, and moves with the position.
const RESOLUTION: Resolution = Resolution {
    edge_mm: 0.8,
    ring_share: 1.0,
    contact_mm: 0.8,
    coarsest_mm: 5.0,
    growth: 0.5,
    rim_mm: 0.0,
    rim_divisions: 1.0,
    inclusion_divisions: 4.0,
    subdivision: 2,
};

impl ScanSetup {
    /// The scan of a scene. Its tissue is pressed so slowly that all is relaxed.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn from_scene(loaded: &LoadedScan) -> Result<Self, ScanError> {
        let (phantom, scan) = (&loaded.scene.phantom, &loaded.scene.scan);
        let inclusions = phantom.inclusion.iter().map(|one| from_scene::inclusion_shape(one, &loaded.files));
        let half = scan.frame_half_width_mm;
        let reach = scan.positions_mm.from.abs().max(scan.positions_mm.to.abs()) + half;
        let steps = f64::from(scan.frame_points.saturating_sub(1).max(1));
        Ok(Self {
            tissue: PhantomMesh {
                shape: from_scene::phantom_shape(&phantom.shape),
                inclusions: inclusions.collect::<Result<_, _>>()?,
                footprint: Footprint::Rectangle { half_widths_mm: [reach; 2] },
                symmetry: [false; 2],
                resolution: RESOLUTION.finer(scan.resolution),
                offset_mm: [0.0; 2],
                layers_mm: phantom.layer.iter().map(|layer| layer.thickness_mm).collect(),
            },
            materials: from_scene::materials(phantom)?,
            indenter: from_scene::profile(&scan.indenter, &loaded.files)?,
            grip: from_scene::grip(scan.interface),
            depth_mm: scan.depth_mm,
            positions_mm: scan.positions_mm.all_mm(),
            places_mm: (0..scan.frame_points).map(|k| half * (2.0 * f64::from(k) / steps - 1.0)).collect(),
        })
    }

    /// The same scan on elements of twice the size.
    pub fn halved(&self) -> Self {
        Self { tissue: self.tissue.halved(), ..self.clone() }
    }

    /// The same scan of the same mesh without inclusions: each is of the tissue around it.
    pub fn without_inclusions(&self) -> Self {
        Self { materials: self.tissue.plain(&self.materials), ..self.clone() }
    }
}
