//! Presses in steps: lifted, slid and held.

use super::solid_tests::{linear, run, soft_press, sphere};
use super::*;
use crate::mechanics::contact::Grip;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::{Law, Material, Prony};
use crate::mechanics::mesh::{PhantomShape, Resolution};

/// A step to a depth, slid along x.
fn pose(depth_mm: f64, slide_x: f64) -> Pose {
    Pose { depth_mm, slide_mm: [slide_x, 0.0], hold_s: 0.0 }
}

fn forces(pressed: &Pressed) -> Vec<f64> {
    pressed.steps.iter().map(|step| step.force_n).collect()
}

/// Moment of the contact's forces about the axis y, in their present places, N mm.
fn moment(step: &PressStep) -> f64 {
    1e-3 * step.points.iter().map(|p| p.force_mn * (p.reference_mm[0] + p.displacement_mm[0])).sum::<f64>()
}

#[test]
fn a_lift_goes_back_the_way_it_came() {
    for grip in [Grip::Bonded, Grip::Frictionless] {
        let mut setup = Setup { grip, ..soft_press(linear, vec![sphere([0.0, 0.0, 9.0], 4.0)], [true; 2]) };
        setup.kinematics = Kinematics::Axisymmetric;
        setup.phantom.resolution = Resolution::PLANE.halved();
        if grip == Grip::Frictionless {
            setup.sensor = SensorBody::Rigid { edge_radius_mm: 0.5 };
        }
        let down = forces(&run(&Setup { load: Load::Depths(vec![0.5, 1.0]), ..setup.clone() }));
        setup.load = Load::Path(vec![pose(1.0, 0.0), pose(0.5, 0.0), pose(0.0, 0.0), pose(1.0, 0.0)]);
        let pressed = run(&setup);
        let [deep, half, none, again] = forces(&pressed)[..] else { panic!("four steps") };
        assert!((deep / down[1] - 1.0).abs() < 1e-6 && (half / down[0] - 1.0).abs() < 1e-6, "{deep} {half} {down:?}");
        assert!(none.abs() < 1e-6 * deep && (again / deep - 1.0).abs() < 1e-6, "{none} {again}");
        let depths: Vec<f64> = pressed.steps.iter().map(|step| step.depth_mm).collect();
        assert_eq!(depths, [1.0, 0.5, 0.0, 1.0]);
    }
}

/// A wide slab in plane strain with a bar at `x`, under a rigid face without friction.
fn slab(x: f64) -> Setup {
    let mut setup = soft_press(linear, vec![sphere([x, 0.0, 6.0], 4.0)], [false; 2]);
    setup.kinematics = Kinematics::PlaneStrain;
    setup.phantom.shape = PhantomShape::Cylinder { radius_mm: 50.0, height_mm: 18.0 };
    // As fine where the face's edge will be as where it is.
    let fine = Resolution { edge_mm: 0.6, contact_mm: 0.6, growth: 0.2, ..Resolution::PLANE };
    setup.phantom.resolution = Resolution { subdivision: 1, ..fine };
    Setup { sensor: SensorBody::Rigid { edge_radius_mm: 1.5 }, grip: Grip::Frictionless, ..setup }
}

#[test]
fn a_slide_without_friction_leads_where_a_press_beside_the_middle_does() {
    let slid = run(&Setup { load: Load::Path(vec![pose(1.0, 0.0), pose(1.0, 2.0), pose(1.0, 0.0)]), ..slab(3.0) });
    let placed = run(&slab(5.0));
    let [before, after, back] = &slid.steps[..] else { panic!("three steps") };
    let expected = &placed.steps[0];
    assert_eq!(after.slide_mm, [2.0, 0.0]);
    let [first, moved, again, there] = [before, after, back, expected].map(moment);
    println!("forces {} {} {}, moments {first} {moved} {there}", before.force_n, after.force_n, expected.force_n);
    assert!((after.force_n / expected.force_n - 1.0).abs() < 2e-3, "{} {}", after.force_n, expected.force_n);
    assert!((moved / there - 1.0).abs() < 0.02, "{moved} {there}");
    // A slide that is forgotten would leave the moment where it was.
    assert!((first / there - 1.0).abs() > 0.3, "{first} {there}");
    assert!(
        (back.force_n / before.force_n - 1.0).abs() < 1e-6 && (again / first - 1.0).abs() < 1e-5,
        "{again} {first}"
    );
}

#[test]
fn a_long_slide_rubs_at_the_limit_of_friction_everywhere() {
    let friction = 0.05;
    let setup = soft_press(linear, Vec::new(), [false, true]);
    let setup = Setup {
        sensor: SensorBody::Rigid { edge_radius_mm: 1.5 },
        grip: Grip::Coulomb(friction),
        load: Load::Path(vec![pose(0.3, 0.0), pose(0.3, 0.8)]),
        ..setup
    };
    let pressed = run(&setup);
    let ratio = |step: &PressStep| {
        let peak = step.peak_pressure_kpa;
        let borne = step.points.iter().filter(|p| p.pressure_kpa > 0.2 * peak && p.reference_mm[0].abs() < 12.0);
        borne
            .map(|p| p.shear_kpa / p.pressure_kpa)
            .fold([f64::INFINITY, 0.0], |[low, high], r| [r.min(low), r.max(high)])
    };
    let [pressing, sliding] = [&pressed.steps[0], &pressed.steps[1]].map(ratio);
    println!("{pressing:?} {sliding:?}");
    assert!(pressing[0] < 0.9 * friction, "the middle sticks as it is pressed: {pressing:?}");
    assert!((sliding[0] / friction - 1.0).abs() < 0.01 && (sliding[1] / friction - 1.0).abs() < 0.01, "{sliding:?}");
}

#[test]
fn steps_hold_as_loads_do_and_go_on_where_they_stopped() {
    let relaxing = |youngs: f64| linear(youngs).with_relaxation(vec![Prony { share: 0.4, time_s: 6.0 }]).unwrap();
    let mut setup = soft_press(linear, Vec::new(), [true; 2]);
    setup.kinematics = Kinematics::Axisymmetric;
    setup.phantom.resolution = Resolution::PLANE.halved();
    setup.phantom_materials = vec![relaxing(5.0)];
    setup.sensor = SensorBody::Rigid { edge_radius_mm: 0.0 };
    setup.seconds_per_mm = Some(2.0);
    let held = |depth_mm: f64, hold_s: f64| Pose { depth_mm, hold_s, ..Pose::default() };
    let by = |load: Load, hold_s: f64| forces(&run(&Setup { load, hold_s, ..setup.clone() }));
    let [plain] = by(Load::Depths(vec![1.0]), 25.0)[..] else { panic!("one load") };
    let steps = by(Load::Path(vec![held(1.0, 0.0), held(1.0, 5.0), held(1.0, 20.0)]), 0.0);
    println!("{plain} {steps:?}");
    assert!((steps[2] / plain - 1.0).abs() < 1e-4, "{plain} {steps:?}");
    assert!(steps[0] > 1.05 * steps[1] && steps[1] > 1.05 * steps[2], "{steps:?}");
    // All of it is one material, whose force follows its modulus: relaxed to what is left after 2 + 25 s.
    let slow = forces(&run(&Setup { seconds_per_mm: None, ..setup.clone() }))[0];
    let left = |s: f64| 0.6 + 0.4 * 6.0 / 2.0 * ((-s / 6.0).exp() - (-(s + 2.0) / 6.0).exp());
    assert!((plain / slow - left(25.0) / 0.6).abs() < 2e-3, "{}, expected {}", plain / slow, left(25.0) / 0.6);
}

/// A phantom whose force is no even function of time, pressed at a rate and then held.
fn relaxing_ramp(material: fn() -> Material, hold_s: f64, time_steps: usize) -> Setup {
    let mut setup = soft_press(linear, Vec::new(), [true; 2]);
    setup.kinematics = Kinematics::Axisymmetric;
    setup.phantom.resolution = Resolution::PLANE.halved().finer(0.5);
    setup.phantom_materials = vec![material().with_relaxation(vec![Prony { share: 0.6, time_s: 0.5 }]).unwrap()];
    setup.sensor = SensorBody::Rigid { edge_radius_mm: 0.0 };
    (setup.load, setup.seconds_per_mm, setup.hold_s) = (Load::Depths(vec![2.0]), Some(1.0), hold_s);
    Setup { time_steps, ..setup }
}

/// Stresses change evenly within a step: one step to a load is off by per cents, and so is one of a hold. Steps as they
/// are taken are within 0.2 % of steps a fifth as long, and the estimate of the error has what they are off.
#[test]
fn what_relaxes_follows_the_load_in_time() {
    let stiffening = || Material::elastic(Law::Exponential { modulus_kpa: 5.0, exponent: 14.4 }, 0.4999).unwrap();
    let plain = || Material::neo_hookean(5.0, 0.4999).unwrap();
    for (name, material) in [("stiffening", stiffening as fn() -> Material), ("plain", plain as fn() -> Material)] {
        for hold_s in [0.0, 1.0] {
            let force = |steps: usize| forces(&run(&relaxing_ramp(material, hold_s, steps)))[0];
            let [one, few, usual, many] = [1, 2, TIME_STEPS, 50].map(force);
            let off = |force: f64| (force / many - 1.0).abs();
            println!("{name}, held {hold_s} s: {many} N; off by {} {} {}", off(one), off(few), off(usual));
            assert!(off(usual) < 2e-3, "{name} {hold_s}: {usual} N, {many} N");
            assert!(off(one) > 4.0 * off(usual), "{name} {hold_s}: {one} N, {many} N");
            let settings = PressSettings { estimate_error: true, ..PressSettings::default() };
            for (steps, off) in [(2, off(few)), (TIME_STEPS, off(usual))] {
                let pressed = press(&relaxing_ramp(material, hold_s, steps), settings, &mut |_| true).unwrap();
                let error = pressed.steps[0].error.unwrap().force;
                println!("by {steps} steps said to be off by {error}");
                assert!(error > off, "{name} {hold_s}, {steps} steps: {error}, off by {off}");
            }
        }
    }
}
