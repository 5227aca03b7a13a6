//! Presses that are tilted or off the axis: by mirror images, orders in the tilt, and balance of moments.

use super::solid_tests::{assert_forces_balance, linear, moments, run, soft_press, sphere};
use super::*;
use crate::mechanics::contact::Grip;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::{PhantomShape, Resolution};
use crate::mechanics::solid::element_system;

/// A press of a plain phantom, tilted about y; the sensor is soft where it is tied, else rigid, which costs less.
fn tilted(grip: Grip, about_y: f64) -> Pressed {
    let mut setup = Setup { tilt_deg: [0.0, about_y], grip, ..soft_press(linear, Vec::new(), [false, true]) };
    if grip != Grip::Bonded {
        setup.sensor = SensorBody::Rigid { edge_radius_mm: 1.5 };
    }
    run(&setup)
}

#[test]
fn opposite_tilts_are_mirror_images() {
    for grip in [Grip::Bonded, Grip::Frictionless] {
        let [left, right] = [-1.0, 1.0].map(|tilt| tilted(grip, tilt));
        if grip == Grip::Bonded {
            assert_forces_balance(&right);
        }
        let force = right.steps[0].force_n;
        assert!((left.steps[0].force_n / force - 1.0).abs() < 1e-5);
        let [mirrored, moment] = [moments(&left)[0], moments(&right)[0]];
        // About y, x goes down: the side of positive x is pressed more.
        assert!(moment > 0.1 * force && (mirrored / moment + 1.0).abs() < 1e-4, "{grip:?}: {moment} {mirrored}");
    }
}

#[test]
fn a_small_tilt_changes_the_force_to_second_order_and_the_moment_to_first() {
    let [flat, small, twice] = [0.0, 0.5, 1.0].map(|tilt| tilted(Grip::Bonded, tilt));
    let [none, once, double] = [&flat, &small, &twice].map(|pressed| pressed.steps[0].force_n);
    let [still, moment, more] = [&flat, &small, &twice].map(|pressed| moments(pressed)[0]);
    println!("forces {none} {once} {double}, moments {still} {moment} {more}");
    assert!(still.abs() < 1e-6 * none);
    assert!((more / moment - 2.0).abs() < 0.05, "{moment} {more}");
    let ratio = (double - none) / (once - none);
    assert!((ratio - 4.0).abs() < 0.4, "{none} {once} {double}");
}

/// Moment about y, through the origin, of the internal forces on the phantom's base, N mm, of the whole press.
fn moment_of_base(pressed: &Pressed) -> f64 {
    let (problem, state) = (&pressed.assembly.problem, &pressed.steps[0].state);
    let mesh = &problem.mesh;
    let mut held = vec![false; mesh.nodes.len()];
    let supports = problem.supports.iter().filter(|s| s.axis == 2 && s.displacement_mm != 0.0);
    supports.for_each(|s| held[s.node as usize] = true);
    let mut sum = 0.0;
    for e in 0..mesh.element_count() {
        let element = mesh.element(e);
        let at = |values: &[[f64; 3]]| element.iter().map(|&a| values[a as usize]).collect::<Vec<_>>();
        let (nodes, moved) = (at(&mesh.nodes), at(&state.displacement));
        let material = &problem.materials[mesh.region[e] as usize];
        let pressure = &state.pressure[4 * e..4 * e + 4];
        let system = element_system(problem.kinematics, &nodes, &moved, pressure, material, None, None).unwrap();
        for (k, _) in element.iter().enumerate().filter(|(_, a)| held[**a as usize]) {
            let [x, z] = [0, 2].map(|i| nodes[k][i] + moved[k][i]);
            sum += z * system.force[3 * k] - x * system.force[3 * k + 2];
        }
    }
    1e-3 * pressed.setup.copies() * sum
}

#[test]
fn the_bases_moment_is_that_of_the_contacts_pressure() {
    let pressed = tilted(Grip::Frictionless, 1.0);
    let base = moment_of_base(&pressed).abs();
    let moment = |shift: f64| {
        let points = pressed.steps[0].points.iter();
        let sum: f64 = points.map(|p| p.force_mn * (p.reference_mm[0] + p.displacement_mm[0] + shift)).sum();
        1e-3 * pressed.setup.copies() * sum
    };
    let off = |shift: f64| (moment(shift) - base).abs() / base;
    println!("base {base}, contact {}", moment(0.0));
    // A linear material is in balance on undeformed elements: its moment closes to the order of strain, 1 in 25.
    assert!(off(0.0) < 0.05, "{} {base}", moment(0.0));
    // Half a millimetre aside, it would not be.
    assert!(off(0.5) > 0.05 && off(-0.5) > 0.05, "{} {}", off(0.5), off(-0.5));
}

/// A block of 160 x 140 mm with a sphere, under a round face; the outline aside by `offset` along x.
fn in_block(sphere_x: f64, offset: f64) -> Pressed {
    let mut setup = soft_press(linear, vec![sphere([sphere_x, 0.0, 9.0], 4.0)], [false, true]);
    setup.phantom.shape = PhantomShape::Block { size_mm: [160.0, 140.0], height_mm: 25.0 };
    setup.sensor = SensorBody::Rigid { edge_radius_mm: 0.0 };
    setup.phantom.offset_mm = [offset, 0.0];
    run(&setup)
}

#[test]
fn a_wide_block_off_the_axis_is_as_one_whose_inclusion_is_aside() {
    let [moved, aside] = [4.0, 0.0].map(|offset| in_block(4.0, offset));
    assert_forces_balance(&moved);
    let [force, other] = [&moved, &aside].map(|pressed| pressed.steps[0].force_n);
    let [moment, beside] = [&moved, &aside].map(|pressed| moments(pressed)[0]);
    println!("forces {force} {other}, moments {moment} {beside}");
    // The block's sides are 51 mm and more from the contact's edge, twice its height.
    assert!((force / other - 1.0).abs() < 1e-3, "{force} {other}");
    // Where the force acts, mm: the sides still draw it, by 0.005 (by 0.035 in a block half as wide).
    assert!((moment - beside).abs() < 0.01 * force, "{moment} {beside}");
    // A sphere left behind, in the middle, would leave no moment.
    assert!(moment.abs() > 0.03 * force);
}

#[test]
fn a_fitted_sphere_presses_as_axisymmetry_says() {
    // In a quarter: four spheres of the body's own material are not felt, but that their boxes collide with that of the
    // one in the middle, which is then fitted.
    let own = sphere([4.5, 4.5, 11.5], 2.5);
    let mut setup = soft_press(linear, vec![sphere([0.0, 0.0, 9.0], 4.0), own], [true; 2]);
    setup.phantom_materials[2] = linear(5.0);
    setup.phantom.resolution.inclusion_divisions = 1.5;
    setup.sensor = SensorBody::Rigid { edge_radius_mm: 0.0 };
    assert!(!setup.phantom.boxed().unwrap());
    let stiff = run(&setup);
    assert_forces_balance(&stiff);
    // What a stiff sphere adds, on one mesh.
    let added = |mut setup: Setup, stiff: f64| {
        setup.phantom_materials[1] = linear(5.0);
        stiff / run(&setup).steps[0].force_n - 1.0
    };
    let found = added(setup.clone(), stiff.steps[0].force_n);
    setup.phantom.inclusions.truncate(1);
    setup.phantom_materials.truncate(2);
    setup.kinematics = Kinematics::Axisymmetric;
    setup.phantom.resolution = Resolution::PLANE;
    let expected = added(setup.clone(), run(&setup).steps[0].force_n);
    println!("the sphere adds {found} to the force, {expected} in axisymmetry");
    assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
}
