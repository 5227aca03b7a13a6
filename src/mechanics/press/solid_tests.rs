//! The press in three dimensions: against the axisymmetric one, and by balance and symmetry where that has no answer.

use super::*;
use crate::mechanics::contact::Grip;
use crate::mechanics::element::PressureOrder;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, InclusionShape, PhantomMesh, PhantomShape, Resolution, Star};
use crate::mechanics::solid::element_system;
use crate::scene::TriangleMesh;
use std::sync::Arc;

/// Coarse enough for seconds: the checks below hold on any mesh.
const COARSE: Resolution = Resolution {
    edge_mm: 4.0,
    ring_share: 1.0,
    contact_mm: 6.0,
    coarsest_mm: 14.0,
    growth: 1.5,
    rim_mm: 0.0,
    rim_divisions: 1.0,
    inclusion_divisions: 1.0,
    subdivision: 1,
};

pub(super) fn linear(youngs_kpa: f64) -> Material {
    Material::linear(youngs_kpa, 0.4999).unwrap()
}

fn neo_hookean(youngs_kpa: f64) -> Material {
    Material::neo_hookean(youngs_kpa, 0.4999).unwrap()
}

pub(super) fn sphere(center_mm: [f64; 3], radius_mm: f64) -> InclusionShape {
    InclusionShape { center_mm, surface: Star::Ellipsoid { semi_axes_mm: [radius_mm; 3] } }
}

/// A phantom of 30 x 25 mm and 5 kPa with inclusions of 120 kPa, tied to a sensor of 15 mm radius with soft layers.
pub(super) fn soft_press(material: fn(f64) -> Material, inclusions: Vec<InclusionShape>, symmetry: [bool; 2]) -> Setup {
    let layers = [(5.0, 15.0), (3.0, 30.0), (2.0, 60.0)];
    let stiff = inclusions.iter().map(|_| material(120.0));
    Setup {
        kinematics: Kinematics::ThreeDimensional,
        pressure: PressureOrder::Linear,
        phantom_materials: std::iter::once(material(5.0)).chain(stiff).collect(),
        phantom: PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: 25.0 },
            inclusions,
            footprint: Footprint::Round { radius_mm: 15.0 },
            symmetry,
            resolution: COARSE,
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        },
        sensor: SensorBody::Layers {
            layers: layers.map(|(thickness, youngs)| (thickness, material(youngs))).to_vec(),
            edge_radius_mm: 0.0,
        },
        grip: Grip::Bonded,
        load: Load::Depths(vec![1.0]),
        seconds_per_mm: None,
        hold_s: 0.0,
        time_steps: TIME_STEPS,
        tilt_deg: [0.0; 2],
    }
}

pub(super) fn run(setup: &Setup) -> Pressed {
    press(setup, PressSettings::default(), &mut |_| true).unwrap()
}

/// Mean pressure between two distances from the axis, Pa.
fn ring_mean(pressed: &Pressed, inner: f64, outer: f64) -> f64 {
    let ring = pressed.steps[0].points.iter().filter(|p| {
        let r = p.reference_mm[0].hypot(p.reference_mm[1]);
        inner <= r && r < outer
    });
    let [force, area] = ring.fold([0.0; 2], |sum, p| [sum[0] + p.force_mn, sum[1] + p.area_mm2]);
    1e3 * force / area
}

/// Moments of the pressure about the axis, N mm.
pub(super) fn moments(pressed: &Pressed) -> [f64; 2] {
    [0, 1].map(|i| 1e-3 * pressed.steps[0].points.iter().map(|p| p.force_mn * p.reference_mm[i]).sum::<f64>())
}

/// Sum along z of the internal forces on the nodes that a plane holds, of the whole press, N.
fn reaction(pressed: &Pressed, moved: bool) -> f64 {
    let (problem, state) = (&pressed.assembly.problem, &pressed.steps[0].state);
    let mesh = &problem.mesh;
    let mut held = vec![false; mesh.nodes.len()];
    let supports = problem.supports.iter().filter(|s| s.axis == 2 && (s.displacement_mm != 0.0) == moved);
    supports.for_each(|s| held[s.node as usize] = true);
    let mut sum = 0.0;
    for e in 0..mesh.element_count() {
        let element = mesh.element(e);
        let at = |values: &[[f64; 3]]| element.iter().map(|&a| values[a as usize]).collect::<Vec<_>>();
        let material = &problem.materials[mesh.region[e] as usize];
        let pressure = &state.pressure[4 * e..4 * e + 4];
        let (nodes, moved) = (at(&mesh.nodes), at(&state.displacement));
        let system = element_system(problem.kinematics, &nodes, &moved, pressure, material, None, None).unwrap();
        let on_base = element.iter().enumerate().filter(|(_, a)| held[**a as usize]);
        sum += on_base.map(|(k, _)| system.force[3 * k + 2]).sum::<f64>();
    }
    1e-3 * pressed.setup.copies() * sum.abs()
}

/// The contact bears what the phantom's base bears, and the glass of a soft sensor.
pub(super) fn assert_forces_balance(pressed: &Pressed) {
    let force = pressed.steps[0].force_n;
    assert!(force > 0.0);
    // Newton's balance is to 1e-9 of all internal forces, which add up to some hundred times the force.
    let soft = matches!(pressed.setup.sensor, SensorBody::Layers { .. });
    for moved in if soft { vec![true, false] } else { vec![true] } {
        let reaction = reaction(pressed, moved);
        assert!((reaction / force - 1.0).abs() < 1e-6, "the contact bears {force} N, a base {reaction} N");
    }
}

#[test]
fn the_quarter_agrees_with_axisymmetry_within_a_percent() {
    for (ball, soft, rim) in [(false, false, 0.5), (true, true, 0.0)] {
        let balls = if ball { vec![sphere([0.0, 0.0, 9.0], 4.0)] } else { Vec::new() };
        let mut setup = soft_press(linear, balls, [true, true]);
        let coarse = Resolution {
            edge_mm: 1.4,
            contact_mm: 3.5,
            coarsest_mm: 8.0,
            growth: 0.9,
            inclusion_divisions: 3.0,
            ..Resolution::SOLID
        };
        setup.phantom.resolution = coarse;
        match &mut setup.sensor {
            SensorBody::Layers { edge_radius_mm, .. } if soft => *edge_radius_mm = rim,
            sensor => *sensor = SensorBody::Rigid { edge_radius_mm: rim },
        }
        let solid = run(&setup);
        setup.kinematics = Kinematics::Axisymmetric;
        setup.phantom.resolution = Resolution::PLANE;
        let flat = run(&setup);
        let off = |value: &dyn Fn(&Pressed) -> f64| (value(&solid) / value(&flat) - 1.0).abs();
        let rings = [[0.0, 3.0], [3.0, 6.0], [5.0, 9.0]];
        let pressure = rings.map(|[inner, outer]| off(&|p| ring_mean(p, inner, outer)));
        let force = off(&|p| p.steps[0].force_n);
        println!("force {force:.4} pressure {pressure:.4?}, {} unknowns, {:.2} s", solid.unknowns, solid.seconds);
        assert!(force < 0.01 && pressure.iter().all(|off| *off < 0.01), "{force} {pressure:?}");
    }
}

#[test]
fn an_off_axis_inclusion_mirrors() {
    let press_at = |x: f64| run(&soft_press(linear, vec![sphere([x, 0.0, 9.0], 4.0)], [false, true]));
    let [right, left] = [5.0, -5.0].map(press_at);
    assert_forces_balance(&right);
    let force = right.steps[0].force_n;
    assert!((left.steps[0].force_n / force - 1.0).abs() < 1e-6);
    let [moment, mirrored] = [moments(&right)[0], moments(&left)[0]];
    // The stiff sphere draws the pressure to its side.
    assert!(moment > 0.01 * force && (mirrored / moment + 1.0).abs() < 1e-5, "{moment} {mirrored}");
}

#[test]
fn two_inclusions_press_alike_on_both_sides() {
    let pair = [6.0, -6.0].map(|x| sphere([x, 0.0, 9.0], 3.0)).to_vec();
    let both = run(&soft_press(linear, pair, [false, true]));
    assert_forces_balance(&both);
    // One of them alone is the quarter's own inclusion.
    let quarter = run(&soft_press(linear, vec![sphere([6.0, 0.0, 9.0], 3.0)], [true, true]));
    let [force, half] = [&both, &quarter].map(|p| p.steps[0].force_n);
    assert!((half / force - 1.0).abs() < 1e-3, "{half} {force}");
    assert!(moments(&both)[0].abs() < 1e-6 * force);
}

#[test]
fn an_ellipsoid_turned_by_a_quarter_turns_the_pressure() {
    let press_with = |semi_axes_mm: [f64; 3]| {
        let surface = Star::Ellipsoid { semi_axes_mm };
        run(&soft_press(linear, vec![InclusionShape { center_mm: [0.0, 0.0, 8.5], surface }], [true, true]))
    };
    let [along_x, along_y] = [[5.0, 2.5, 3.5], [2.5, 5.0, 3.5]].map(press_with);
    assert_forces_balance(&along_x);
    let second =
        |p: &Pressed, i: usize| p.steps[0].points.iter().map(|q| q.force_mn * q.reference_mm[i].powi(2)).sum::<f64>();
    assert!((along_y.steps[0].force_n / along_x.steps[0].force_n - 1.0).abs() < 1e-6);
    assert!((second(&along_y, 1) / second(&along_x, 0) - 1.0).abs() < 1e-5);
    assert!((second(&along_x, 1) / second(&along_x, 0) - 1.0).abs() > 1e-3);
}

#[test]
fn a_rectangular_footprint_presses() {
    let mut setup = soft_press(neo_hookean, vec![sphere([0.0, 0.0, 9.0], 4.0)], [true, true]);
    setup.phantom.footprint = Footprint::Rectangle { half_widths_mm: [12.0, 12.0] };
    let square = run(&setup);
    assert_forces_balance(&square);
    // x and y are alike.
    let points = &square.steps[0].points;
    for p in points {
        let [x, y, _] = p.reference_mm;
        let near = |q: &&ContactPoint| (q.reference_mm[0] - y).hypot(q.reference_mm[1] - x) < 1e-6;
        let mirror = points.iter().find(near).unwrap();
        assert!((p.pressure_kpa - mirror.pressure_kpa).abs() < 1e-5, "{p:?} {mirror:?}");
    }
}

#[test]
fn layers_of_a_column_are_springs_in_series() {
    let mut setup = soft_press(linear, Vec::new(), [true; 2]);
    setup.phantom.shape = PhantomShape::Block { size_mm: [20.0, 16.0], height_mm: 12.0 };
    setup.phantom.footprint = Footprint::Rectangle { half_widths_mm: [10.0, 8.0] };
    setup.phantom.layers_mm = vec![2.0, 3.5];
    setup.phantom_materials = [5.0, 40.0, 2.0].map(|youngs| Material::linear(youngs, 0.0).unwrap()).to_vec();
    setup.sensor = SensorBody::Rigid { edge_radius_mm: 0.0 };
    // Nothing moves sideways where Poisson's ratio is 0.
    let force = 1e-3 * 20.0 * 16.0 * 1.0 / (6.5 / 5.0 + 2.0 / 40.0 + 3.5 / 2.0);
    let found = run(&setup).steps[0].force_n;
    assert!((found / force - 1.0).abs() < 1e-6, "{found}, expected {force}");
}

/// A ball of about 3 mm with bumps, in triangles, no plane of symmetry.
fn bumpy_ball() -> TriangleMesh {
    let (rings, sectors) = (12, 24);
    let vertex = |theta: f64, phi: f64| {
        let r = 3.0 * (1.0 + 0.15 * (3.0 * phi + 0.5).sin() * theta.sin().powi(3) + 0.1 * (2.0 * theta).cos());
        [r * theta.sin() * phi.cos(), r * theta.sin() * phi.sin(), r * theta.cos()]
    };
    let mut vertices = vec![vertex(0.0, 0.0), vertex(std::f64::consts::PI, 0.0)];
    for i in 1..rings {
        let theta = std::f64::consts::PI * f64::from(i) / f64::from(rings);
        vertices.extend((0..sectors).map(|k| vertex(theta, std::f64::consts::TAU * f64::from(k) / f64::from(sectors))));
    }
    let at = |i: i32, k: i32| (2 + (i - 1) * sectors + k % sectors) as u32;
    let mut triangles = Vec::new();
    for k in 0..sectors {
        triangles.push([0, at(1, k), at(1, k + 1)]);
        triangles.push([1, at(rings - 1, k + 1), at(rings - 1, k)]);
        for i in 1..rings - 1 {
            triangles.push([at(i, k), at(i + 1, k), at(i + 1, k + 1)]);
            triangles.push([at(i, k), at(i + 1, k + 1), at(i, k + 1)]);
        }
    }
    TriangleMesh { vertices, triangles }
}

#[test]
fn an_irregular_inclusion_presses() {
    let surface = Star::Mesh(Arc::new(bumpy_ball()));
    let inclusion = InclusionShape { center_mm: [2.0, 1.0, 9.0], surface };
    let rigid = |setup: Setup| Setup { sensor: SensorBody::Rigid { edge_radius_mm: 0.0 }, ..setup };
    let stiff = run(&rigid(soft_press(linear, vec![inclusion], [false, false])));
    assert_forces_balance(&stiff);
    let plain = run(&rigid(soft_press(linear, Vec::new(), [true, true])));
    let [with, without] = [&stiff, &plain].map(|p| ring_mean(p, 0.0, 4.0));
    assert!(with > 1.1 * without, "{with} {without}");
}
