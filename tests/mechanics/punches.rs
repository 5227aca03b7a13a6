//! Punches on layers and half spaces.

use super::answers::{Answer, hayes, hertz};
use super::layers::{Layer, Punched, RADIUS_MM, RIM_MM, one, rounded, worst_compliance};
use tirtouch::mechanics::mesh::Resolution;
use tirtouch::mechanics::press::{PressSettings, press};

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

/// A rigid sensor's flat face with a rim of a thousandth of its radius, pressed little.
#[test]
fn a_rigid_sensor_resolves_its_rim_on_a_layer_and_on_several() {
    let layer = |thickness_mm: f64, youngs_kpa: f64, poisson: f64| Layer { thickness_mm, youngs_kpa, poisson };
    let single = |a_over_h: f64, poisson: f64| one(a_over_h, poisson).to_vec();
    let skin_over_fat = |poisson: f64| vec![layer(1.5, 40.0, poisson), layer(8.5, 5.0, poisson)];
    let three = vec![layer(1.0, 4.0, 0.5), layer(2.5, 60.0, 0.4), layer(6.0, 12.0, 0.49)];
    let cases = [single(0.2, 0.3), single(1.0, 0.5), single(3.0, 0.45), skin_over_fat(0.5), skin_over_fat(0.3), three];
    // The face in contact is at least the flat part; the force grows as the cube of its radius at most.
    let least = (1.0 - RIM_MM / RADIUS_MM).powi(3) - 1.0;
    for layers in cases {
        let setup = rounded(&layers, Resolution::PLANE.halved());
        let force_n = press(&setup, PressSettings::default(), &mut |_| true).unwrap().steps[0].force_n;
        let off = force_n / Punched::on(&layers).force_n() - 1.0;
        println!("{layers:?}: {off:.1e}");
        assert!(least - 1e-3 < off && off < 1e-3, "{layers:?}: {off:.1e}, at least {least:.1e}");
        let swapped: Vec<Layer> = layers.iter().rev().copied().collect();
        let other = force_n / Punched::on(&swapped).force_n() - 1.0;
        assert!(layers.len() == 1 || other.abs() > 0.1, "layers the wrong way round are not noticed: {other:.1e}");
    }
}

#[test]
fn the_integrated_compliance_of_layers_is_that_of_one_in_closed_form() {
    for poisson in [0.0, 0.3, 0.45, 0.5] {
        assert!(worst_compliance(poisson) < 1e-5, "nu {poisson}: {}", worst_compliance(poisson));
    }
}
