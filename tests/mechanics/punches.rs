//! Punches on layers and half spaces.

use super::answers::{Answer, hayes, hertz};
use super::bonded_layers::{Layer, stiffness};
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::element::PressureOrder;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, PhantomMesh, PhantomShape, Resolution};
use tirtouch::mechanics::press::{Load, PressSettings, SensorBody, Setup, press};

fn assert_close(what: &str, answer: &Answer, name: &str, tolerance: f64) {
    let error = answer.error(name);
    let Answer { unknowns, iterations, seconds, .. } = answer;
    let cost = format!("{unknowns} unknowns, {iterations} iterations, {seconds:.1} s");
    assert!(error.abs() < tolerance, "{what}, {name}: off by {error:e} ({cost})");
}

#[test]
fn punches_on_bonded_layers_have_the_stiffness_of_hayes() {
    // Half of the asked 0.5 %; the table has five digits.
    for [a_over_h, compressible, incompressible] in hayes::KAPPA {
        for (poisson, exact) in [(0.45, compressible), (0.5, incompressible)] {
            let answer = hayes::kappa(1, a_over_h, poisson, exact);
            assert_close(&format!("a/h {a_over_h} nu {poisson}"), &answer, "kappa", 2.5e-3);
        }
    }
}

#[test]
fn a_flat_punch_on_a_half_space_needs_twice_the_modulus_times_radius_times_depth() {
    for poisson in [0.0, 0.3, 0.5] {
        assert_close(&format!("nu {poisson}"), &hayes::half_space(1, poisson), "P / (2 E* a w)", 2.5e-3);
    }
}

#[test]
fn a_uniform_pressure_sinks_a_half_space_by_boussinesq() {
    for poisson in [0.0, 0.3, 0.5] {
        let answer = hayes::disc_pressure(1, poisson);
        assert_close(&format!("nu {poisson}"), &answer, "middle, mm", 2.5e-3);
        assert_close(&format!("nu {poisson}"), &answer, "edge, mm", 2.5e-3);
    }
}

#[test]
fn a_ball_presses_as_hertz_says() {
    for poisson in [0.3, 0.5] {
        let answer = hertz::ball(3, poisson);
        let what = format!("nu {poisson}");
        assert_close(&what, &answer, "force, mN", 5e-3);
        // 0.05 mm.
        assert_close(&what, &answer, "edge, elements", 0.75);
        assert_close(&what, &answer, "pressure, rms", 5e-3);
        assert_close(&what, &answer, "p(0), kPa", 5e-3);
    }
}

#[test]
fn a_cylinder_presses_as_hertz_says() {
    for poisson in [0.3, 0.5] {
        let answer = hertz::cylinder(2, poisson);
        let what = format!("nu {poisson}");
        assert_close(&what, &answer, "edge, elements", 1.0);
        assert_close(&what, &answer, "pressure, rms", 5e-3);
        assert_close(&what, &answer, "p(0), kPa", 5e-3);
    }
}

/// Radius of a rigid sensor's flat face and of its rim, and how far it is pressed, mm.
const PUNCH_MM: [f64; 3] = [5.0, 0.005, 1e-3];

/// Force of the press itself, N, on bonded layers, the touched one first.
fn pressed_n(layers: &[Layer]) -> f64 {
    let [radius_mm, rim_mm, depth_mm] = PUNCH_MM;
    let height_mm: f64 = layers.iter().map(|layer| layer.thickness_mm).sum();
    let (body, above) = layers.split_last().unwrap();
    let setup = Setup {
        kinematics: Kinematics::Axisymmetric,
        pressure: PressureOrder::Linear,
        phantom: PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: radius_mm + 8.0 * height_mm, height_mm },
            inclusions: Vec::new(),
            footprint: Footprint::Round { radius_mm },
            symmetry: [true, true],
            resolution: Resolution::PLANE.halved(),
            offset_mm: [0.0; 2],
            layers_mm: above.iter().map(|layer| layer.thickness_mm).collect(),
        },
        phantom_materials: std::iter::once(body)
            .chain(above)
            .map(|layer| Material::linear(layer.youngs_kpa, layer.poisson).unwrap())
            .collect(),
        sensor: SensorBody::Rigid { edge_radius_mm: rim_mm },
        grip: Grip::Frictionless,
        load: Load::Depths(vec![depth_mm]),
        seconds_per_mm: None,
        hold_s: 0.0,
        tilt_deg: [0.0; 2],
    };
    press(&setup, PressSettings::default(), &mut |_| true).unwrap().steps[0].force_n
}

/// A rigid sensor's flat face with a rim of a thousandth of its radius, pressed little.
#[test]
fn a_rigid_sensor_resolves_its_rim_on_a_layer_and_on_several() {
    let [radius_mm, rim_mm, depth_mm] = PUNCH_MM;
    let layer = |thickness_mm: f64, youngs_kpa: f64, poisson: f64| Layer { thickness_mm, youngs_kpa, poisson };
    let one = |a_over_h: f64, poisson: f64| vec![layer(radius_mm / a_over_h, 5.0, poisson)];
    let skin_over_fat = |poisson: f64| vec![layer(1.5, 40.0, poisson), layer(8.5, 5.0, poisson)];
    let three = vec![layer(1.0, 4.0, 0.5), layer(2.5, 60.0, 0.4), layer(6.0, 12.0, 0.49)];
    let cases = [one(0.2, 0.3), one(1.0, 0.5), one(3.0, 0.45), skin_over_fat(0.5), skin_over_fat(0.3), three];
    // The face in contact is at least the flat part; the force grows as the cube of its radius at most.
    let least = (1.0 - rim_mm / radius_mm).powi(3) - 1.0;
    for layers in cases {
        let force_n = pressed_n(&layers);
        let off = force_n / (stiffness(&layers, radius_mm) * depth_mm) - 1.0;
        println!("{layers:?}: {off:.1e}");
        assert!(least - 1e-3 < off && off < 1e-3, "{layers:?}: {off:.1e}, at least {least:.1e}");
        let mut swapped = layers.clone();
        swapped.reverse();
        let other = force_n / (stiffness(&swapped, radius_mm) * depth_mm) - 1.0;
        assert!(layers.len() == 1 || other.abs() > 0.1, "layers the wrong way round are not noticed: {other:.1e}");
    }
}

#[test]
fn the_integral_equation_of_bonded_layers_is_that_of_hayes_for_one() {
    for [a_over_h, compressible, incompressible] in hayes::KAPPA {
        for (poisson, kappa) in [(0.45, compressible), (0.5, incompressible)] {
            let layer = |share: f64| Layer { thickness_mm: share / a_over_h, youngs_kpa: 1.0, poisson };
            // In one and in two halves.
            for layers in [vec![layer(1.0)], vec![layer(0.3), layer(0.7)]] {
                let found = 1e3 * stiffness(&layers, 1.0) * (1.0 - poisson * poisson) / 2.0;
                assert!((found / kappa - 1.0).abs() < 1e-4, "a/h {a_over_h}, nu {poisson}: {found}, table {kappa}");
            }
        }
    }
}
