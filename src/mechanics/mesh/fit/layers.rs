//! The staircase around inclusions parted, and two layers of elements put in.

use std::collections::HashMap;

use super::super::{InclusionShape, Mesh, MeshError};
use super::marking::interface;
use super::untangle::{Free, Hex};
use super::{corners, face_corners, is_fixed, project};

/// Thickness that a layer aims at, in units of the element that it is put upon.
const THICKNESS: f64 = 0.5;

/// Rounds in which corners on a surface move towards the mean of their neighbours.
const SMOOTHING: usize = 12;

/// Elements around an inclusion whose corners may move.
const NEIGHBOURHOOD: usize = 2;

/// A layer's element: the element and face of the inclusion that it stands on.
#[derive(Clone, Copy)]
pub(super) struct Layer {
    pub element: usize,
    pub side: u8,
    /// Outside of the surface.
    pub outer: bool,
}

/// A base mesh with layers, by corners.
pub(super) struct Layered {
    /// Corners, mm: the base mesh's nodes under their numbers (those between corners lie idle), then new ones.
    pub points: Vec<[f64; 3]>,
    /// Elements: those of the base mesh under their numbers, then the layers.
    pub hexes: Vec<Hex>,
    /// The layers' elements.
    pub layers: Vec<Layer>,
    /// Inclusion of each element of the base mesh, or 0.
    pub region: Vec<u32>,
    /// Of corners on the staircase: the corner within and that on the surface.
    pub parted: HashMap<u32, [u32; 2]>,
}

impl Layered {
    pub fn new(base: &Mesh, region: &[u32], bodies: &[InclusionShape]) -> Result<Self, MeshError> {
        let facets = interface(base, region);
        let mut points = base.nodes.clone();
        let mut parted: HashMap<u32, [u32; 2]> = HashMap::new();
        let mut number_of: HashMap<u32, u32> = HashMap::new();
        let mut neighbours: HashMap<u32, Vec<u32>> = HashMap::new();
        for &(element, side) in &facets {
            let nodes = corners(base, element);
            let [a, b, c, d] = face_corners(side).map(|corner| nodes[corner]);
            for node in [a, b, c, d] {
                parted.entry(node).or_insert_with(|| {
                    points.extend([base.nodes[node as usize]; 2]);
                    [points.len() as u32 - 2, points.len() as u32 - 1]
                });
                number_of.insert(node, region[element]);
            }
            for (from, to) in [(a, b), (b, d), (d, c), (c, a)] {
                neighbours.entry(from).or_default().push(to);
                neighbours.entry(to).or_default().push(from);
            }
        }
        let mut layered = Self { points, hexes: Vec::new(), layers: Vec::new(), region: region.to_vec(), parted };
        layered.add_hexes(base, &facets);
        let mut staircase: Vec<(u32, usize)> = number_of.into_iter().map(|(n, number)| (n, number as usize)).collect();
        staircase.sort_unstable();
        layered.smooth(base, &staircase, &neighbours, bodies)?;
        Ok(layered)
    }

    fn add_hexes(&mut self, base: &Mesh, facets: &[(usize, u8)]) {
        for element in 0..base.element_count() {
            let nodes = corners(base, element);
            let mut hex = Hex::new(nodes, &base.nodes, 1.0, 0);
            if self.region[element] > 0 {
                hex.corners = nodes.map(|node| self.parted.get(&node).map_or(node, |new| new[0]));
            }
            self.hexes.push(hex);
        }
        for &(element, side) in facets {
            for outer in [false, true] {
                let nodes = corners(base, element);
                let (axis, at) = (usize::from(side) / 2, usize::from(side) % 2);
                let mut hex = Hex::new(nodes, &base.nodes, THICKNESS, axis);
                for corner in 0..8 {
                    let face = corner & !(1 << axis) | at << axis;
                    // The element lies before the layer along the axis where the face is its upper one.
                    let far = (corner >> axis & 1 == 1) == (at == 1);
                    let node = nodes[face];
                    let new = self.parted.get(&node).copied().unwrap_or([node; 2]);
                    hex.corners[corner] = match (outer, far) {
                        (false, false) => new[0],
                        (false, true) | (true, false) => new[1],
                        (true, true) => node,
                    };
                    hex.aims[corner] = hex.aims[face];
                }
                self.hexes.push(hex);
                self.layers.push(Layer { element, side, outer });
            }
        }
    }

    /// Corners on the surfaces evenly spread; those within and without off them.
    fn smooth(
        &mut self,
        base: &Mesh,
        staircase: &[(u32, usize)],
        neighbours: &HashMap<u32, Vec<u32>>,
        bodies: &[InclusionShape],
    ) -> Result<(), MeshError> {
        let held = planes(base);
        for round in 0..=SMOOTHING {
            let before = self.points.clone();
            for &(node, number) in staircase {
                let [_, surface] = self.parted[&node];
                let mut mean = before[surface as usize];
                if let (true, Some(near)) = (round > 0, neighbours.get(&node)) {
                    for i in (0..3).filter(|&i| !held[node as usize][i]) {
                        let sum: f64 = near.iter().map(|other| before[self.parted[other][1] as usize][i]).sum();
                        mean[i] = 0.5 * (mean[i] + sum / near.len() as f64);
                    }
                }
                self.points[surface as usize] = project(number, &bodies[number - 1], mean)?;
            }
        }
        for &(node, number) in staircase {
            let center = bodies[number - 1].center_mm;
            let [within, surface] = self.parted[&node].map(|new| new as usize);
            let on = self.points[surface];
            self.points[within] = std::array::from_fn(|i| center[i] + 0.8 * (on[i] - center[i]));
        }
        Ok(())
    }

    /// Which coordinates of which corners may move.
    pub fn free(&self, base: &Mesh) -> Vec<Free> {
        let interface = interfaces(base);
        let mut held: Vec<Free> = planes(base);
        held.resize(self.points.len(), [false; 3]);
        for (&node, &[within, surface]) in &self.parted {
            held[within as usize] = held[node as usize];
            held[surface as usize] = [true; 3];
        }
        for (node, held) in held.iter_mut().enumerate().take(base.nodes.len()) {
            held[2] |= interface[node];
        }
        for facet in base.facets.iter().filter(|facet| is_fixed(facet)) {
            base.facet_nodes(*facet).into_iter().for_each(|node| held[node as usize] = [true; 3]);
        }
        let mut near: Vec<bool> = vec![false; self.points.len()];
        self.parted.iter().flat_map(|(&node, new)| [node, new[0]]).for_each(|node| near[node as usize] = true);
        for _ in 0..NEIGHBOURHOOD {
            let touched = self.hexes.iter().filter(|hex| hex.corners.iter().any(|&node| near[node as usize]));
            let wider: Vec<u32> = touched.flat_map(|hex| hex.corners).collect();
            wider.into_iter().for_each(|node| near[node as usize] = true);
        }
        held.into_iter().zip(near).map(|(held, near)| held.map(|held| near && !held)).collect()
    }
}

/// Whether each node lies between elements of two layers.
fn interfaces(base: &Mesh) -> Vec<bool> {
    let mut seen: Vec<Option<u32>> = vec![None; base.nodes.len()];
    let mut between = vec![false; base.nodes.len()];
    for (element, &region) in base.region.iter().enumerate() {
        for &node in base.element(element) {
            between[node as usize] |= seen[node as usize].replace(region).is_some_and(|other| other != region);
        }
    }
    between
}

/// Coordinates that planes of symmetry hold.
fn planes(base: &Mesh) -> Vec<Free> {
    let mut held = vec![[false; 3]; base.nodes.len()];
    for (axis, boundary) in [super::Boundary::SymmetryX, super::Boundary::SymmetryY].into_iter().enumerate() {
        base.boundary_nodes(boundary).into_iter().for_each(|node| held[node as usize][axis] = true);
    }
    held
}
