//! A face of finite elements, seen along z.

use super::Pressed;
use crate::mechanics::element::lagrange;
use crate::mechanics::kinematics::Kinematics;
use serde::{Deserialize, Serialize};

/// The nodes of a facet: 3 along r, or 9 over x and y with x fastest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Facet {
    /// Numbers in the mesh.
    pub nodes: Vec<u32>,
    /// Positions across the stack, mm; y is 0 along r.
    pub places: Vec<[f64; 2]>,
    /// What each node carries.
    pub values: Vec<f64>,
}

/// Facets side by side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FacetMesh {
    /// Coordinates of a facet: 1 (r) or 2 (x, y).
    pub axes: usize,
    /// Which of the planes x = 0 and y = 0 mirror the face; along r the axis does.
    pub mirrored: [bool; 2],
    /// In the order of the mesh.
    pub facets: Vec<Facet>,
    /// Lowest and highest position of each facet.
    boxes: Vec<[[f64; 2]; 2]>,
}

impl FacetMesh {
    /// Facets of a press.
    pub fn of(pressed: &Pressed, facets: Vec<Facet>) -> Self {
        match pressed.setup.kinematics {
            Kinematics::ThreeDimensional => Self::new(2, pressed.setup.phantom.symmetry, facets),
            Kinematics::Axisymmetric | Kinematics::PlaneStrain => Self::new(1, [true, false], facets),
        }
    }

    /// Facets of so many coordinates, mirrored by the planes x = 0 and y = 0 or not.
    pub fn new(axes: usize, mirrored: [bool; 2], facets: Vec<Facet>) -> Self {
        let bound = |facet: &Facet| {
            let fold = |start: f64, pick: fn(f64, f64) -> f64| {
                [0, 1].map(|i| facet.places.iter().map(|x| x[i]).fold(start, pick))
            };
            [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)]
        };
        Self { axes, mirrored, boxes: facets.iter().map(bound).collect(), facets }
    }

    /// Which nodes of a facet are its corners.
    pub fn corners(&self) -> &'static [usize] {
        if self.axes == 1 { &[0, 2] } else { &[0, 2, 6, 8] }
    }

    /// Where a place of the whole footprint lies on the part that is meshed.
    pub fn meshed(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        if self.axes == 1 {
            return [x.hypot(y), 0.0];
        }
        [if self.mirrored[0] { x.abs() } else { x }, if self.mirrored[1] { y.abs() } else { y }]
    }

    /// The facet at a place of the meshed part, and the local coordinates there.
    pub fn locate(&self, at: [f64; 2]) -> Option<(usize, [f64; 2])> {
        (0..self.facets.len()).find_map(|k| {
            let [low, high] = self.boxes[k];
            let slack = 1e-6 * (high[0] - low[0]);
            let near = (0..self.axes).all(|i| low[i] - slack <= at[i] && at[i] <= high[i] + slack);
            let xi = if near { local(self.axes, &self.facets[k].places, at) } else { None }?;
            Some((k, xi))
        })
    }

    /// What lies between the nodes at a place of the meshed part, linear over half facets; nothing off the face.
    pub fn between_nodes(&self, at: [f64; 2]) -> Option<f64> {
        let (k, xi) = self.locate(at)?;
        let hats = |c: f64| [(-c).max(0.0), 1.0 - c.abs().min(1.0), c.max(0.0)];
        let [first, second] = xi.map(hats);
        let weight = |a: usize| first[a % 3] * if self.axes == 1 { 1.0 } else { second[a / 3] };
        Some(self.facets[k].values.iter().enumerate().map(|(a, value)| value * weight(a)).sum())
    }
}

/// Local coordinates of a place in a facet, if it lies there.
fn local(axes: usize, nodes: &[[f64; 2]], at: [f64; 2]) -> Option<[f64; 2]> {
    let mut xi = [0.0; 2];
    for _ in 0..30 {
        let lines = xi.map(lagrange);
        let (mut off, mut slope) = ([-at[0], -at[1]], [[0.0; 2]; 2]);
        for (a, node) in nodes.iter().enumerate() {
            let [n, d] = lines[0][a % 3];
            let [m, e] = if axes == 2 { lines[1][a / 3] } else { [1.0, 0.0] };
            for i in 0..2 {
                off[i] += n * m * node[i];
                slope[i][0] += d * m * node[i];
                slope[i][1] += n * e * node[i];
            }
        }
        let step = if axes == 1 {
            [-off[0] / slope[0][0], 0.0]
        } else {
            let determinant = slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0];
            [
                -(slope[1][1] * off[0] - slope[0][1] * off[1]) / determinant,
                -(slope[0][0] * off[1] - slope[1][0] * off[0]) / determinant,
            ]
        };
        (0..2).for_each(|i| xi[i] = (xi[i] + step[i]).clamp(-2.0, 2.0));
        if step[0].abs().max(step[1].abs()) < 1e-12 {
            break;
        }
    }
    let inside = xi.iter().all(|c| c.abs() <= 1.0 + 1e-9);
    inside.then_some(xi)
}
