//! A phantom (radius 30, height 25 mm, 5 kPa) bonded to a rigid face of radius 15 mm and pressed by its base.

use super::{Answer, Solved, face, on_a_base, touched};
use tirtouch::mechanics::contact::{Contact, Counterpart, Grip, Profile};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, InclusionShape, Mesh, PhantomMesh, PhantomShape, Resolution, Star};
use tirtouch::mechanics::path::PathError;
use tirtouch::mechanics::problem::Problem;

pub const HEIGHT: f64 = 25.0;
pub const EDGE: f64 = 15.0;

/// The phantom's section, with a ball of this diameter whose top lies `depth` above the touched face.
pub fn phantom(rung: usize, ball: Option<(f64, f64)>) -> Mesh {
    let inclusion = |(diameter, depth): (f64, f64)| InclusionShape {
        center_mm: [0.0, 0.0, depth + 0.5 * diameter],
        surface: Star::Ellipsoid { semi_axes_mm: [0.5 * diameter; 3] },
    };
    PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: HEIGHT },
        inclusions: ball.map(inclusion).into_iter().collect(),
        footprint: Footprint::Round { radius_mm: EDGE },
        symmetry: [true, false],
        resolution: Resolution { subdivision: rung, ..Resolution::PLANE },
        offset_mm: [0.0; 2],
        layers_mm: Vec::new(),
    }
    .build_2d()
    .unwrap()
}

/// Presses by `depth` mm; `materials` are those of phantom and inclusion.
pub fn press(mesh: Mesh, materials: Vec<Material>, grip: Grip, depth: f64, loads: &[f64]) -> Result<Solved, PathError> {
    let counterpart = Counterpart::Rigid { profile: Profile::Flat, center: [0.0; 2] };
    let kinematics = Kinematics::Axisymmetric;
    let facets = touched(&mesh, EDGE);
    let shear = materials[0].law.shear_kpa();
    let contact = Contact::new(kinematics, &mesh, &facets, counterpart, grip, shear, 1.0);
    let supports = on_a_base(&mesh, HEIGHT, -depth);
    let problem = Problem { supports, contacts: vec![contact], ..Problem::free(kinematics, mesh, materials) };
    Solved::new(problem, loads)
}

/// Force on the face, N.
pub fn force(solved: &Solved) -> f64 {
    face(solved).iter().map(|[_, p, area]| 1e-3 * p * area).sum()
}

/// Mean pressure, Pa, within a distance of the axis: nodal values, linear between the nodes.
pub fn mean_pressure(solved: &Solved, radius: f64) -> f64 {
    let rows = face(solved);
    let at = |r: f64| {
        let k = rows.partition_point(|row| row[0] <= r).clamp(1, rows.len() - 1);
        let ([r0, p0, _], [r1, p1, _]) = (rows[k - 1], rows[k]);
        p0 + (p1 - p0) * (r - r0) / (r1 - r0)
    };
    let n = 1000;
    let weighted = |k: usize| {
        let r = radius * (k as f64 + 0.5) / n as f64;
        2.0 * r * at(r) / radius / n as f64
    };
    1e3 * (0..n).map(weighted).sum::<f64>() / radius
}

/// The digits of a P2 + bubble prototype: linear, nu = 0.4999, 1 mm; good to 1 %.
pub fn tied(rung: usize, inclusion: bool) -> Answer {
    let mesh = phantom(rung, inclusion.then_some((8.0, 5.0)));
    let mut materials = vec![Material::linear(5.0, 0.4999).unwrap()];
    if inclusion {
        materials.push(Material::linear(120.0, 0.4999).unwrap());
    }
    let solved = press(mesh, materials, Grip::Bonded, 1.0, &[1.0]).unwrap();
    let [exact_pressure, exact_force] = if inclusion { [537.3, 0.3823] } else { [334.7, 0.3719] };
    solved.answer(vec![
        ("p(r < 1 mm), Pa", mean_pressure(&solved, 1.0), exact_pressure),
        ("force, N", force(&solved), exact_force),
    ])
}
