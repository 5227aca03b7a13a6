//! Spheres of any contrast in a far uniform strain.
//!
//! Incompressible, in a uniaxial strain: 1/(1 + 0.4 (k - 1)) of the far strain inside (Eshelby, Proc. R. Soc. A 241,
//! 1957). Compressible, in a strain the same along all axes: (3 K + 4 G)/(3 K_i + 4 G), a hole at k = 0.

use super::compressibility::ELEMENTS;
use super::row::{Part, Row, Subject};
use super::solved::{graded, solve};
use super::{Context, StabilityError};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, InclusionShape, Mesh, MeshError, PhantomMesh, PhantomShape, Star};
use crate::mechanics::problem::{Problem, Support};
use crate::mechanics::read_out::samples;

/// Distance to the boundary, which moves as if there were no sphere (radius 1 mm): an error of 4 FAR^-3, 5e-4. Farther
/// out, round-off keeps extreme contrasts from balancing.
pub const FAR: f64 = 20.0;
const POISSON: f64 = 0.3;

/// Contrasts from 1e-6 to 1e6.
///
/// # Errors
/// `Path` where a sphere finds no balance, `Missing` where an element turns inside out.
pub fn rows(context: &Context) -> Result<Vec<Row>, StabilityError> {
    let rung = if context.quick { 1 } else { 2 };
    let far = "the boundary at 20 radii, and the mesh";
    // On the coarse mesh of a quick run the sphere's elements are twice as large, in second order.
    let allowed = 5e-3 / f64::from(rung * rung) * 4.0;
    let mut rows = Vec::new();
    for contrast in [1e-6, 1e-3, 1.0, 20.0, 1e3, 1e6] {
        let exact = 1.0 / (1.0 + 0.4 * (contrast - 1.0));
        let found = strain_inside(rung as usize, contrast, 0.5, |x| [-0.5 * x[0], x[1] - FAR, 0.0])?;
        let subject = Subject::new(Part::Mechanics, format!("sphere of contrast {contrast}, nu = 0.5"), ELEMENTS);
        let (allowed, why) = if contrast == 1.0 { (1e-9, "round-off: nothing is there") } else { (allowed, far) };
        rows.push(subject.relative("strain inside / far", [found, exact], "Eshelby", allowed, why));
    }
    for contrast in [1e-6, 1e6] {
        // K/G of the material around.
        let bulk = 2.0 * (1.0 + POISSON) / (3.0 * (1.0 - 2.0 * POISSON));
        let exact = (3.0 * bulk + 4.0) / (3.0 * bulk * contrast + 4.0);
        let found = strain_inside(rung as usize, contrast, POISSON, |x| [x[0], x[1] - FAR, 0.0])?;
        let limit = if contrast < 1.0 { "a hole" } else { "rigid" };
        let case = format!("sphere of contrast {contrast}, nu = {POISSON}: {limit}");
        let subject = Subject::new(Part::Mechanics, case, ELEMENTS);
        rows.push(subject.relative("strain inside / far", [found, exact], "Goodier", allowed, far));
    }
    Ok(rows)
}

/// A sphere of radius 1 mm amid a cylinder of radius [`FAR`].
///
/// # Errors
/// None for rungs from 1 on.
pub fn far_mesh(rung: usize) -> Result<Mesh, MeshError> {
    PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: FAR, height_mm: 2.0 * FAR },
        inclusions: vec![InclusionShape {
            center_mm: [0.0, 0.0, FAR],
            surface: Star::Ellipsoid { semi_axes_mm: [1.0; 3] },
        }],
        footprint: Footprint::Round { radius_mm: FAR },
        symmetry: [true, false],
        resolution: graded(5.0, 5.0, 5.0, 0.5, rung),
        offset_mm: [0.0; 2],
        layers_mm: Vec::new(),
    }
    .build_2d()
}

/// Mean axial strain in a sphere whose surroundings are displaced by `far` at the boundary.
fn strain_inside(
    rung: usize,
    contrast: f64,
    poisson: f64,
    far: impl Fn([f64; 3]) -> [f64; 3],
) -> Result<f64, StabilityError> {
    let mesh = far_mesh(rung)?;
    let supports = around(&mesh, far);
    let materials = vec![Material::linear(1.0, poisson)?, Material::linear(contrast, poisson)?];
    let problem = Problem { supports, ..Problem::free(Kinematics::Axisymmetric, mesh, materials) };
    let state = solve(&problem, &[1.0])?;
    let (mut volume, mut sum) = (0.0, 0.0);
    for e in (0..problem.mesh.element_count()).filter(|&e| problem.mesh.region[e] == 1) {
        for point in samples(&problem, &state, e).ok_or(StabilityError::Missing("an element is inside out"))? {
            volume += point.volume;
            sum += point.volume * (point.deformation[1][1] - 1.0);
        }
    }
    Ok(sum / volume)
}

/// Prescribes all components on the whole boundary. The axis belongs to it, but along it the body is free.
fn around(mesh: &Mesh, displacement_mm: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<Support> {
    let mut nodes: Vec<u32> = mesh.facets.iter().flat_map(|facet| mesh.facet_nodes(*facet)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut supports = Vec::new();
    for node in nodes {
        let x = mesh.nodes[node as usize];
        let on_axis = x[0] == 0.0 && x[1] > 0.0 && x[1] < 2.0 * FAR;
        let moved = displacement_mm(x);
        let axes = if on_axis { 0..1 } else { 0..mesh.dim };
        supports.extend(axes.map(|axis| Support { node, axis, displacement_mm: moved[axis] }));
    }
    supports
}
