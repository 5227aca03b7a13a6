//! Which elements of the base mesh become an inclusion's.

use std::collections::HashMap;

use super::super::{InclusionShape, Mesh, MeshError};
use super::{corners, face_corners, is_fixed};

/// Node in the middle of an element's lattice.
const MIDDLE: usize = 13;

/// Most rounds of taking elements away: each takes at least one, and staircases of star-shaped bodies need few.
const ROUNDS: usize = 100;

/// The region of each element: the inclusion that holds its middle, or 0. Elements at the boundary are nobody's, no two
/// inclusions share a node, and the staircase around each is a manifold.
pub(super) fn mark(mesh: &Mesh, bodies: &[InclusionShape]) -> Result<Vec<u32>, MeshError> {
    let mut barred = vec![false; mesh.element_count()];
    mesh.facets.iter().filter(|facet| is_fixed(facet)).for_each(|facet| barred[facet.element as usize] = true);
    let mut region = vec![0; mesh.element_count()];
    let mut owner = vec![0u32; mesh.nodes.len()];
    for (k, body) in bodies.iter().enumerate() {
        let number = k as u32 + 1;
        for element in (0..region.len()).filter(|&e| !barred[e]) {
            let middle = mesh.nodes[mesh.element(element)[MIDDLE] as usize];
            let nodes = corners(mesh, element);
            let taken = nodes.iter().any(|&node| ![0, number].contains(&owner[node as usize]));
            if !taken && region[element] == 0 && holds(k + 1, body, middle)? {
                region[element] = number;
                nodes.iter().for_each(|&node| owner[node as usize] = number);
            }
        }
    }
    for _ in 0..ROUNDS {
        let odd = not_manifold(mesh, &region);
        if odd.is_empty() {
            break;
        }
        odd.into_iter().for_each(|element| region[element] = 0);
    }
    match (1..=bodies.len()).find(|&number| !region.contains(&(number as u32))) {
        Some(inclusion) => Err(MeshError::TooCoarse { inclusion }),
        None => Ok(region),
    }
}

/// Whether a point lies within an inclusion.
pub(super) fn holds(number: usize, body: &InclusionShape, point: [f64; 3]) -> Result<bool, MeshError> {
    let arm: [f64; 3] = std::array::from_fn(|i| point[i] - body.center_mm[i]);
    let length = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length == 0.0 {
        return Ok(true);
    }
    let bounds = body.surface.extent()?;
    if (0..3).any(|i| arm[i] < bounds[i][0] || arm[i] > bounds[i][1]) {
        return Ok(false);
    }
    Ok(length < body.surface.radius(number, arm.map(|x| x / length))?)
}

/// The faces of inclusions' elements that have an element of another region behind them: element and side.
pub(super) fn interface(mesh: &Mesh, region: &[u32]) -> Vec<(usize, u8)> {
    let middle = |element: usize, side: u8| {
        let (axis, at) = (usize::from(side) / 2, 2 * (usize::from(side) % 2));
        let stride = 3usize.pow(axis as u32);
        mesh.element(element)[MIDDLE + at * stride - stride]
    };
    let mut behind: HashMap<u32, [u32; 2]> = HashMap::new();
    let faces = || (0..region.len()).flat_map(|element| (0..6).map(move |side| (element, side)));
    for (element, side) in faces() {
        let both = behind.entry(middle(element, side)).or_insert([0; 2]);
        both[0] += 1;
        both[1] += region[element];
    }
    // With two elements at a face the sum of their regions tells whether they differ, since one of them is 0 if so.
    let parts = |&(element, side): &(usize, u8)| {
        let number = region[element];
        number > 0 && behind.get(&middle(element, side)) == Some(&[2, number])
    };
    faces().filter(parts).collect()
}

/// Elements of inclusions at an edge or a corner where the staircase meets itself, and those that all but stand alone.
fn not_manifold(mesh: &Mesh, region: &[u32]) -> Vec<usize> {
    let facets = interface(mesh, region);
    let mut edges: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    let mut at_node: HashMap<u32, Vec<usize>> = HashMap::new();
    let mut faces = HashMap::new();
    for (number, &(element, side)) in facets.iter().enumerate() {
        *faces.entry(element).or_insert(0) += 1;
        let nodes = corners(mesh, element);
        let [a, b, c, d] = face_corners(side).map(|corner| nodes[corner]);
        for [from, to] in [[a, b], [b, d], [d, c], [c, a]] {
            edges.entry([from.min(to), from.max(to)]).or_default().push(number);
        }
        [a, b, c, d].into_iter().for_each(|node| at_node.entry(node).or_default().push(number));
    }
    let mut odd: Vec<usize> = faces.iter().filter(|(_, count)| **count >= 5).map(|(element, _)| *element).collect();
    odd.extend(edges.values().filter(|at| at.len() > 2).flatten().map(|&number| facets[number].0));
    for (node, around) in &at_node {
        // Facets reached from the first by edges through the node.
        let mut reached = vec![around[0]];
        let mut next = 0;
        while next < reached.len() {
            let through = facets_near(&edges, mesh, facets[reached[next]], *node);
            let new: Vec<usize> = through.into_iter().filter(|number| !reached.contains(number)).collect();
            reached.extend(new);
            next += 1;
        }
        if around.iter().any(|number| !reached.contains(number)) {
            odd.extend(around.iter().map(|&number| facets[number].0));
        }
    }
    odd.sort_unstable();
    odd.dedup();
    odd
}

/// Facets, by their edges, at those edges of a facet that end at a node.
fn facets_near(
    edges: &HashMap<[u32; 2], Vec<usize>>,
    mesh: &Mesh,
    (element, side): (usize, u8),
    node: u32,
) -> Vec<usize> {
    let nodes = corners(mesh, element);
    let ends = face_corners(side).map(|corner| nodes[corner]);
    let keys = ends.iter().map(|&end| [end.min(node), end.max(node)]);
    keys.filter_map(|key| edges.get(&key)).flatten().copied().collect()
}
