//! Punches on layers and half spaces.

use super::answers::{Answer, hayes, hertz};
use super::layer;
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

/// A rigid sensor's flat face with a rim of a thousandth of its radius, pressed little, by the press itself.
#[test]
fn a_rigid_sensor_resolves_its_rim() {
    for (a_over_h, poisson) in [(1.0, 0.45), (1.0, 0.5), (2.0, 0.45), (2.0, 0.5)] {
        let setup = layer::rounded(a_over_h, poisson, Resolution::PLANE.halved());
        let pressed = press(&setup, PressSettings::default(), &mut |_| true).unwrap();
        let off = pressed.steps[0].force_n / layer::Layer::new(a_over_h, poisson).force_n() - 1.0;
        // The face in contact is at least the flat part; the force grows as the cube of its radius at most.
        let least = (1.0 - layer::RIM_MM / layer::RADIUS_MM).powi(3) - 1.0;
        assert!(least - 1e-3 < off && off < 1e-3, "a/h {a_over_h}, nu {poisson}: {off:.1e}, at least {least:.1e}");
    }
}
