//! A rigid ball, or cylinder, on a half space by frictionless contact (E = 1, contact of about 1 mm).

use super::{Answer, Solved, face, graded, on_a_base, touched};
use std::f64::consts::PI;
use tirtouch::mechanics::contact::{Contact, Counterpart, Grip, Profile};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, PhantomMesh, PhantomShape};
use tirtouch::mechanics::problem::Problem;

/// Radius of the ball, mm: a/R = 0.0025, as Hertz leaves out that points move sideways by (1 - 2 nu) of it.
const RADIUS: f64 = 400.0;
/// Distance to the base and the side, mm: a base at this depth stiffens by about 0.8 a over it, 0.07 %.
const FAR: f64 = 1200.0;
/// In plane strain only the pressure's shape is compared, which a far base changes by (a / depth)^2. Distances much
/// beyond raise round-off, in the far elements' strains, to the size of the contact's forces.
const FAR_PLANE: f64 = 400.0;

/// Size of elements in the contact on a rung, mm.
pub fn size(rung: usize) -> f64 {
    0.2 / rung as f64
}

fn press(rung: usize, kinematics: Kinematics, poisson: f64, profile: Profile, depth: f64, far: f64) -> Solved {
    let mesh = PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: far, height_mm: far },
        inclusions: Vec::new(),
        footprint: Footprint::Round { radius_mm: 1.4 },
        symmetry: [true, false],
        resolution: graded(0.2, 0.2, 0.4 * far, 0.5, rung),
        offset_mm: [0.0; 2],
        layers_mm: Vec::new(),
    }
    .build_2d()
    .unwrap();
    let material = Material::linear(1.0, poisson).unwrap();
    let counterpart = Counterpart::Rigid { profile, center: [0.0; 2] };
    let facets = touched(&mesh, 1.4);
    let shear = material.law.shear_kpa();
    let contact = Contact::new(kinematics, &mesh, &facets, counterpart, Grip::Frictionless, shear, 1.0);
    let supports = on_a_base(&mesh, far, -depth);
    let problem = Problem { supports, contacts: vec![contact], ..Problem::free(kinematics, mesh, vec![material]) };
    Solved::new(problem, &[1.0]).unwrap()
}

/// Edge of the contact: half way between the last loaded node and the next.
fn edge(rows: &[[f64; 3]]) -> f64 {
    let last = rows.iter().rposition(|row| row[1] > 0.0).unwrap();
    0.5 * (rows[last][0] + rows[last + 1][0])
}

/// Difference to p0 sqrt(1 - r^2/a^2) inside 0.9 a: rms over the area as a share of p0.
fn scatter(rows: &[[f64; 3]], p0: f64, a: f64) -> f64 {
    let mut sums = [0.0; 2];
    for [r, p, area] in rows.iter().filter(|row| row[0] < 0.9 * a) {
        sums[0] += area * (p / p0 - (1.0 - (r / a) * (r / a)).sqrt()).powi(2);
        sums[1] += area;
    }
    (sums[0] / sums[1]).sqrt()
}

/// A ball pressed in by a^2/R with a = 1 mm.
pub fn ball(rung: usize, poisson: f64) -> Answer {
    let modulus = 1.0 / (1.0 - poisson * poisson);
    let profile = Profile::Round { radius_mm: RADIUS };
    let solved = press(rung, Kinematics::Axisymmetric, poisson, profile, 1.0 / RADIUS, FAR);
    let rows = face(&solved);
    let force: f64 = rows.iter().map(|row| row[1] * row[2]).sum();
    let p0 = 2.0 * modulus / (PI * RADIUS);
    solved.answer(vec![
        ("force, mN", force, 4.0 / 3.0 * modulus / RADIUS),
        ("edge, mm", edge(&rows), 1.0),
        ("edge, elements", (edge(&rows) - 1.0).abs() / size(rung), 0.0),
        ("pressure, rms", scatter(&rows, p0, 1.0), 0.0),
        ("p(0), kPa", rows[0][1], p0),
    ])
}

/// A cylinder; the force is the measured one, the edge and the pressure follow from it.
pub fn cylinder(rung: usize, poisson: f64) -> Answer {
    let modulus = 1.0 / (1.0 - poisson * poisson);
    let profile = Profile::Round { radius_mm: RADIUS };
    let depth = (2.0 * (2.0 * FAR_PLANE).ln() - 1.0) / (4.0 * RADIUS);
    let solved = press(rung, Kinematics::PlaneStrain, poisson, profile, depth, FAR_PLANE);
    let rows = face(&solved);
    // Half of the contact is meshed.
    let force = 2.0 * rows.iter().map(|row| row[1] * row[2]).sum::<f64>();
    let a = (4.0 * force * RADIUS / (PI * modulus)).sqrt();
    let p0 = 2.0 * force / (PI * a);
    solved.answer(vec![
        ("edge, mm", edge(&rows), a),
        ("edge, elements", (edge(&rows) - a).abs() / size(rung), 0.0),
        ("pressure, rms", scatter(&rows, p0, a), 0.0),
        ("p(0), kPa", rows[0][1], p0),
    ])
}
