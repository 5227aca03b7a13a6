//! Meshes of quadratic quadrilaterals (two dimensions) and hexahedra (three).
//!
//! All are structured by blocks: a tensor grid of graded lines; around each inclusion a box of it is replaced by an
//! O-grid whose edges carry the inclusion's surface, the nodes between corners on the surface itself. Departure from
//! the field's habit: no free mesher, because blocks of bricks converge faster, are graded at will, and nest. One
//! family of elements then serves all settings. The price is that lines run through the whole body. In three
//! dimensions, inclusions whose boxes collide, or cross the contact's circle, are fitted into the grid instead (`fit`,
//! docs/decisions/meshes.md).

mod boxes;
mod builder;
mod error;
mod fillet;
mod fit;
mod footprint;
mod inclusion;
mod lines;
mod mirror;
mod ogrid;
mod open;
mod phantom;
mod plan;
mod quality;
mod resolution;
mod sensor;
pub mod shapes;
#[cfg(test)]
mod tests;

pub use error::MeshError;
pub use footprint::Footprint;
pub use inclusion::{InclusionShape, Star};
pub use lines::Lines;
pub use mirror::Whole;
pub use phantom::{PhantomMesh, PhantomShape};
pub use quality::Quality;
pub use resolution::Resolution;
pub use sensor::SensorMesh;

/// A mesh of one body.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// 2 or 3.
    pub dim: usize,
    /// Positions of the nodes, mm; the third is 0 in two dimensions.
    pub nodes: Vec<[f64; 3]>,
    /// Nodes of the elements, 3^dim each: a lattice of 3 positions along each local axis (-1, 0, 1), first axis
    /// fastest.
    pub elements: Vec<u32>,
    /// Region of each element: 0 the body itself (or its lowest layer), 1 ... its inclusions (or higher layers).
    pub region: Vec<u32>,
    /// Faces of elements on the body's boundary.
    pub facets: Vec<Facet>,
}

/// A face of an element on the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facet {
    /// The element.
    pub element: u32,
    /// Local face: 2 axis + (0 at -1, 1 at +1).
    pub side: u8,
    /// What the face belongs to.
    pub boundary: Boundary,
}

/// Parts of a body's boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Boundary {
    /// The face towards the contact.
    Touched,
    /// The face opposite, held by the rigid base.
    Base,
    /// Free sides.
    Side,
    /// The plane x = 0 (or the axis r = 0), kept by symmetry.
    SymmetryX,
    /// The plane y = 0, kept by symmetry.
    SymmetryY,
}

impl Mesh {
    /// Nodes of an element: 3^dim.
    pub fn element_size(&self) -> usize {
        3usize.pow(self.dim as u32)
    }

    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.region.len()
    }

    /// Nodes of element `e`.
    pub fn element(&self, e: usize) -> &[u32] {
        let size = self.element_size();
        &self.elements[e * size..(e + 1) * size]
    }

    /// Nodes of a facet, 3^(dim - 1), first remaining axis fastest.
    pub fn facet_nodes(&self, facet: Facet) -> Vec<u32> {
        let element = self.element(facet.element as usize);
        let (axis, at) = (usize::from(facet.side) / 2, 2 * (usize::from(facet.side) % 2));
        let stride = 3usize.pow(axis as u32);
        (0..element.len()).filter(|a| a / stride % 3 == at).map(|a| element[a]).collect()
    }

    /// The facets of one part of the boundary.
    pub fn boundary_facets(&self, boundary: Boundary) -> Vec<Facet> {
        self.facets.iter().copied().filter(|facet| facet.boundary == boundary).collect()
    }

    /// The nodes of one part of the boundary, ascending, each once.
    pub fn boundary_nodes(&self, boundary: Boundary) -> Vec<u32> {
        let mut nodes: Vec<u32> =
            self.boundary_facets(boundary).into_iter().flat_map(|facet| self.facet_nodes(facet)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Lowest and highest coordinates of the nodes, mm.
    pub fn bounding_box(&self) -> [[f64; 3]; 2] {
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for node in &self.nodes {
            for i in 0..3 {
                bounds[0][i] = bounds[0][i].min(node[i]);
                bounds[1][i] = bounds[1][i].max(node[i]);
            }
        }
        bounds
    }
}
