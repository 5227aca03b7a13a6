//! One position as a picture needs it.

use super::ScanSetup;
use crate::mechanics::mesh::Mesh;
use crate::mechanics::press::ContactPoint;
use crate::mechanics::problem::{Problem, State};

/// One position, whole.
#[derive(Debug, Clone)]
pub struct Shown {
    /// Position of the indenter, mm.
    pub position_mm: f64,
    /// The undeformed tissue under the indenter.
    pub problem: Problem,
    /// Its balance.
    pub state: State,
    /// Nodes of the touched face.
    pub points: Vec<ContactPoint>,
}

/// Columns of elements of a drawn indenter.
const COLUMNS: usize = 48;

impl ScanSetup {
    /// The head of the indenter at a position as a mesh to be drawn: out to `half_width_mm`, `thickness_mm` below
    /// there.
    pub fn indenter_mesh(&self, position_mm: f64, half_width_mm: f64, thickness_mm: f64) -> Mesh {
        let depth = |x: f64| self.indenter.depth(x.abs())[0];
        let bottom = -depth(half_width_mm) - thickness_mm;
        let width = 2 * COLUMNS + 1;
        let node = |k: usize| {
            let x = half_width_mm * ((k % width) as f64 / COLUMNS as f64 - 1.0);
            let top = -depth(x);
            [position_mm + x, bottom + 0.5 * (k / width) as f64 * (top - bottom), 0.0]
        };
        let lattice = |cell: usize| (0..9).map(move |a| (a / 3 * width + 2 * cell + a % 3) as u32);
        Mesh {
            dim: 2,
            nodes: (0..3 * width).map(node).collect(),
            elements: (0..COLUMNS).flat_map(lattice).collect(),
            region: vec![0; COLUMNS],
            facets: Vec::new(),
        }
    }
}
