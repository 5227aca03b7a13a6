//! The rounded rim of a sensor's touched face.
//!
//! Moulded silicone has no sharp rim, and one would be singular: on a sharp rim that slides, a mesh holds the contact's
//! edge at one node, which snaps from the face to the rim. The nodes of the touched face near the rim sink onto an arc,
//! those of the top layer below follow, and elements keep their neighbours. Nodes that face each other across the
//! contact still do: pressure on faces whose nodes do not is 1 % rough or more.

use super::{Footprint, Mesh, MeshError, quality};

/// Turning of the face along the arc, rad. A quarter circle would leave the rim's elements a corner of 180 degrees.
const TURN: f64 = std::f64::consts::FRAC_PI_3;

/// A rim.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fillet {
    /// Radius of the arc, mm.
    pub radius_mm: f64,
    /// Thickness of the layer that follows, mm.
    pub layer_mm: f64,
}

/// Length of the arc of a rim, mm.
pub(super) fn rim_length_mm(radius_mm: f64) -> f64 {
    radius_mm * TURN
}

/// Distance from the axis at which the arc of a rim begins, on a face that ends at `edge`, mm.
pub(super) fn rim_start(radius_mm: f64, edge: f64) -> f64 {
    edge - radius_mm * TURN.sin()
}

impl Fillet {
    /// Cosine of the face's turning at `across` from the axis.
    fn cosine(&self, across: f64, edge: f64) -> f64 {
        let along = (across.abs() - rim_start(self.radius_mm, edge)).max(0.0) / self.radius_mm;
        (1.0 - along * along).max(0.0).sqrt()
    }

    /// Rounds the rim of a sensor's mesh, which needs a line where the arc begins.
    ///
    /// # Errors
    /// Elements that fold.
    pub fn round(&self, mesh: &mut Mesh, footprint: Footprint) -> Result<(), MeshError> {
        let up = mesh.dim - 1;
        let edges = footprint.half_widths();
        for node in &mut mesh.nodes {
            let follows = 1.0 + node[up] / self.layer_mm;
            if follows <= 0.0 {
                continue;
            }
            let cosine: f64 = match footprint {
                Footprint::Round { radius_mm } if up == 2 => self.cosine(node[0].hypot(node[1]), radius_mm),
                _ => (0..up).map(|axis| self.cosine(node[axis], edges[axis])).product(),
            };
            node[up] -= follows * self.radius_mm * (1.0 - cosine);
        }
        quality::unfolded(mesh)
    }
}
