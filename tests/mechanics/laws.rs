//! Blocks under homogeneous stress, through the whole solver: supports, load steps, reactions.
//!
//! The solution lies in the space of the elements, so what is left is Newton's tolerance: 1e-8 asked.

use super::answers::{Solved, held};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::{Law, Material, OgdenTerm};
use tirtouch::mechanics::mesh::shapes;
use tirtouch::mechanics::problem::Problem;
use tirtouch::mechanics::read_out::{min_jacobian, reactions};

/// Force on the pulled end of a unit block over its undeformed area, lateral faces free (in plane strain, one pair).
fn nominal_stress(kinematics: Kinematics, divisions: usize, law: &Law, stretch: f64) -> f64 {
    let dim = kinematics.dim();
    let mesh = shapes::patch(dim, divisions, 0.2, 0.03, 5).unwrap();
    let up = dim - 1;
    let mut supports: Vec<_> = (0..dim).flat_map(|axis| held(&mesh, |x| x[axis] == 0.0, axis, |_| 0.0)).collect();
    supports.extend(held(&mesh, |x| x[up] == 1.0, up, |_| stretch - 1.0));
    let materials = vec![Material::elastic(law.clone(), 0.5).unwrap()];
    let problem = Problem { supports, ..Problem::free(kinematics, mesh, materials) };
    let solved = Solved::new(problem, &[1.0]).unwrap();
    assert!((min_jacobian(&solved.problem, &solved.state).unwrap() - 1.0).abs() < 1e-7);
    let forces = reactions(&solved.problem, &solved.state).unwrap();
    let nodes = solved.problem.mesh.nodes.iter().zip(&forces);
    let area = if kinematics == Kinematics::Axisymmetric { std::f64::consts::PI } else { 1.0 };
    nodes.filter(|(x, _)| x[up] == 1.0).map(|(_, force)| force[up]).sum::<f64>() / area
}

fn assert_curve(law: &Law, uniaxial: impl Fn(f64) -> f64, plane: impl Fn(f64) -> f64) {
    for stretch in [0.5, 0.7, 0.8, 1.2, 2.0] {
        for (kinematics, divisions, exact) in [
            (Kinematics::Axisymmetric, 1, uniaxial(stretch)),
            (Kinematics::Axisymmetric, 3, uniaxial(stretch)),
            (Kinematics::ThreeDimensional, 1, uniaxial(stretch)),
            (Kinematics::ThreeDimensional, 2, uniaxial(stretch)),
            (Kinematics::PlaneStrain, 1, plane(stretch)),
            (Kinematics::PlaneStrain, 3, plane(stretch)),
        ] {
            let found = nominal_stress(kinematics, divisions, law, stretch);
            assert!(
                (found / exact - 1.0).abs() < 1e-8,
                "{law:?} {kinematics:?} {divisions} at {stretch}: {found} not {exact}"
            );
        }
    }
}

#[test]
fn neo_hookean_blocks_follow_their_curves() {
    // mu = 1; 1.75, -1.34082 and -1.15313 are the figures of the tables.
    assert!((nominal_stress(Kinematics::ThreeDimensional, 1, &neo_hookean(), 2.0) - 1.75).abs() < 1e-6);
    assert!((nominal_stress(Kinematics::Axisymmetric, 1, &neo_hookean(), 0.7) + 1.34082).abs() < 5e-6);
    assert!((nominal_stress(Kinematics::PlaneStrain, 1, &neo_hookean(), 0.8) + 1.15313).abs() < 5e-6);
    assert_curve(&neo_hookean(), |l| l - l.powi(-2), |l| l - l.powi(-3));
}

fn neo_hookean() -> Law {
    Law::NeoHookean { shear_kpa: 1.0 }
}

#[test]
fn yeoh_blocks_follow_their_curves() {
    let c = [0.5, 0.1, 0.02];
    // Nominal stress 2 dW/dI1 (l - l^-2), in plane strain 2 dW/dI1 (l - l^-3).
    let slope = |x: f64| 2.0 * (c[0] + 2.0 * c[1] * x + 3.0 * c[2] * x * x);
    assert_curve(
        &Law::Yeoh { c_kpa: c },
        |l| slope(l * l + 2.0 / l - 3.0) * (l - l.powi(-2)),
        |l| slope(l * l + l.powi(-2) - 2.0) * (l - l.powi(-3)),
    );
}

#[test]
fn ogden_blocks_follow_their_curves() {
    // Ogden's three terms for vulcanised rubber (Proc. R. Soc. A 326, 1972), in units of 0.1 MPa.
    let terms = [[6.3, 1.3], [0.012, 5.0], [-0.1, -2.0]];
    let law =
        Law::Ogden { terms: terms.iter().map(|&[shear_kpa, exponent]| OgdenTerm { shear_kpa, exponent }).collect() };
    let sum = |term: &dyn Fn(f64) -> f64| terms.iter().map(|[mu, alpha]| mu * term(*alpha)).sum::<f64>();
    assert_curve(
        &law,
        |l| sum(&|a| l.powf(a - 1.0) - l.powf(-0.5 * a - 1.0)),
        |l| sum(&|a| l.powf(a - 1.0) - l.powf(-a - 1.0)),
    );
}

#[test]
fn the_tissue_law_follows_its_one_dimensional_curve_at_small_strain() {
    // e = sqrt((I1 - 3)/3) is |eps| (1 - eps/6 + ...): at 2 % the curve is met to about that.
    let law = Law::Exponential { modulus_kpa: 4.4, exponent: 9.2 };
    for strain in [-0.02, -0.002, 0.002f64] {
        let found = nominal_stress(Kinematics::Axisymmetric, 2, &law, 1.0 + strain);
        let exact = strain.signum() * 4.4 / 9.2 * ((9.2 * strain.abs()).exp() - 1.0);
        assert!((found / exact - 1.0).abs() < 3.0 * strain.abs(), "{strain}: {found} not {exact}");
    }
}
