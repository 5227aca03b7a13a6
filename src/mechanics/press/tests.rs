use super::*;
use crate::mechanics::contact::Grip;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, InclusionShape, PhantomMesh, PhantomShape, Resolution, Star};

fn setup(diameter: Option<f64>, top: f64, youngs: f64, soft: bool, linear: bool, depths: Vec<f64>) -> Setup {
    let material =
        |e: f64| if linear { Material::linear(e, 0.4999).unwrap() } else { Material::neo_hookean(e, 0.4999).unwrap() };
    let inclusions = diameter.iter().map(|d| InclusionShape {
        center_mm: [0.0, 0.0, top + d / 2.0],
        surface: Star::Ellipsoid { semi_axes_mm: [d / 2.0; 3] },
    });
    Setup {
        kinematics: Kinematics::Axisymmetric,
        phantom: PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: 25.0 },
            inclusions: inclusions.collect(),
            footprint: Footprint::Round { radius_mm: 15.0 },
            symmetry: [true, true],
            resolution: Resolution::PLANE,
        },
        phantom_materials: std::iter::once(material(5.0)).chain(diameter.map(|_| material(youngs))).collect(),
        sensor: if soft {
            SensorBody::Layers(vec![(5.0, material(15.0)), (3.0, material(30.0)), (2.0, material(60.0))])
        } else {
            SensorBody::Rigid { edge_radius_mm: 0.5 }
        },
        grip: Grip::Bonded,
        load: Load::Depths(depths),
        seconds_per_mm: None,
        hold_s: 0.0,
    }
}

fn show(name: &str, setup: &Setup) {
    match press(setup, PressSettings { estimate_error: true }, &mut |_| true) {
        Ok(p) => {
            for s in &p.steps {
                let (mut f, mut a) = (0.0, 0.0);
                for q in s.points.iter().filter(|q| q.reference_mm[0] < 1.0) {
                    f += q.force_mn;
                    a += q.area_mm2;
                }
                println!(
                    "{name}: depth {:.3} force {:.5} mean {:.2} Pa peak {:.4} kPa error {:?} unknowns {} it {} s {:.2}+{:.2} MiB {:.0}",
                    s.depth_mm,
                    s.force_n,
                    1e3 * f / a,
                    s.peak_pressure_kpa,
                    s.error,
                    p.unknowns,
                    p.iterations,
                    p.seconds,
                    p.error_seconds,
                    p.factor_mib
                );
            }
        }
        Err(e) => println!("{name}: {e}"),
    }
}

#[test]
fn digits() {
    show("none rigid", &setup(None, 0.0, 0.0, false, true, vec![1.0]));
    show("8 at 5 rigid", &setup(Some(8.0), 5.0, 120.0, false, true, vec![1.0]));
    show("none soft", &setup(None, 0.0, 0.0, true, true, vec![1.0]));
    show("8 at 5 soft", &setup(Some(8.0), 5.0, 120.0, true, true, vec![1.0]));
    show("none soft nh", &setup(None, 0.0, 0.0, true, false, vec![1.0, 2.0, 4.0]));
    show("8 at 5 soft nh", &setup(Some(8.0), 5.0, 120.0, true, false, vec![1.0, 2.0, 4.0]));
    for (d, t, e) in [
        (2.0, 5.0, 120.0),
        (14.0, 5.0, 120.0),
        (7.0, 3.0, 100.0),
        (7.0, 7.0, 100.0),
        (7.0, 11.2, 100.0),
        (10.0, 5.0, 44.5),
        (10.0, 5.0, 63.5),
        (10.0, 5.0, 102.8),
    ] {
        show(&format!("{d} at {t} of {e} soft"), &setup(Some(d), t, e, true, true, vec![1.0]));
        show(&format!("{d} at {t} of {e} soft nh"), &setup(Some(d), t, e, true, false, vec![4.0]));
    }
    let mut force = setup(Some(8.0), 5.0, 120.0, true, false, vec![]);
    force.load = Load::Forces(vec![0.3, 1.0]);
    show("by force", &force);
    force.grip = Grip::Frictionless;
    force.load = Load::Depths(vec![1.0, 2.0, 4.0]);
    show("frictionless", &force);
    force.sensor = SensorBody::Rigid { edge_radius_mm: 0.5 };
    show("rigid frictionless", &force);
}

#[test]
fn hard() {
    show("7 at 3", &setup(Some(7.0), 3.0, 100.0, true, false, vec![4.0]));
    show("14 at 5", &setup(Some(14.0), 5.0, 120.0, true, false, vec![4.0]));
    let mut force = setup(Some(8.0), 5.0, 120.0, false, false, vec![1.0]);
    force.grip = Grip::Frictionless;
    show("rigid frictionless", &force);
}
