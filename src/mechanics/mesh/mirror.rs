//! Whole bodies from the part that planes of symmetry leave.

use super::{Boundary, Facet, Mesh};

/// A mesh with its mirror images, which share the nodes on the planes between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Whole {
    /// The whole.
    pub mesh: Mesh,
    /// Of each node, that of the part, and the signs that a vector's components take.
    pub nodes: Vec<(u32, [f64; 3])>,
    /// Of each element, that of the part, and the same signs.
    pub elements: Vec<(u32, [f64; 3])>,
}

impl Mesh {
    /// The body that this mesh is a half or a quarter of: its images in the planes x = 0 (or the axis) and y = 0, where
    /// these are planes of symmetry.
    pub fn whole(&self, symmetry: [bool; 2]) -> Whole {
        let alone = |count: usize| (0..count as u32).map(|k| (k, [1.0; 3])).collect();
        let mut whole =
            Whole { mesh: self.clone(), nodes: alone(self.nodes.len()), elements: alone(self.element_count()) };
        for axis in (0..self.dim - 1).filter(|&axis| symmetry[axis]) {
            whole.mirror(axis);
        }
        whole
    }
}

impl Whole {
    fn mirror(&mut self, axis: usize) {
        let plane = [Boundary::SymmetryX, Boundary::SymmetryY][axis];
        let (count, size) = (self.mesh.nodes.len(), self.mesh.element_size());
        let mut image: Vec<Option<u32>> = vec![None; count];
        self.mesh.boundary_nodes(plane).into_iter().for_each(|node| image[node as usize] = Some(node));
        for (node, slot) in image.iter_mut().enumerate().filter(|(_, slot)| slot.is_none()) {
            *slot = Some(self.mesh.nodes.len() as u32);
            let mut at = self.mesh.nodes[node];
            at[axis] = -at[axis];
            self.mesh.nodes.push(at);
            self.nodes.push(mirrored(self.nodes[node], axis));
        }
        let image: Vec<u32> = image.into_iter().flatten().collect();
        // Rows the other way round, so that the image is no less right-handed.
        let images = self.mesh.elements.chunks(3).flat_map(|row| row.iter().rev());
        let images: Vec<u32> = images.map(|&node| image[node as usize]).collect();
        let elements = self.mesh.element_count();
        self.mesh.elements.extend(images);
        self.mesh.region.extend_from_within(..);
        self.elements.extend_from_within(..);
        self.elements[elements..].iter_mut().for_each(|element| *element = mirrored(*element, axis));
        assert_eq!(self.mesh.elements.len(), size * self.mesh.element_count());
        self.mesh.facets.retain(|facet| facet.boundary != plane);
        let turned = |facet: &Facet| Facet {
            element: facet.element + elements as u32,
            side: if facet.side < 2 { 1 - facet.side } else { facet.side },
            ..*facet
        };
        let images: Vec<Facet> = self.mesh.facets.iter().map(turned).collect();
        self.mesh.facets.extend(images);
    }
}

fn mirrored((of, mut signs): (u32, [f64; 3]), axis: usize) -> (u32, [f64; 3]) {
    signs[axis] = -signs[axis];
    (of, signs)
}
