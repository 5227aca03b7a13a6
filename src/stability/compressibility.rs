//! Up to incompressibility, and to half the height.

use super::row::{Part, Row, Subject};
use super::solved::{graded, held, solve};
use super::{Context, StabilityError, membrane};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Boundary, Footprint, PhantomMesh, PhantomShape, shapes};
use crate::mechanics::problem::Problem;
use crate::mechanics::read_out::{min_jacobian, reactions, samples, traction_forces};

/// What computes the rows of mechanics.
pub const ELEMENTS: &str = "Q2/P-1, f64";
/// Errors may be so many times those at nu = 0.3: that is what it means that elements do not lock.
const GROWTH: f64 = 3.0;

/// Errors of a thick sphere at one Poisson's ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressureSample {
    /// Poisson's ratio.
    pub poisson: f64,
    /// Displacement of the inner face, found and exact, mm.
    pub widening_mm: [f64; 2],
    /// Error of the mean stress, rms over the volume as a share of it.
    pub pressure_error: f64,
}

/// Linear thick spheres b = 2a under inner pressure at some Poisson's ratios, with `2 rung` elements across.
///
/// u(r) = p a^3/(E (b^3 - a^3)) ((1 - 2 nu) r + (1 + nu) b^3/(2 r^2)); the mean stress is p a^3/(b^3 - a^3) all over.
///
/// # Errors
/// `Mesh` for a rung of 0 or one of too many elements, `Material` for a ratio outside 0 to 0.5, `Path` where no balance
/// is found.
pub fn pressure_errors(rung: usize, ratios: &[f64]) -> Result<Vec<PressureSample>, StabilityError> {
    ratios.iter().map(|&poisson| sphere(rung, poisson)).collect()
}

fn sphere(rung: usize, poisson: f64) -> Result<PressureSample, StabilityError> {
    let mesh = shapes::shell(1.0, 2.0, 2 * rung, 3 * rung)?;
    let mut supports = held(&mesh, |x| x[0] == 0.0, 0, |_| 0.0);
    supports.extend(held(&mesh, |x| x[1] == 0.0, 1, |_| 0.0));
    let inner = mesh.boundary_facets(Boundary::Touched);
    let forces = traction_forces(Kinematics::Axisymmetric, &mesh, &inner, &|_, normal| normal.map(|n| -n));
    let materials = vec![Material::linear(1.0, poisson)?];
    let problem = Problem { supports, forces, ..Problem::free(Kinematics::Axisymmetric, mesh, materials) };
    let state = solve(&problem, &[1.0])?;
    let nodes = problem.mesh.boundary_nodes(Boundary::Touched);
    let moved = |&node: &u32| {
        let (x, u) = (problem.mesh.nodes[node as usize], state.displacement[node as usize]);
        x[0] * u[0] + x[1] * u[1]
    };
    let widening = nodes.iter().map(moved).sum::<f64>() / nodes.len() as f64;
    let exact = ((1.0 - 2.0 * poisson) + 4.0 * (1.0 + poisson)) / 7.0;
    let (mut volume, mut square) = (0.0, 0.0);
    for e in 0..problem.mesh.element_count() {
        let points = samples(&problem, &state, e).ok_or(StabilityError::Missing("an element is inside out"))?;
        for point in points {
            let mean = (0..3).map(|i| point.cauchy[i][i]).sum::<f64>() / 3.0;
            volume += point.volume;
            square += point.volume * (7.0 * mean - 1.0).powi(2);
        }
    }
    Ok(PressureSample { poisson, widening_mm: [widening, exact], pressure_error: (square / volume).sqrt() })
}

/// nu = 0.49 to 0.5 exactly, and Cook's membrane.
pub fn rows(context: &Context) -> Result<Vec<Row>, StabilityError> {
    let rung = if context.quick { 2 } else { 4 };
    let mut spheres = pressure_errors(rung, &[0.3, 0.49, 0.499, 0.4999, 0.499_999, 0.5])?.into_iter();
    let easy = spheres.next().ok_or(StabilityError::Missing("a sphere at nu = 0.3"))?;
    let easy_widening = (easy.widening_mm[0] / easy.widening_mm[1] - 1.0).abs();
    let mut rows = Vec::new();
    for sphere in spheres {
        let subject = Subject::new(Part::Mechanics, format!("thick sphere, nu = {}", sphere.poisson), ELEMENTS);
        let why = "three times the error at nu = 0.3 on the same mesh: no locking";
        let allowed = GROWTH * easy_widening;
        rows.push(subject.relative("widening of the hole, mm", sphere.widening_mm, "Lame", allowed, why));
        let pressure = [sphere.pressure_error, 0.0];
        let allowed = GROWTH * easy.pressure_error;
        rows.push(subject.absolute("mean stress, rms error as a share", pressure, "Lame", allowed, why));
    }
    let divisions = if context.quick { 8 } else { 16 };
    let found = [(context.membrane)(divisions)?, membrane::DEFLECTION];
    let case = format!("Cook's membrane, lambda/G = 20,000, {divisions} x {divisions} elements");
    let subject = Subject::new(Part::Mechanics, case, ELEMENTS);
    // The corner's singularity: 0.3 % at 16 elements a side, falling with their size.
    let allowed = 3e-3 * 16.0 / divisions as f64;
    let quantity = "deflection of the edge's middle, mm";
    rows.push(subject.relative(quantity, found, "published", allowed, "singular corner: first order in the size"));
    Ok(rows)
}

/// Cylinders pressed to half their height: free to widen (closed form), and bonded.
pub fn half_height(context: &Context) -> Result<Vec<Row>, StabilityError> {
    let size = if context.quick { 5.0 } else { 2.5 };
    let mut rows = Vec::new();
    for (bonded, poisson) in [(false, 0.5), (true, 0.4999), (true, 0.5)] {
        let mesh = PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: 20.0, height_mm: 20.0 },
            inclusions: Vec::new(),
            footprint: Footprint::Round { radius_mm: 20.0 },
            symmetry: [true, false],
            resolution: graded(size, size, size, 0.5, 1),
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        }
        .build_2d()?;
        let on_base = |x: [f64; 3]| x[1] >= 20.0 * (1.0 - 1e-12);
        let mut supports = held(&mesh, |x| x[0] == 0.0 || bonded && (on_base(x) || x[1] == 0.0), 0, |_| 0.0);
        supports.extend(held(&mesh, on_base, 1, |_| -10.0));
        supports.extend(held(&mesh, |x| x[1] == 0.0, 1, |_| 0.0));
        // E = 3 mu with mu = 1 kPa.
        let materials = vec![Material::neo_hookean(2.0 * (1.0 + poisson), poisson)?];
        let problem = Problem { supports, ..Problem::free(Kinematics::Axisymmetric, mesh, materials) };
        let loads: Vec<f64> = (1..=10).map(|k| 0.1 * f64::from(k)).collect();
        let state = solve(&problem, &loads)?;
        let kind = if bonded { "bonded" } else { "free" };
        let case = format!("{kind} cylinder pressed to half its height, nu = {poisson}");
        let subject = Subject::new(Part::Mechanics, case, ELEMENTS);
        let least = min_jacobian(&problem, &state).unwrap_or(f64::NAN);
        rows.push(subject.above("least J", [least, 0.0], "no element inside out", "load stepped by a tenth"));
        if !bonded {
            let forces = reactions(&problem, &state).ok_or(StabilityError::Missing("an element is inside out"))?;
            let up = problem.mesh.nodes.iter().zip(&forces).filter(|(x, _)| x[1] == 0.0);
            let stress = -up.map(|(_, f)| f[1]).sum::<f64>() / (std::f64::consts::PI * 400.0);
            let why = "uniform: only the solver's tolerance";
            rows.push(subject.relative("nominal stress / mu", [stress, 0.5 - 4.0], "lambda - lambda^-2", 1e-6, why));
        }
    }
    Ok(rows)
}
