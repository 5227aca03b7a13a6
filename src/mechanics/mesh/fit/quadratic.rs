//! Quadratic elements upon corners that have moved.

use std::collections::HashMap;

use super::super::builder::{Builder, cells};
use super::super::quality::jacobian;
use super::super::{InclusionShape, Mesh, MeshError};
use super::layers::{Layer, Layered};
use super::{corner_node, corners, project};

/// Rounds in which the curved faces of folded layers are made half as curved; after the last they are straight.
const ROUNDS: usize = 4;

/// How curved the surface is at nodes between corners, by the corners they lie between: 1 is the surface itself.
type Curved = HashMap<[u32; 4], f64>;

/// Adds the base mesh's elements, which follow their corners and keep their curved edges, and the layers.
pub(super) fn add(
    builder: &mut Builder,
    base: &Mesh,
    layered: &Layered,
    bodies: &[InclusionShape],
) -> Result<(), MeshError> {
    builder.expect_elements(layered.hexes.len())?;
    for element in 0..base.element_count() {
        let moved = layered.hexes[element].corners;
        let region = match layered.region[element] {
            0 => base.region[element],
            inclusion => inclusion,
        };
        builder.add(region, |local| follow(base, layered, element, moved, local));
    }
    let mut curved = Curved::new();
    for round in 1..=ROUNDS {
        for layer in &layered.layers {
            let nodes = nodes(base, layered, layer, bodies, &curved)?;
            if super::lattice().any(|at| jacobian(3, &nodes, at).0 <= 0.0) {
                for local in face_lattice(layer) {
                    let share = curved.entry(between(base, layer, local)).or_insert(1.0);
                    *share = if round == ROUNDS { 0.0 } else { 0.5 * *share };
                }
            }
        }
    }
    for layer in &layered.layers {
        let nodes = nodes(base, layered, layer, bodies, &curved)?;
        // An inclusion's elements were those of its layer.
        let region = if layer.outer { base.region[layer.element] } else { layered.region[layer.element] };
        builder.add(region, |local| nodes[local[0] + 3 * local[1] + 9 * local[2]]);
    }
    Ok(())
}

/// Places in an element's lattice on the face that a layer stands on.
fn face_lattice(layer: &Layer) -> impl Iterator<Item = [usize; 3]> {
    let (axis, at) = (usize::from(layer.side) / 2, usize::from(layer.side) % 2);
    cells([3; 3]).filter(move |local| local[axis] == 2 * at)
}

/// The corners between which a node of a face lies.
fn between(base: &Mesh, layer: &Layer, local: [usize; 3]) -> [u32; 4] {
    let mut found = [u32::MAX; 4];
    let near = corners(base, layer.element).into_iter().zip(weights(local)).filter(|(_, weight)| *weight > 0.0);
    found.iter_mut().zip(near).for_each(|(slot, (node, _))| *slot = node);
    found.sort_unstable();
    found
}

/// The nodes of a layer's element.
fn nodes(
    base: &Mesh,
    layered: &Layered,
    layer: &Layer,
    bodies: &[InclusionShape],
    curved: &Curved,
) -> Result<Vec<[f64; 3]>, MeshError> {
    let (axis, at) = (usize::from(layer.side) / 2, usize::from(layer.side) % 2);
    let surface = on_surface(base, layered, layer, bodies, curved)?;
    let copy = |node: u32| if layer.outer { node } else { layered.parted.get(&node).map_or(node, |new| new[0]) };
    let moved = corners(base, layer.element).map(copy);
    let node = |local: [usize; 3]| {
        let mut face = local;
        face[axis] = 2 * at;
        let on = surface[face[0] + 3 * face[1] + 9 * face[2]];
        let off = follow(base, layered, layer.element, moved, face);
        // From the inclusion outwards: 0 to 2.
        let along = if at == 1 { local[axis] } else { 2 - local[axis] };
        let share = 0.5 * if layer.outer { 2 - along } else { along } as f64;
        std::array::from_fn(|i| off[i] + share * (on[i] - off[i]))
    };
    Ok(cells([3; 3]).map(node).collect())
}

/// Shares of an element's corners in a node of its lattice.
fn weights(local: [usize; 3]) -> [f64; 8] {
    std::array::from_fn(|corner| {
        (0..3).map(|i| if corner >> i & 1 == 1 { local[i] } else { 2 - local[i] } as f64 * 0.5).product()
    })
}

/// A node of an element whose corners have moved to the points `moved`.
fn follow(base: &Mesh, layered: &Layered, element: usize, moved: [u32; 8], local: [usize; 3]) -> [f64; 3] {
    let nodes = base.element(element);
    let mut at = base.nodes[nodes[local[0] + 3 * local[1] + 9 * local[2]] as usize];
    for (corner, weight) in weights(local).into_iter().enumerate() {
        let (from, to) = (base.nodes[nodes[corner_node(corner)] as usize], layered.points[moved[corner] as usize]);
        (0..3).for_each(|i| at[i] += weight * (to[i] - from[i]));
    }
    at
}

/// The nodes of an inclusion's surface behind a face, under the numbers of the element's lattice there.
fn on_surface(
    base: &Mesh,
    layered: &Layered,
    layer: &Layer,
    bodies: &[InclusionShape],
    curved: &Curved,
) -> Result<[[f64; 3]; 27], MeshError> {
    let number = layered.region[layer.element] as usize;
    let nodes = corners(base, layer.element);
    let mut found = [[0.0; 3]; 27];
    for local in face_lattice(layer) {
        let mut mean = [0.0; 3];
        for (corner, weight) in weights(local).into_iter().enumerate().filter(|(_, weight)| *weight > 0.0) {
            let surface = layered.parted.get(&nodes[corner]).map_or(nodes[corner], |new| new[1]);
            (0..3).for_each(|i| mean[i] += weight * layered.points[surface as usize][i]);
        }
        let on = project(number, &bodies[number - 1], mean)?;
        let share = curved.get(&between(base, layer, local)).copied().unwrap_or(1.0);
        found[local[0] + 3 * local[1] + 9 * local[2]] = std::array::from_fn(|i| mean[i] + share * (on[i] - mean[i]));
    }
    Ok(found)
}
