//! The rounded rim of a sensor's touched face.
//!
//! Moulded silicone has no sharp rim, and one would be singular: on a sharp rim that slides, a mesh holds the contact's
//! edge at one node, which snaps from the face to the rim. The nodes of the touched face near the rim move onto an arc,
//! those of the top layer below follow, and elements keep their neighbours.

use super::{Footprint, Lines, Mesh, MeshError, quality};

/// Turning of the face along the arc, rad. A quarter circle would leave the rim's elements a corner of 180 degrees.
const TURN: f64 = std::f64::consts::FRAC_PI_3;

/// Elements along the arc, before they are divided.
const DIVISIONS: f64 = 2.0;

/// A rim.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fillet {
    /// Radius of the arc, mm.
    pub radius_mm: f64,
    /// Thickness of the layer that follows, mm.
    pub layer_mm: f64,
}

/// Largest element, before it is divided, that resolves a rim of this radius, mm.
pub fn rim_size_mm(radius_mm: f64) -> f64 {
    radius_mm * TURN / DIVISIONS
}

impl Fillet {
    /// Distance from the axis at which the arc begins, for a face that ends at `edge`, mm.
    pub fn start(&self, edge: f64) -> f64 {
        edge - self.radius_mm * TURN.sin()
    }

    /// Lines up to `edge` (and down to `-edge`), moved so that one meets the arc's beginning.
    pub fn aligned(&self, lines: Lines, edge: f64) -> Lines {
        let start = self.start(edge);
        let off = |x: f64| (x.abs() - start).abs();
        let inside = lines.0.iter().copied().filter(|x| 0.0 < *x && *x < edge);
        let Some(nearest) = inside.min_by(|a, b| off(*a).total_cmp(&off(*b))) else { return lines };
        let moved = |x: f64| match x.abs() {
            across if across == edge => x,
            across if across <= nearest => x * start / nearest,
            across => x.signum() * (edge - (edge - across) * (edge - start) / (edge - nearest)),
        };
        Lines(lines.0.into_iter().map(moved).collect())
    }

    /// Place on the rounded face of a point at `across` from the axis, and the cosine of the face's turning there.
    fn place(&self, across: f64, edge: f64) -> (f64, f64) {
        let start = self.start(edge);
        let share = (across.abs() - start) / (edge - start);
        if share <= 0.0 {
            return (across, 1.0);
        }
        let (sin, cos) = (share.min(1.0) * TURN).sin_cos();
        (across.signum() * (start + self.radius_mm * sin), cos)
    }

    /// Rounds the rim of a sensor's mesh.
    ///
    /// # Errors
    /// Elements that fold.
    pub fn round(&self, mesh: &mut Mesh, footprint: Footprint) -> Result<(), MeshError> {
        let up = mesh.dim - 1;
        for node in &mut mesh.nodes {
            let follows = 1.0 + node[up] / self.layer_mm;
            if follows <= 0.0 {
                continue;
            }
            let (place, cos) = match footprint {
                Footprint::Round { radius_mm } if up == 2 => {
                    let across = node[0].hypot(node[1]);
                    let (moved, cos) = self.place(across, radius_mm);
                    let stretch = if across > 0.0 { moved / across } else { 1.0 };
                    ([node[0] * stretch, node[1] * stretch], cos)
                }
                _ => {
                    let places = [0, 1].map(|axis| self.place(node[axis], footprint.half_widths()[axis]));
                    let cos = (0..up).map(|axis| places[axis].1).product();
                    (places.map(|(place, _)| place), cos)
                }
            };
            for axis in 0..up {
                node[axis] += follows * (place[axis] - node[axis]);
            }
            node[up] -= follows * self.radius_mm * (1.0 - cos);
        }
        quality::unfolded(mesh)
    }
}
