//! Meshes of the sensor: a stack of layers below the touched face.

use super::builder::{Builder, between_planes};
use super::error::positive;
use super::fillet::{Fillet, rim_start};
use super::lines::Grading;
use super::{Footprint, Lines, Mesh, MeshError, PhantomMesh, PhantomShape, Resolution};

/// A stack of layers whose top is the touched face z = 0. Regions: the layers, 0 the lowest.
#[derive(Debug, Clone)]
pub struct SensorMesh {
    /// Outline in plan.
    pub footprint: Footprint,
    /// Thickness of each layer, lowest first, mm.
    pub layers_mm: Vec<f64>,
    /// Whether only x >= 0 and only y >= 0 are meshed. In axisymmetry the first must be set.
    pub symmetry: [bool; 2],
    /// Size of elements.
    pub resolution: Resolution,
    /// Radius of the touched face's rim, mm; 0 where it is sharp.
    pub edge_radius_mm: f64,
}

impl SensorMesh {
    /// The mesh of the section y = 0. Given a phantom of the same footprint, symmetry and resolution, the nodes of the
    /// touched face are those of the phantom's within the contact.
    ///
    /// # Errors
    /// Sizes not positive, too many elements, a phantom that does not carry the contact's edge.
    pub fn build_2d(&self, phantom: Option<&PhantomMesh>) -> Result<Mesh, MeshError> {
        let (heights, regions) = self.heights()?;
        let edge = self.footprint.half_widths()[0];
        let low = if self.symmetry[0] { 0.0 } else { -edge };
        let lines = phantom.unwrap_or(&self.alone()).contact_lines()?;
        let start = rim_start(self.edge_radius_mm, edge);
        if lines.0.first() != Some(&low) || lines.0.last() != Some(&edge) || !lines.0.contains(&start) {
            return Err(MeshError::NoSharedEdge { edge_mm: edge });
        }
        let base = heights.0.first().copied().unwrap_or(0.0);
        let mut builder = Builder::new(2);
        builder.add_grid(&[lines, heights], |cell| regions.get(cell[1]).copied())?;
        self.rounded(builder.finish(between_planes(2, 0.0, base, self.symmetry))?)
    }

    /// The mesh of hexahedra, as [`Self::build_2d`].
    ///
    /// # Errors
    /// As `build_2d`.
    pub fn build_3d(&self, phantom: Option<&PhantomMesh>) -> Result<Mesh, MeshError> {
        let (heights, regions) = self.heights()?;
        let plan = phantom.unwrap_or(&self.alone()).contact_plan()?;
        let edges = self.footprint.half_widths();
        if phantom.is_some_and(|phantom| phantom.footprint != self.footprint || phantom.symmetry != self.symmetry) {
            return Err(MeshError::NoSharedEdge { edge_mm: edges[0] });
        }
        let base = heights.0.first().copied().unwrap_or(0.0);
        let mut builder = Builder::new(3);
        plan.add_sectors(&mut builder, &heights, &regions)?;
        let [x, y] = plan.core;
        builder.add_grid(&[x, y, heights], |cell| regions.get(cell[2]).copied())?;
        self.rounded(builder.finish(between_planes(3, 0.0, base, self.symmetry))?)
    }

    /// The same sensor with elements of twice the size.
    pub fn halved(&self) -> Self {
        Self { resolution: self.resolution.halved(), ..self.clone() }
    }

    /// The mesh with its rim rounded.
    fn rounded(&self, mut mesh: Mesh) -> Result<Mesh, MeshError> {
        if let (true, Some(&layer_mm)) = (self.edge_radius_mm > 0.0, self.layers_mm.last()) {
            Fillet { radius_mm: self.edge_radius_mm, layer_mm }.round(&mut mesh, self.footprint)?;
        }
        Ok(mesh)
    }

    /// A body of the sensor's own outline, pressed all over, for its lines.
    fn alone(&self) -> PhantomMesh {
        let height_mm = self.layers_mm.iter().sum();
        let shape = match self.footprint {
            Footprint::Round { radius_mm } => PhantomShape::Cylinder { radius_mm, height_mm },
            Footprint::Rectangle { half_widths_mm } => {
                PhantomShape::Block { size_mm: half_widths_mm.map(|half| 2.0 * half), height_mm }
            }
        };
        let (footprint, symmetry) = (self.footprint, self.symmetry);
        let resolution = self.resolution.with_rim(self.edge_radius_mm);
        PhantomMesh {
            shape,
            inclusions: Vec::new(),
            footprint,
            symmetry,
            resolution,
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        }
    }

    /// Lines across the layers and the layer of each cell.
    pub(super) fn heights(&self) -> Result<(Lines, Vec<u32>), MeshError> {
        self.resolution.check()?;
        for width in self.footprint.half_widths() {
            positive("the sensor's width", width)?;
        }
        positive("the number of layers", self.layers_mm.len() as f64)?;
        let mut breaks = vec![0.0];
        for &thickness in self.layers_mm.iter().rev() {
            let below = breaks.last().copied().unwrap_or(0.0) - positive("the thickness of a layer", thickness)?;
            breaks.push(below);
        }
        breaks.reverse();
        let size = self.resolution;
        let features = vec![[0.0, 0.0, size.edge_mm]];
        let grading = Grading { growth: size.growth, coarsest_mm: size.coarsest_mm, features };
        let lines = grading.lines(&breaks, size.subdivision)?;
        let layer = |pair: &[f64]| breaks.partition_point(|&at| at <= 0.5 * (pair[0] + pair[1])) as u32 - 1;
        let regions = lines.0.windows(2).map(layer).collect();
        Ok((lines, regions))
    }
}
