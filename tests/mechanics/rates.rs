//! Orders of convergence: 3 for the displacement and 2 for the pressure, in L2; 2 and 1 where pressures are constant in
//! each element (Boffi, Brezzi and Fortin, Mixed Finite Element Methods and Applications, 2013, 8.6.3).
//!
//! Between two rungs the order varies by a few hundredths around the asymptotic one: asked for to 0.2.

use super::answers::{Solved, held, sphere};
use super::manufactured::{body_forces, displacement, errors, pressure, stress};
use tirtouch::mechanics::element::PressureOrder;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::{Law, Material};
use tirtouch::mechanics::mesh::shapes;
use tirtouch::mechanics::problem::Problem;
use tirtouch::mechanics::read_out::traction_forces;

fn assert_orders(what: &str, ladder: &[[f64; 2]]) {
    for orders in orders(ladder) {
        assert!(orders[0] > 2.8 && orders[1] > 1.8, "{what}: orders {orders:?}, errors {ladder:?}");
    }
}

/// Orders between the rungs of a ladder of halved elements.
fn orders(ladder: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> {
    ladder.windows(2).map(|pair| [0, 1].map(|k| (pair[0][k] / pair[1][k]).log2()))
}

/// The flow in a distorted patch: held on the sides x = 0, y = 0, loaded on the others by the tractions it has there.
fn flow(kinematics: Kinematics, order: PressureOrder, divisions: usize, distortion: f64) -> [f64; 2] {
    let dim = kinematics.dim();
    let mesh = shapes::patch(dim, divisions, distortion, 0.0, 3).unwrap();
    let on = |x: [f64; 3]| x[..dim].contains(&0.0);
    let supports = (0..dim).flat_map(|axis| held(&mesh, on, axis, |x| displacement(dim, x)[axis])).collect();
    let mut loaded = mesh.facets.clone();
    loaded.retain(|facet| facet.side % 2 == 1);
    let mut forces = traction_forces(kinematics, &mesh, &loaded, &|x, normal| {
        let stress = stress(dim, x);
        [0, 1, 2].map(|i| (0..3).map(|j| stress[i][j] * normal[j]).sum())
    });
    forces.extend(body_forces(kinematics, &mesh));
    let materials = vec![Material::elastic(Law::Linear { shear_kpa: 1.0 }, 0.5).unwrap()];
    let problem = Problem { pressure: order, supports, forces, ..Problem::free(kinematics, mesh, materials) };
    let solved = Solved::new(problem, &[1.0]).unwrap();
    errors(&solved.problem, &solved.state, &|x| displacement(dim, x), &|x| pressure(dim, x).0)
}

#[test]
fn a_smooth_flow_in_the_plane_converges_at_full_order() {
    for distortion in [0.0, 0.2] {
        let ladder = [4, 8, 16, 32].map(|n| flow(Kinematics::PlaneStrain, PressureOrder::Linear, n, distortion));
        assert_orders(&format!("plane, distorted by {distortion}"), &ladder);
    }
}

#[test]
fn a_smooth_flow_in_space_converges_at_full_order() {
    for distortion in [0.0, 0.2] {
        let ladder = [2, 4, 8].map(|n| flow(Kinematics::ThreeDimensional, PressureOrder::Linear, n, distortion));
        assert_orders(&format!("space, distorted by {distortion}"), &ladder);
    }
}

#[test]
fn constant_pressures_are_an_order_lower() {
    for (kinematics, divisions) in
        [(Kinematics::PlaneStrain, &[8, 16, 32][..]), (Kinematics::ThreeDimensional, &[4, 8][..])]
    {
        let flow = |order| divisions.iter().map(|&n| flow(kinematics, order, n, 0.2)).collect::<Vec<_>>();
        let [constant, linear] = [PressureOrder::Constant, PressureOrder::Linear].map(flow);
        for orders in orders(&constant) {
            let near = |k: usize, order: f64| (orders[k] - order).abs() < 0.2;
            assert!(near(0, 2.0) && near(1, 1.0), "{kinematics:?}: orders {orders:?}, errors {constant:?}");
        }
        for (constant, linear) in constant.iter().zip(&linear) {
            assert!((0..2).all(|k| linear[k] < 0.5 * constant[k]), "{kinematics:?}: {linear:?} against {constant:?}");
        }
    }
}

#[test]
fn an_inflated_sphere_converges_at_full_order() {
    // r^3 = R^3 + 7 and, from the hoop stretch l = r/R, sigma_rr = 2/l + 1/(2 l^4) less its value at the outer face;
    // the mean stress is sigma_rr less the deviator 2/3 (l^-4 - l^2).
    let stretch = |x: [f64; 3]| {
        let radius = x[0].hypot(x[1]);
        (radius.powi(3) + 7.0).cbrt() / radius
    };
    let moved = |x: [f64; 3]| x.map(|c| (stretch(x) - 1.0) * c);
    let radial = |l: f64| 2.0 / l + 0.5 / l.powi(4);
    let mean = |x: [f64; 3]| {
        let l = stretch(x);
        radial(l) - radial(1.875f64.cbrt()) - 2.0 / 3.0 * (l.powi(-4) - l * l)
    };
    let ladder = [2, 4, 8].map(|rung| {
        let solved = sphere::inflate(rung, 2.0);
        errors(&solved.problem, &solved.state, &moved, &mean)
    });
    assert_orders("inflated sphere", &ladder);
}
