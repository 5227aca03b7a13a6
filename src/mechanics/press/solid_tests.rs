use super::*;
use crate::mechanics::contact::Grip;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, InclusionShape, PhantomMesh, PhantomShape, Resolution, Star};

/// The phantom of physics section 5 pressed by 1 mm with a tied sensor; an 8 mm sphere of 120 kPa with its top at 5 mm.
fn phantom_press(kinematics: Kinematics, resolution: Resolution, ball: bool, soft: bool, linear: bool) -> Setup {
    let material = |e: f64| if linear { Material::linear(e, 0.4999).unwrap() } else { Material::neo_hookean(e, 0.4999).unwrap() };
    let sphere = InclusionShape { center_mm: [0.0, 0.0, 9.0], surface: Star::Ellipsoid { semi_axes_mm: [4.0; 3] } };
    let layers = [(5.0, 15.0), (3.0, 30.0), (2.0, 60.0)];
    Setup {
        kinematics,
        phantom: PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: 25.0 },
            inclusions: ball.then_some(sphere).into_iter().collect(),
            footprint: Footprint::Round { radius_mm: 15.0 },
            symmetry: [true, true],
            resolution,
        },
        phantom_materials: [Some(material(5.0)), ball.then(|| material(120.0))].into_iter().flatten().collect(),
        sensor: match soft {
            true => SensorBody::Layers(layers.map(|(thickness, youngs)| (thickness, material(youngs))).to_vec()),
            false => SensorBody::Rigid { edge_radius_mm: 0.5 },
        },
        grip: Grip::Bonded,
        load: Load::Depths(vec![1.0]),
        seconds_per_mm: None,
        hold_s: 0.0,
    }
}

fn run(setup: &Setup) -> Pressed {
    press(setup, PressSettings { estimate_error: false }, &mut |_| true).unwrap()
}

/// Mean pressure between two distances from the axis, Pa.
fn ring_mean(step: &PressStep, inner: f64, outer: f64) -> f64 {
    let (mut force, mut area) = (0.0, 0.0);
    for p in &step.points {
        let r = p.reference_mm[0].hypot(p.reference_mm[1]);
        if inner <= r && r < outer {
            force += p.force_mn;
            area += p.area_mm2;
        }
    }
    1e3 * force / area
}

#[test]
fn ladder() {
    let solid = Resolution::SOLID;
    for (ball, soft, linear) in [(false, false, true), (true, false, true), (false, true, true), (true, true, true), (true, true, false)] {
        let flat = run(&phantom_press(Kinematics::Axisymmetric, Resolution::PLANE, ball, soft, linear));
        let show = |name: &str, p: &Pressed| {
            let s = &p.steps[0];
            let rings: Vec<String> = (0..6).map(|k| format!("{:.1}", ring_mean(s, 2.0 * k as f64, 2.0 * k as f64 + 2.0))).collect();
            println!("{name} ball {ball} soft {soft} linear {linear}: force {:.5} mean {:.2} rings {} unknowns {} elements {} it {} s {:.2} MiB {:.0}", s.force_n, ring_mean(s, 0.0, 1.0), rings.join(" "), p.unknowns, p.assembly.problem.mesh.element_count(), p.iterations, p.seconds, p.factor_mib);
        };
        show("2D", &flat);
        for (k, r) in [solid.scaled(1.5), solid, solid.scaled(0.7)].into_iter().enumerate() {
            if std::env::var("TT_MAX").is_ok_and(|m| k > m.parse().unwrap()) { continue; }
            show(&format!("3D {k}"), &run(&phantom_press(Kinematics::ThreeDimensional, r, ball, soft, linear)));
        }
    }
}
