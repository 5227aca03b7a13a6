//! Presses with extreme inclusions, compressibilities and loads: they converge soundly, or say what is wrong with which
//! numbers.

use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::mesh::MeshError;
use tirtouch::mechanics::press::{Load, PressError, PressSettings, Pressed, Setup, press};
use tirtouch::mechanics::read_out::{min_jacobian, pressure_jump};
use tirtouch::scene::preset;
use tirtouch::stability::presses::{self, HEIGHT};

/// The phantom of 5 kPa on the soft sensor, tied, with a ball of this diameter, depth of its top and contrast.
fn setup(ball: Option<(f64, f64, f64)>, poisson: f64) -> Setup {
    presses::setup(ball, poisson).unwrap()
}

fn run(setup: &Setup) -> Result<Pressed, PressError> {
    press(setup, PressSettings::default(), &mut |_| true)
}

/// Force, N, of a press that is sound: no element inside out, no checkerboard.
fn sound_force(what: &str, setup: &Setup) -> f64 {
    let pressed = run(setup).unwrap_or_else(|error| panic!("{what}: {error}"));
    let (problem, step) = (&pressed.assembly.problem, &pressed.steps[0]);
    let least = min_jacobian(problem, &step.state).unwrap();
    assert!(least > 0.0, "{what}: J {least}");
    // A checkerboard would have 2; a smooth field on this mesh, singular at one edge, has less than a third.
    let jump = pressure_jump(problem, &step.state);
    assert!(jump < 0.3, "{what}: pressures jump by {jump}");
    assert!(step.points.iter().all(|point| point.pressure_kpa.is_finite()), "{what}");
    step.force_n
}

#[test]
fn balls_that_touch_or_cut_a_face_are_refused_with_their_numbers() {
    for (depth, face, gap) in [
        (0.0, "touched face", 0.0),
        (-1.0, "touched face", -1.0),
        (HEIGHT - 8.0, "base", 0.0),
        (HEIGHT - 7.5, "base", -0.5),
    ] {
        for kinematics in [Kinematics::Axisymmetric, Kinematics::ThreeDimensional] {
            let error = run(&Setup { kinematics, ..setup(Some((8.0, depth, 24.0)), 0.4999) }).unwrap_err();
            let PressError::Mesh(MeshError::SticksOut { inclusion, face: named, gap_mm, least_mm }) = &error else {
                panic!("{depth}: {error}");
            };
            assert_eq!((*inclusion, *named), (1, face));
            assert!((gap_mm - gap).abs() < 1e-12 && (least_mm - 0.02).abs() < 1e-12, "{error}");
            let message =
                format!("inclusion 1 is {gap_mm} mm from the {face} (negative: it sticks out), at least 0.02 mm");
            assert!(error.to_string().starts_with(&message), "{error}");
        }
    }
}

#[test]
fn a_scene_whose_ball_touches_a_face_is_refused_with_its_numbers() {
    for (depth, says) in [
        (0.0, "inclusion 1 is 0 mm from the touched face (negative: it sticks out), at least 0.02 mm are needed"),
        (17.0, "inclusion 1 is 0 mm from the base (negative: it sticks out), at least 0.02 mm are needed"),
    ] {
        let mut loaded = preset("phantom-size-8mm").unwrap();
        loaded.scene.phantom.as_mut().unwrap().inclusion[0].depth_mm = depth;
        let error = run(&press_setup(&loaded).unwrap()).unwrap_err();
        assert!(matches!(error, PressError::Mesh(MeshError::SticksOut { .. })), "{error}");
        assert_eq!(error.to_string().replace("-0 mm", "0 mm"), says);
    }
}

#[test]
fn balls_that_all_but_touch_a_face_press() {
    let plain = sound_force("none", &setup(None, 0.4999));
    for depth in [0.021, HEIGHT - 8.021] {
        for contrast in [1e-3, 24.0, 1e3] {
            let force = sound_force(&format!("{depth} mm, k {contrast}"), &setup(Some((8.0, depth, contrast)), 0.4999));
            assert!((force > plain) == (contrast > 1.0), "{depth} mm, k {contrast}: {force} N, {plain} N without");
        }
    }
}

#[test]
fn a_ball_smaller_than_any_element_is_not_felt() {
    let plain = sound_force("none", &setup(None, 0.4999));
    for diameter in [0.1, 0.001] {
        let force = sound_force(&format!("{diameter} mm"), &setup(Some((diameter, 5.0, 24.0)), 0.4999));
        // The mesh is another one around it; its volume is a millionth of the phantom's at the most.
        assert!((force / plain - 1.0).abs() < 1e-3, "{diameter} mm: {force} N, {plain} N without");
    }
}

#[test]
fn balls_of_any_contrast_press_at_any_compressibility() {
    for poisson in [0.3, 0.45, 0.4999, 0.499999, 0.5] {
        let mut last = 0.0;
        for contrast in [1e-6, 1.0, 1e6] {
            let what = format!("nu {poisson}, k {contrast}");
            let force = sound_force(&what, &setup(Some((8.0, 5.0, contrast)), poisson));
            assert!(force > last, "{what}: {force} N after {last} N");
            last = force;
        }
    }
}

#[test]
fn forces_rise_to_that_of_the_incompressible_phantom() {
    let limit = sound_force("nu 0.5", &setup(Some((8.0, 5.0, 24.0)), 0.5));
    let mut last = 0.0;
    for poisson in [0.3, 0.4, 0.45, 0.49, 0.499, 0.4999, 0.499999] {
        let force = sound_force(&format!("nu {poisson}"), &setup(Some((8.0, 5.0, 24.0)), poisson));
        assert!(last < force && force < limit, "nu {poisson}: {force} N after {last} N");
        last = force;
    }
    assert!((last / limit - 1.0).abs() < 1e-4, "{last} N, {limit} N");
}

#[test]
fn every_part_of_the_phantom_needs_a_material() {
    let mut bare = setup(Some((8.0, 5.0, 24.0)), 0.4999);
    bare.phantom_materials.truncate(1);
    let error = run(&bare).unwrap_err();
    assert_eq!(error.to_string(), "the phantom, its 1 inclusions and 0 layers need 2 materials, 1 given");
}

#[test]
fn no_depth_and_no_force_are_no_press() {
    for grip in [Grip::Bonded, Grip::Frictionless] {
        for load in [Load::Depths(vec![0.0]), Load::Forces(vec![0.0])] {
            let still = Setup { grip, load, ..setup(Some((8.0, 5.0, 24.0)), 0.4999) };
            let pressed =
                press(&still, PressSettings { estimate_error: true, ..PressSettings::default() }, &mut |_| true)
                    .unwrap();
            let step = &pressed.steps[0];
            assert_eq!((step.depth_mm, step.force_n, step.peak_pressure_kpa), (0.0, 0.0, 0.0), "{grip:?}");
            assert_eq!(step.peak_at_mm, None, "{grip:?}");
            assert!(step.points.iter().all(|p| p.pressure_kpa == 0.0 && p.displacement_mm == [0.0; 3]), "{grip:?}");
            let error = step.error.unwrap();
            assert_eq!((error.rms, error.force), (0.0, 0.0), "{grip:?}");
            assert_eq!(min_jacobian(&pressed.assembly.problem, &step.state), Some(1.0));
        }
    }
}
