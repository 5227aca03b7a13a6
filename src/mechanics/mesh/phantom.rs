//! Meshes of the phantom: a tensor grid of graded lines in which each inclusion's box holds an O-grid.

use super::boxes::{Domain, InclusionBox};
use super::builder::{Builder, between_planes};
use super::error::positive;
use super::fillet::rim_start;
use super::lines::Grading;
use super::ogrid::Ogrid;
use super::{Footprint, InclusionShape, Lines, Mesh, MeshError, Resolution};

/// Where elements are narrow along r, inside the contact's edge, in units of the size there.
const WITHIN_EDGE: [f64; 2] = [1.0, 0.3];

/// Outer shape of a phantom; it stands on its touched face z = 0, its axis is x = y = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PhantomShape {
    /// A round cylinder.
    Cylinder {
        /// Its radius, mm.
        radius_mm: f64,
        /// Its height, mm.
        height_mm: f64,
    },
    /// A block.
    Block {
        /// Its whole widths along x and y, mm.
        size_mm: [f64; 2],
        /// Its height, mm.
        height_mm: f64,
    },
}

/// A phantom with inclusions, to be meshed. Regions: 0 the phantom, k inclusion k (from 1), then the layers.
#[derive(Debug, Clone, PartialEq)]
pub struct PhantomMesh {
    /// Outer shape.
    pub shape: PhantomShape,
    /// Bodies inside.
    pub inclusions: Vec<InclusionShape>,
    /// Where it is pressed; elements are graded to this outline.
    pub footprint: Footprint,
    /// Whether only x >= 0 and only y >= 0 are meshed. In axisymmetry the first must be set.
    pub symmetry: [bool; 2],
    /// Size of elements.
    pub resolution: Resolution,
    /// Place of the outline's centre, in three dimensions, mm. Inclusions' places count from the footprint's axis.
    pub offset_mm: [f64; 2],
    /// Thickness of the layers between the touched face and the phantom itself, the touched one first, mm. Each
    /// inclusion lies in one of them or below all.
    pub layers_mm: Vec<f64>,
}

/// Grid lines and boxes.
pub(super) struct Layout {
    /// Lines along each axis, the last across the touched face.
    pub axes: Vec<Lines>,
    /// The inclusions' boxes.
    pub boxes: Vec<InclusionBox>,
    /// Sizes along the first axis.
    pub radial: Grading,
}

impl PhantomShape {
    pub(super) fn half_widths(&self) -> [f64; 2] {
        match *self {
            Self::Cylinder { radius_mm, .. } => [radius_mm; 2],
            Self::Block { size_mm, .. } => size_mm.map(|size| 0.5 * size),
        }
    }

    /// Height, mm.
    pub fn height_mm(&self) -> f64 {
        match *self {
            Self::Cylinder { height_mm, .. } | Self::Block { height_mm, .. } => height_mm,
        }
    }
}

impl Footprint {
    /// Half the widths along x and y, mm.
    pub fn half_widths_mm(&self) -> [f64; 2] {
        self.half_widths()
    }

    pub(super) fn half_widths(&self) -> [f64; 2] {
        match *self {
            Self::Round { radius_mm } => [radius_mm; 2],
            Self::Rectangle { half_widths_mm } => half_widths_mm,
        }
    }
}

impl PhantomMesh {
    /// The mesh of the section y = 0: quadrilaterals in (x, z), or in (r, z) with the first symmetry.
    ///
    /// # Errors
    /// Sizes not positive, inclusions that stick out or cannot be told apart, too many elements.
    pub fn build_2d(&self) -> Result<Mesh, MeshError> {
        let layout = self.layout(2, self.shape.half_widths())?;
        let mut builder = Builder::new(2);
        self.fill(&mut builder, &layout)?;
        builder.finish(between_planes(2, 0.0, self.shape.height_mm(), self.symmetry))
    }

    /// The x-lines of [`Self::build_2d`] within the contact, for a sensor that shares its nodes.
    ///
    /// # Errors
    /// As `build_2d`.
    pub fn contact_lines(&self) -> Result<Lines, MeshError> {
        let layout = self.layout(2, self.shape.half_widths())?;
        let edge = self.footprint.half_widths()[0];
        Ok(layout.axes.first().map_or(Lines(Vec::new()), |lines| lines.between(-edge, edge)))
    }

    /// The same phantom with elements of twice the size, for an estimate of the error from two meshes.
    pub fn halved(&self) -> Self {
        Self { resolution: self.resolution.halved(), ..self.clone() }
    }

    /// Region of the layer at a depth, or of the phantom itself below all.
    fn region_at(&self, depth_mm: f64) -> u32 {
        let above = self.interfaces().partition_point(|&face| face <= depth_mm);
        if above < self.layers_mm.len() { (self.inclusions.len() + 1 + above) as u32 } else { 0 }
    }

    /// Depths of the layers' lower faces, mm.
    pub(super) fn interfaces(&self) -> Vec<f64> {
        let sum = |depth: &mut f64, thickness: &f64| {
            *depth += thickness;
            Some(*depth)
        };
        self.layers_mm.iter().scan(0.0, sum).collect()
    }

    /// Regions between lines across the touched face.
    pub(super) fn regions(&self, heights: &Lines) -> Vec<u32> {
        heights.0.windows(2).map(|pair| self.region_at(0.5 * (pair[0] + pair[1]))).collect()
    }

    /// Values by region, each inclusion's that of what surrounds it.
    pub fn plain<T: Clone>(&self, of_region: &[T]) -> Vec<T> {
        let mut plain = of_region.to_vec();
        for (value, inclusion) in plain.iter_mut().skip(1).zip(&self.inclusions) {
            if let Some(around) = of_region.get(self.region_at(inclusion.center_mm[2]) as usize) {
                *value = around.clone();
            }
        }
        plain
    }

    /// Adds grid and inclusions.
    pub(super) fn fill(&self, builder: &mut Builder, layout: &Layout) -> Result<(), MeshError> {
        let dim = layout.axes.len();
        let inside = |cell: [usize; 3]| {
            layout.boxes.iter().any(|item| {
                (0..dim).all(|axis| {
                    let lines = &layout.axes[axis].0;
                    lines[cell[axis]] >= item.range[axis][0] && lines[cell[axis] + 1] <= item.range[axis][1]
                })
            })
        };
        let regions = self.regions(&layout.axes[dim - 1]);
        builder.add_grid(&layout.axes, |cell| (!inside(cell)).then_some(regions[cell[dim - 1]]))?;
        let rings =
            (0.45 * self.resolution.inclusion_divisions).round().max(1.0) as usize * self.resolution.subdivision;
        for (k, (item, shape)) in layout.boxes.iter().zip(&self.inclusions).enumerate() {
            let axis_nodes = |axis: usize| match layout.axes.get(axis) {
                Some(lines) => lines.between(item.range[axis][0], item.range[axis][1]).nodes(),
                None => vec![0.0],
            };
            let radius = |u: [f64; 3]| shape.surface.radius(k + 1, if dim == 2 { [u[0], 0.0, u[1]] } else { u });
            let ogrid = Ogrid {
                dim,
                center: item.center,
                axes: [axis_nodes(0), axis_nodes(1), axis_nodes(2)],
                cut: item.cut,
                rings: [rings; 2],
                regions: [k as u32 + 1, self.region_at(shape.center_mm[2])],
                radius: &radius,
            };
            ogrid.fill(builder)?;
        }
        Ok(())
    }

    /// Whether all sizes are positive; `half` are half widths of the grid.
    pub(super) fn check_sizes(&self, half: [f64; 2]) -> Result<(), MeshError> {
        self.resolution.check()?;
        for width in self.shape.half_widths().into_iter().chain(half) {
            positive("the phantom's width", width)?;
        }
        let mut below = positive("the phantom's height", self.shape.height_mm())?;
        for &thickness in &self.layers_mm {
            below -= positive("the thickness of a phantom's layer", thickness)?;
            positive("what is left of the phantom's height below its layers", below)?;
        }
        for width in self.footprint.half_widths() {
            positive("the contact's width", width)?;
        }
        Ok(())
    }

    /// Lines and boxes in a grid of the given half widths along x and y.
    pub(super) fn layout(&self, dim: usize, half: [f64; 2]) -> Result<Layout, MeshError> {
        self.check_sizes(half)?;
        let (domain, mut lines) = self.domain(dim, half);
        let mut shapes = Vec::new();
        for inclusion in &self.inclusions {
            let extent = inclusion.surface.extent()?;
            let [x, y, z] = inclusion.center_mm;
            shapes.push(if dim == 2 { ([x, z, 0.0], [extent[0], extent[2], [0.0; 2]]) } else { ([x, y, z], extent) });
        }
        let boxes = domain.boxes(&shapes)?;
        let mut axes = Vec::new();
        for (axis, breaks) in lines.iter_mut().enumerate().take(dim) {
            breaks.extend(boxes.iter().flat_map(|item| item.range[axis]));
            breaks.sort_by(f64::total_cmp);
            breaks.dedup();
            axes.push(self.grading(&domain, axis, &boxes).lines(breaks, self.resolution.subdivision)?);
        }
        let radial = self.grading(&domain, 0, &boxes);
        Ok(Layout { axes, boxes, radial })
    }

    pub(super) fn domain(&self, dim: usize, half: [f64; 2]) -> (Domain, [Vec<f64>; 3]) {
        let plane = |axis: usize| {
            // A grid as wide as the phantom ends where the phantom does.
            let shift = if dim == 3 && half == self.shape.half_widths() { self.offset_mm[axis] } else { 0.0 };
            let (width, low) = (half[axis] + shift, if self.symmetry[axis] { 0.0 } else { shift - half[axis] });
            let edge = self.footprint.half_widths()[axis];
            let start = rim_start(self.resolution.rim_mm, edge);
            let inner = [-edge, -start, start, edge].into_iter().filter(|&x| low < x && x < width);
            ([low, width], inner.collect::<Vec<f64>>())
        };
        let height = [0.0, self.shape.height_mm()];
        let (x, y, interfaces) = (plane(0), plane(1), self.interfaces());
        let (range, lines) = if dim == 2 {
            ([x.0, height, [0.0; 2]], [x.1, interfaces, Vec::new()])
        } else {
            ([x.0, y.0, height], [x.1, y.1, interfaces])
        };
        let side = |symmetric: bool| if symmetric { ["plane of symmetry", "side"] } else { ["side"; 2] };
        let mut faces = [side(self.symmetry[0]), side(self.symmetry[1]), [""; 2]];
        faces[dim - 1] = ["touched face", "base"];
        let mut symmetry = [self.symmetry[0], self.symmetry[1], false];
        symmetry[dim - 1] = false;
        let mut all = lines.clone();
        (0..dim).for_each(|axis| all[axis].extend(range[axis]));
        (Domain { dim, range, faces, symmetry, lines }, all)
    }

    /// Sizes along one axis: small at the touched face, the contact's edge and the inclusions.
    pub(super) fn grading(&self, domain: &Domain, axis: usize, boxes: &[InclusionBox]) -> Grading {
        let size = self.resolution;
        let mut features = Vec::new();
        if axis + 1 == domain.dim {
            features.push([0.0, 0.0, size.edge_mm]);
        } else {
            let edge = self.footprint.half_widths()[axis];
            features.extend([[edge, edge, size.edge_mm], [-edge, -edge, size.edge_mm], [-edge, edge, size.contact_mm]]);
            if domain.dim == 2 && size.ring_share < 1.0 {
                let [low, high] = WITHIN_EDGE.map(|share| edge - share * size.edge_mm);
                features.push([low, high, size.ring_share * size.edge_mm]);
            }
        }
        for item in boxes {
            let [low, high] = item.range[axis];
            let cells = size.inclusion_divisions * if item.cut[axis] { 1.0 } else { 2.0 };
            features.push([low, high, (high - low) / cells]);
            // In a thin gap above a curved surface the stress changes over sqrt(2 R gap), as in lubrication.
            for across in (0..domain.dim).filter(|&across| across != axis) {
                for side in 0..2 {
                    let (gap, reach) = (item.free[across][side], item.extent[across][side].abs());
                    if !(side == 0 && item.cut[across]) {
                        let radius = item.extent[axis][1].powi(2) / reach;
                        features.push([item.center[axis], item.center[axis], 0.6 * (2.0 * radius * gap).sqrt()]);
                    }
                }
            }
        }
        Grading { growth: size.growth, coarsest_mm: size.coarsest_mm, features }
    }
}
