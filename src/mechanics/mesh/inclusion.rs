//! Inclusions: a centre, and a surface that every ray from it leaves once.

use std::sync::Arc;

use super::MeshError;
use super::error::positive;
use crate::scene::TriangleMesh;

/// A body inside the phantom.
#[derive(Debug, Clone, PartialEq)]
pub struct InclusionShape {
    /// Its centre, mm; the third is the height above the touched face. In two dimensions the second is left out.
    pub center_mm: [f64; 3],
    /// Its surface.
    pub surface: Star,
}

/// A surface that is star-shaped about the inclusion's centre.
#[derive(Debug, Clone, PartialEq)]
pub enum Star {
    /// A sphere or an ellipsoid along the axes; in two dimensions the ellipse of the first and the third.
    Ellipsoid {
        /// Half its widths, mm.
        semi_axes_mm: [f64; 3],
    },
    /// A closed mesh of triangles, vertices in mm from the centre; in two dimensions its section y = 0.
    Mesh(Arc<TriangleMesh>),
}

impl Star {
    /// Its bounding box from the centre, mm.
    pub(super) fn extent(&self) -> Result<[[f64; 2]; 3], MeshError> {
        let mut extent = [[0.0; 2]; 3];
        match self {
            Self::Ellipsoid { semi_axes_mm } => {
                for (range, &semi) in extent.iter_mut().zip(semi_axes_mm) {
                    positive("a semi-axis of an inclusion", semi)?;
                    *range = [-semi, semi];
                }
            }
            Self::Mesh(mesh) => {
                for vertex in &mesh.vertices {
                    for (range, &x) in extent.iter_mut().zip(vertex) {
                        *range = [range[0].min(x), range[1].max(x)];
                    }
                }
                for range in extent {
                    positive("the reach of an inclusion's mesh on each side of its centre", (-range[0]).min(range[1]))?;
                }
            }
        }
        Ok(extent)
    }

    /// Distance from the centre to the surface along the unit vector `direction`, mm. `inclusion` is its number.
    pub(super) fn radius(&self, inclusion: usize, direction: [f64; 3]) -> Result<f64, MeshError> {
        match self {
            Self::Ellipsoid { semi_axes_mm } => {
                Ok((0..3).map(|i| (direction[i] / semi_axes_mm[i]).powi(2)).sum::<f64>().powf(-0.5))
            }
            Self::Mesh(mesh) => {
                let mut hits: Vec<f64> = mesh.triangles.iter().filter_map(|t| crossing(mesh, *t, direction)).collect();
                hits.sort_by(f64::total_cmp);
                // A ray through an edge meets both of its triangles at one distance.
                hits.dedup_by(|b, a| (*b - *a).abs() <= 1e-9 * *a);
                match hits.as_slice() {
                    [radius] => Ok(*radius),
                    _ => Err(MeshError::NotStarShaped { inclusion, direction, hits: hits.len() }),
                }
            }
        }
    }
}

/// Distance at which a ray from the origin crosses a triangle.
///
/// With a, b, c its corners and det(a, b, c) their volume, the ray d has barycentric coordinates in the ratio
/// det(d, b, c) : det(a, d, c) : det(a, b, d), and distance det(a, b, c) over their sum. A hair's breadth of tolerance
/// keeps rays from slipping between neighbours.
fn crossing(mesh: &TriangleMesh, triangle: [u32; 3], d: [f64; 3]) -> Option<f64> {
    let [a, b, c] = triangle.map(|vertex| mesh.vertices.get(vertex as usize).copied().unwrap_or_default());
    let parts = [determinant(d, b, c), determinant(a, d, c), determinant(a, b, d)];
    let sum: f64 = parts.iter().sum();
    let inside = sum != 0.0 && parts.iter().all(|part| part / sum >= -1e-10);
    let distance = determinant(a, b, c) / sum;
    (inside && distance > 0.0).then_some(distance)
}

fn determinant(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}
