//! Inclusions fitted into a mesh that was laid without boxes for them.
//!
//! Where inclusions have no boxes of their own (they cross the circle of the contact, lie far out in a cylinder, or
//! stand so near each other that their boxes collide), the base mesh carries outline and contact's edge alone. Then
//! (Schneiders 1996, grid-based generation of hexahedra):
//!
//! 1. elements whose middle lies in an inclusion become its own (`marking`),
//! 2. the staircase between them and the others is parted, and two layers of elements put in, whose common face lies
//!    on the inclusion's surface (`layers`),
//! 3. corners nearby move until no element is folded and shapes are good (`untangle`),
//! 4. quadratic nodes follow the corners, those of the surface lie on it (`quadratic`).
//!
//! The touched face, base and sides keep their nodes, so that the contact does not know how the mesh was made.

mod layers;
mod marking;
mod quadratic;
mod untangle;

use super::builder::{Builder, cells};
use super::quality::{jacobian, position};
use super::{Boundary, Facet, InclusionShape, Mesh, MeshError};
use layers::Layered;

/// Adds the base mesh, with the inclusions fitted into it.
pub(super) fn fit(builder: &mut Builder, base: &Mesh, bodies: &[InclusionShape]) -> Result<(), MeshError> {
    let region = marking::mark(base, bodies)?;
    let mut layered = Layered::new(base, &region, bodies)?;
    let free = layered.free(base);
    untangle::untangle(&mut layered.points, &layered.hexes, &free);
    quadratic::add(builder, base, &layered, bodies)
}

/// An error that names a place where an element is folded at one of its nodes.
///
/// # Errors
/// Such a place.
pub(super) fn sound(mesh: Mesh) -> Result<Mesh, MeshError> {
    for element in 0..mesh.element_count() {
        let nodes = mesh.element_positions(element);
        if lattice().any(|at| jacobian(3, &nodes, at).0 <= 0.0) {
            return Err(MeshError::NotFitted { at_mm: position(3, &nodes, [0.0; 3]) });
        }
    }
    Ok(mesh)
}

/// Local coordinates of an element's nodes.
fn lattice() -> impl Iterator<Item = [f64; 3]> {
    cells([3; 3]).map(|local| local.map(|i| i as f64 - 1.0))
}

/// Node of the lattice of 27 at a corner, whose bits are its places along the axes.
fn corner_node(corner: usize) -> usize {
    2 * (corner & 1) + 6 * (corner >> 1 & 1) + 18 * (corner >> 2 & 1)
}

/// Corners of an element.
fn corners(mesh: &Mesh, element: usize) -> [u32; 8] {
    let nodes = mesh.element(element);
    std::array::from_fn(|corner| nodes[corner_node(corner)])
}

/// Corners of a face of an element, as numbers of the element's corners.
fn face_corners(side: u8) -> [usize; 4] {
    let (axis, at) = (usize::from(side) / 2, usize::from(side) % 2);
    let mut found = [0; 4];
    let on = (0..8).filter(|corner| corner >> axis & 1 == at);
    found.iter_mut().zip(on).for_each(|(slot, corner)| *slot = corner);
    found
}

/// Whether a face of the boundary keeps its nodes.
fn is_fixed(facet: &Facet) -> bool {
    !matches!(facet.boundary, Boundary::SymmetryX | Boundary::SymmetryY)
}

/// The point of an inclusion's surface on the ray from its centre through `point`.
fn project(number: usize, body: &InclusionShape, point: [f64; 3]) -> Result<[f64; 3], MeshError> {
    let arm: [f64; 3] = std::array::from_fn(|i| point[i] - body.center_mm[i]);
    let length = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
    let direction = arm.map(|x| x / length);
    let radius = body.surface.radius(number, direction)?;
    Ok(std::array::from_fn(|i| body.center_mm[i] + radius * direction[i]))
}
