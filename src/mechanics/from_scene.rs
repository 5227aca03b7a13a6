//! From the words of a scene to materials and shapes.

use super::contact::{Grip, Profile};
use super::element::PressureOrder;
use super::kinematics::Kinematics;
use super::material::{Law, Material, MaterialError, OgdenTerm, Prony};
use super::mesh::{Footprint, InclusionShape, PhantomMesh, PhantomShape, Resolution, Star};
use super::press::{Cost, Load, Pose, PressError, SensorBody, Setup, TIME_STEPS};
use crate::scene::{
    DataFileError, Dimensions, Elastic, FaceOutline, Inclusion, InclusionBody, Indenter, Inputs, Interface,
    LoadedScene, Phantom, PhantomBody, Press, PressStep, PressedSensor, Stack, TriangleMesh, read_indenter_table,
    read_mesh,
};
use std::sync::Arc;

/// The material of an elastic law.
///
/// # Errors
/// When a parameter makes no sense; never for a law of a validated scene.
pub fn material(elastic: &Elastic) -> Result<Material, MaterialError> {
    let poisson = elastic.poisson();
    let material = match elastic {
        Elastic::Linear { youngs_kpa, .. } => Material::linear(*youngs_kpa, poisson),
        Elastic::NeoHookean { youngs_kpa, .. } => Material::neo_hookean(*youngs_kpa, poisson),
        Elastic::Yeoh { c_kpa, .. } => Material::elastic(Law::Yeoh { c_kpa: *c_kpa }, poisson),
        Elastic::Ogden { terms, .. } => {
            let term =
                |term: &crate::scene::OgdenTerm| OgdenTerm { shear_kpa: term.shear_kpa, exponent: term.exponent };
            Material::elastic(Law::Ogden { terms: terms.iter().map(term).collect() }, poisson)
        }
        Elastic::Exponential { modulus_kpa, exponent, .. } => {
            Material::elastic(Law::Exponential { modulus_kpa: *modulus_kpa, exponent: *exponent }, poisson)
        }
    }?;
    let relaxation = elastic.relaxation().iter().map(|term| Prony { share: term.share, time_s: term.time_s });
    material.with_relaxation(relaxation.collect())
}

/// Materials of a phantom by region: its own, then of each inclusion, then of each layer.
///
/// # Errors
/// As [`material`].
pub fn materials(phantom: &Phantom) -> Result<Vec<Material>, MaterialError> {
    let inclusions = phantom.inclusion.iter().map(|one| &one.material);
    let layers = phantom.layer.iter().map(|layer| &layer.material);
    std::iter::once(&phantom.material).chain(inclusions).chain(layers).map(material).collect()
}

/// The outer shape of a phantom.
pub fn phantom_shape(body: &PhantomBody) -> PhantomShape {
    match *body {
        PhantomBody::Cylinder { radius_mm, height_mm } => PhantomShape::Cylinder { radius_mm, height_mm },
        PhantomBody::Block { size_mm, height_mm } => PhantomShape::Block { size_mm, height_mm },
    }
}

/// The outline of the contact.
pub fn footprint(face: &FaceOutline) -> Footprint {
    match *face {
        FaceOutline::Round { radius_mm } => Footprint::Round { radius_mm },
        FaceOutline::Rectangle { half_widths_mm } => Footprint::Rectangle { half_widths_mm },
    }
}

/// The shape and place of an inclusion; a mesh is one of `files`.
///
/// # Errors
/// When the file of a mesh cannot be read or is none.
pub fn inclusion_shape(inclusion: &Inclusion, files: &Inputs) -> Result<InclusionShape, DataFileError> {
    let (surface, reach_mm) = match &inclusion.shape {
        InclusionBody::Sphere { diameter_mm } => {
            (Star::Ellipsoid { semi_axes_mm: [diameter_mm / 2.0; 3] }, diameter_mm / 2.0)
        }
        &InclusionBody::Ellipsoid { semi_axes_mm } => (Star::Ellipsoid { semi_axes_mm }, semi_axes_mm[2]),
        InclusionBody::Mesh { file, scale } => {
            let mesh = scaled(read_mesh(&files.open(file)?)?, *scale);
            let reach_mm = mesh.vertices.iter().fold(0.0, |reach: f64, vertex| reach.max(-vertex[2]));
            (Star::Mesh(Arc::new(mesh)), reach_mm)
        }
    };
    let [x, y] = inclusion.center_mm;
    Ok(InclusionShape { center_mm: [x, y, inclusion.center_depth_mm(reach_mm)], surface })
}

/// The shape of an indenter; a table is one of `files`.
///
/// # Errors
/// When the file of a table cannot be read or is none.
pub fn profile(indenter: &Indenter, files: &Inputs) -> Result<Profile, DataFileError> {
    Ok(match indenter {
        &Indenter::Round { radius_mm } => Profile::Round { radius_mm },
        &Indenter::RoundedFlat { flat_mm, edge_radius_mm } => Profile::RoundedFlat { flat_mm, edge_radius_mm },
        Indenter::Table { file } => Profile::Table(read_indenter_table(&files.open(file)?)?),
    })
}

/// How touching faces hold each other.
pub fn grip(interface: Interface) -> Grip {
    match interface {
        Interface::Tied => Grip::Bonded,
        Interface::Frictionless => Grip::Frictionless,
        Interface::Coulomb { friction } => Grip::Coulomb(friction),
    }
}

/// What the press of a scene takes; none where it has none.
///
/// # Errors
/// As [`press_setup`] and [`Cost::of`].
pub fn press_cost(loaded: &LoadedScene) -> Result<Option<Cost>, PressError> {
    match press_setup(loaded) {
        Err(PressError::NoPress) => Ok(None),
        setup => Cost::of(&setup?, None).map(Some),
    }
}

/// The press of a scene.
///
/// # Errors
/// When the scene has none, a mesh cannot be read, or a material makes no sense.
pub fn press_setup(loaded: &LoadedScene) -> Result<Setup, PressError> {
    let scene = &loaded.scene;
    let (Some(phantom), Some(press)) = (&scene.phantom, &scene.press) else {
        return Err(PressError::NoPress);
    };
    let flat = match press.dimensions {
        Dimensions::Two => true,
        Dimensions::Three => false,
        Dimensions::Auto => press.asymmetry(phantom, &scene.stack).is_none(),
    };
    let inclusions = phantom.inclusion.iter().map(|one| inclusion_shape(one, &loaded.files));
    let mut inclusions = inclusions.collect::<Result<Vec<_>, _>>()?;
    // The sensor stays where it is; the phantom moves, with what is in it.
    for inclusion in &mut inclusions {
        (0..2).for_each(|axis| inclusion.center_mm[axis] += press.offset_mm[axis]);
    }
    let edge_radius_mm = press.edge_radius_mm(&scene.stack);
    let soft = press.indenter.is_none() && press.sensor == PressedSensor::Deformable;
    let bulges = soft && press.interface == Interface::Tied && edge_radius_mm == 0.0;
    let base = match flat {
        true if bulges => Resolution { ring_share: TIED_RINGS, ..Resolution::PLANE },
        true => Resolution::PLANE,
        false => Resolution::SOLID,
    };
    let profile = press.indenter.as_ref().map(|indenter| profile(indenter, &loaded.files)).transpose()?;
    let (footprint, resolution) = match (&profile, &press.indenter) {
        (Some(profile), Some(indenter)) => {
            let touched = touched(press, phantom, indenter, profile)?;
            let resolution = match indenter.flat_face_mm() {
                Some(_) => base,
                None => base.across(touched.curved_mm, if flat { CURVED_PLANE } else { CURVED_SOLID }),
            };
            (Footprint::Round { radius_mm: touched.radius_mm }, resolution)
        }
        _ => (footprint(&press.face(&scene.stack)), base),
    };
    Ok(Setup {
        kinematics: if flat { Kinematics::Axisymmetric } else { Kinematics::ThreeDimensional },
        pressure: PressureOrder::Linear,
        phantom: PhantomMesh {
            shape: phantom_shape(&phantom.shape),
            symmetry: [0, 1].map(|axis| {
                let slides = press.slides().any(|slide| slide[axis] != 0.0);
                let straight = press.offset_mm[axis] == 0.0 && press.tilt_deg[1 - axis] == 0.0 && !slides;
                flat || straight && inclusions.iter().all(|shape| is_symmetric(shape, axis))
            }),
            inclusions,
            footprint,
            resolution: resolution.finer(press.resolution),
            offset_mm: press.offset_mm,
            layers_mm: phantom.layer.iter().map(|layer| layer.thickness_mm).collect(),
        },
        phantom_materials: materials(phantom)?,
        sensor: match (profile, press.sensor) {
            (Some(profile), _) => SensorBody::Indenter(profile),
            (None, PressedSensor::Rigid) => SensorBody::Rigid { edge_radius_mm },
            (None, PressedSensor::Deformable) => {
                SensorBody::Layers { layers: soft_layers(&scene.stack)?, edge_radius_mm }
            }
        },
        grip: grip(press.interface),
        load: match (&press.depths_mm, &press.forces_n) {
            (Some(depths), _) => Load::Depths(depths.clone()),
            (None, Some(forces)) => Load::Forces(forces.clone()),
            (None, None) => Load::Path(poses(press)),
        },
        seconds_per_mm: press.rate_mm_per_s.map(|rate| 1.0 / rate),
        hold_s: press.hold_s,
        time_steps: TIME_STEPS,
        tilt_deg: press.tilt_deg,
    })
}

/// What an indenter is expected to touch.
struct Touched {
    /// Radius of the footprint, mm.
    radius_mm: f64,
    /// Radius that elements have to suit, mm: without slides.
    curved_mm: f64,
}

/// The disc that a press's indenter touches: out to where it lies as far below its tip as it is pressed in. The side of
/// the phantom may end it, but not where it slides.
fn touched(press: &Press, phantom: &Phantom, indenter: &Indenter, profile: &Profile) -> Result<Touched, PressError> {
    let room = |place: [f64; 2]| match phantom.shape {
        PhantomBody::Cylinder { radius_mm, .. } => radius_mm - place[0].hypot(place[1]),
        PhantomBody::Block { size_mm: [x, y], .. } => (0.5 * x - place[0].abs()).min(0.5 * y - place[1].abs()),
    };
    let within_mm = room(press.offset_mm);
    let slope = press.tilt_deg.map(|angle| angle.to_radians().tan()).iter().fold(0.0, |sum: f64, t| sum.hypot(*t));
    let deepest_mm = press.deepest_mm().unwrap_or(f64::INFINITY);
    let curved_mm = profile.reach(deepest_mm, slope, within_mm).max(LEAST_FOOTPRINT * within_mm);
    let length = |[x, y]: [f64; 2]| x.hypot(y);
    let slide_mm = press.slides().map(length).fold(0.0, f64::max);
    let radius_mm = match (press.footprint, indenter.flat_face_mm()) {
        (Some(face), _) => face.reach_mm(),
        (None, Some(face_mm)) => face_mm,
        (None, None) => curved_mm + slide_mm,
    };
    let touched_mm = curved_mm.min(radius_mm);
    let beyond = |slide: &[f64; 2]| touched_mm > room([0, 1].map(|axis| press.offset_mm[axis] + slide[axis]));
    if let Some(slide) = press.slides().find(|slide| length(*slide) > 0.0 && beyond(slide)) {
        let message = format!(
            "press.step: slide_mm = {slide:?} leads the indenter, which touches {touched_mm:.1} mm around its axis, \
             over the phantom's side; slide less far"
        );
        return Err(PressError::Unsupported(message));
    }
    Ok(Touched { radius_mm: radius_mm.min(within_mm), curved_mm: touched_mm })
}

/// Width of elements along r within the edge of a soft face that is tied ([`Resolution::ring_share`]). As wide as
/// high, slopes at the outline under 3 kPa are 8 % off (docs/decisions/rim.md).
const TIED_RINGS: f64 = 0.4;

/// Elements along the radius that a curved indenter is expected to touch, before those of two dimensions are halved.
/// Balls of 6 and 15 mm and a cone at their deepest: forces within 0.05 %, a ball's highest pressure within 1 % in two
/// dimensions and 4 % in three. 8 and 3 elements change the force by 0.05 %.
const CURVED_PLANE: f64 = 6.0;
const CURVED_SOLID: f64 = 4.0;

/// Least radius of an indenter's footprint, as a share of the way to the phantom's side.
const LEAST_FOOTPRINT: f64 = 0.005;

/// The steps of a press; what one leaves out stays.
fn poses(press: &Press) -> Vec<Pose> {
    let next = |pose: &mut Pose, step: &PressStep| {
        *pose = Pose {
            depth_mm: step.depth_mm.unwrap_or(pose.depth_mm),
            slide_mm: step.slide_mm.unwrap_or(pose.slide_mm),
            hold_s: step.hold_s,
        };
        Some(*pose)
    };
    press.step.iter().scan(Pose::default(), next).collect()
}

/// Thickness and material of the sensor's elastic layers, lowest first.
fn soft_layers(stack: &Stack) -> Result<Vec<(f64, Material)>, MaterialError> {
    let soft = stack.layer.iter().rev().filter_map(|layer| layer.elastic.as_ref().map(|e| (layer.thickness_mm, e)));
    soft.map(|(thickness, elastic)| Ok((thickness, material(elastic)?))).collect()
}

/// Whether an inclusion is its own mirror image in the plane where coordinate `axis` is 0.
fn is_symmetric(shape: &InclusionShape, axis: usize) -> bool {
    shape.center_mm[axis] == 0.0 && matches!(shape.surface, Star::Ellipsoid { .. })
}

fn scaled(mut mesh: TriangleMesh, scale: f64) -> TriangleMesh {
    for coordinate in mesh.vertices.iter_mut().flatten() {
        *coordinate *= scale;
    }
    mesh
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mechanics::mesh::{PhantomMesh, Resolution};
    use crate::scene::{DepthTo, PRESETS, Relaxation, Scene, preset, scan_preset, validate};
    use proptest::prelude::*;

    fn linear() -> Elastic {
        Elastic::Linear { youngs_kpa: 5.0, poisson: 0.4, relaxation: Vec::new() }
    }

    /// Laws with parameters on both sides of what is allowed.
    fn elastic() -> impl Strategy<Value = Elastic> {
        let modulus = || prop_oneof![Just(0.0), Just(-1.0), 0.01..1e3];
        let poisson = || prop_oneof![Just(0.5), Just(0.500_001), Just(-0.01), 0.0..0.5];
        let one = (prop_oneof![Just(1.0), -0.1..0.6], prop_oneof![Just(0.0), 0.1..10.0])
            .prop_map(|(share, time_s)| Relaxation { share, time_s });
        let relaxation = || proptest::collection::vec(one.clone(), 0..3);
        let term = (-2.0..2.0, prop_oneof![Just(0.0), -3.0..3.0])
            .prop_map(|(shear_kpa, exponent)| crate::scene::OgdenTerm { shear_kpa, exponent });
        prop_oneof![
            (modulus(), poisson(), relaxation()).prop_map(|(youngs_kpa, poisson, relaxation)| Elastic::Linear {
                youngs_kpa,
                poisson,
                relaxation
            }),
            (modulus(), poisson(), relaxation()).prop_map(|(youngs_kpa, poisson, relaxation)| Elastic::NeoHookean {
                youngs_kpa,
                poisson,
                relaxation
            }),
            ([-0.1..1.0, -2.0..1.0, -0.1..1.0], poisson(), relaxation())
                .prop_map(|(c_kpa, poisson, relaxation)| Elastic::Yeoh { c_kpa, poisson, relaxation }),
            (proptest::collection::vec(term, 0..3), poisson(), relaxation())
                .prop_map(|(terms, poisson, relaxation)| Elastic::Ogden { terms, poisson, relaxation }),
            (modulus(), modulus(), poisson(), relaxation()).prop_map(|(modulus_kpa, exponent, poisson, relaxation)| {
                Elastic::Exponential { modulus_kpa, exponent, poisson, relaxation }
            }),
        ]
    }

    fn scene_with(change: impl FnOnce(&mut Scene)) -> Scene {
        let mut scene = preset("phantom-size-8mm").unwrap().scene;
        change(&mut scene);
        scene
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The rules of the scene, which name the line, and those of the materials are two: here they are one.
        #[test]
        fn a_scene_allows_a_material_exactly_where_it_makes_sense(elastic in elastic()) {
            let scene = scene_with(|scene| scene.phantom.as_mut().unwrap().material = elastic.clone());
            prop_assert_eq!(validate(&scene).is_ok(), material(&elastic).is_ok(), "{:?}", elastic);
        }
    }

    #[test]
    fn moduli_arrive_as_they_were_given() {
        let relaxation = vec![Relaxation { share: 0.25, time_s: 3.0 }];
        let soft = material(&Elastic::NeoHookean { youngs_kpa: 15.0, poisson: 0.5, relaxation }).unwrap();
        assert!((soft.youngs_kpa() - 15.0).abs() < 1e-12 && (soft.law.shear_kpa() - 5.0).abs() < 1e-12);
        assert_eq!(soft.relaxation, [Prony { share: 0.25, time_s: 3.0 }]);
        assert!((soft.relaxed_shear_kpa() - 3.75).abs() < 1e-12);
        let terms = vec![crate::scene::OgdenTerm { shear_kpa: 2.0, exponent: 3.0 }];
        let ogden = material(&Elastic::Ogden { terms, poisson: 0.45, relaxation: Vec::new() }).unwrap();
        assert_eq!((ogden.law.shear_kpa(), ogden.poisson), (3.0, 0.45));
    }

    #[test]
    fn a_depth_to_the_top_and_to_the_centre_mean_the_same_place() {
        let inclusion = |shape, depth_mm, depth_to| {
            let one = Inclusion { shape, depth_mm, depth_to, center_mm: [1.0, -2.0], material: linear() };
            inclusion_shape(&one, &Inputs::default()).unwrap().center_mm
        };
        let sphere = || InclusionBody::Sphere { diameter_mm: 8.0 };
        assert_eq!(inclusion(sphere(), 5.0, DepthTo::Top), [1.0, -2.0, 9.0]);
        assert_eq!(inclusion(sphere(), 9.0, DepthTo::Center), [1.0, -2.0, 9.0]);
        let ellipsoid = InclusionBody::Ellipsoid { semi_axes_mm: [4.0, 3.0, 2.0] };
        assert_eq!(inclusion(ellipsoid, 5.0, DepthTo::Top), [1.0, -2.0, 7.0]);
    }

    #[test]
    fn a_mesh_is_scaled_and_its_top_is_its_lowest_vertex() {
        let octahedron = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 3\nv 0 0 -2\n\
                          f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
        let mut files = Inputs::default();
        files.insert("lump.obj", octahedron.as_bytes());
        let shape = InclusionBody::Mesh { file: "lump.obj".into(), scale: 2.0 };
        let mut one =
            Inclusion { shape, depth_mm: 5.0, depth_to: DepthTo::Top, center_mm: [0.0; 2], material: linear() };
        let lump = inclusion_shape(&one, &files).unwrap();
        assert_eq!(lump.center_mm, [0.0, 0.0, 9.0]);
        let Star::Mesh(mesh) = lump.surface else { panic!("not a mesh") };
        assert_eq!(mesh.vertices[4], [0.0, 0.0, 6.0]);
        one.depth_to = DepthTo::Center;
        assert_eq!(inclusion_shape(&one, &files).unwrap().center_mm[2], 5.0);
        one.shape = InclusionBody::Mesh { file: "none.obj".into(), scale: 1.0 };
        assert_eq!(inclusion_shape(&one, &files).unwrap_err().kind, "io");
    }

    #[test]
    fn every_preset_of_a_phantom_can_be_meshed() {
        let mesh = |phantom: &Phantom, footprint, symmetry| {
            let inclusions =
                phantom.inclusion.iter().map(|one| inclusion_shape(one, &Inputs::default()).unwrap()).collect();
            let shape = phantom_shape(&phantom.shape);
            PhantomMesh {
                shape,
                inclusions,
                footprint,
                symmetry,
                resolution: Resolution::PLANE,
                offset_mm: [0.0; 2],
                layers_mm: Vec::new(),
            }
            .build_2d()
            .unwrap()
        };
        let presses = PRESETS.iter().map(|(name, _)| preset(name).unwrap().scene);
        let presses = presses.filter_map(|scene| Some((scene.phantom?, scene.press?, scene.stack)));
        let meshes: Vec<_> = presses
            .map(|(phantom, press, stack)| mesh(&phantom, footprint(&press.face(&stack)), [true, true]))
            .collect();
        assert_eq!(meshes.len(), 9);
        let scan = scan_preset("frames-galea").unwrap().scene;
        let contact = Footprint::Rectangle { half_widths_mm: [scan.scan.frame_half_width_mm; 2] };
        for mesh in meshes.iter().chain([&mesh(&scan.phantom, contact, [false, false])]) {
            assert!(mesh.region.contains(&0) && mesh.region.contains(&1));
        }
    }

    #[test]
    fn an_indenter_brings_its_footprint_and_elements_that_fit_it() {
        let setup = |change: &dyn Fn(&mut Press)| {
            let mut loaded = preset("phantom-size-8mm").unwrap();
            let press = loaded.scene.press.as_mut().unwrap();
            (press.sensor, press.interface, press.footprint) = (PressedSensor::Rigid, Interface::Frictionless, None);
            press.indenter = Some(Indenter::Round { radius_mm: 10.0 });
            change(press);
            validate(&loaded.scene).unwrap();
            press_setup(&loaded)
        };
        let ball = setup(&|_| ()).unwrap();
        assert!(
            matches!(ball.sensor, SensorBody::Indenter(Profile::Round { radius_mm: 10.0 }))
                && ball.kinematics == Kinematics::Axisymmetric
        );
        // 4 mm deep: 8 mm, a chord of the ball.
        assert!((ball.reach_mm() - 8.0).abs() < 1e-9);
        assert!((ball.phantom.resolution.contact_mm - 8.0 / CURVED_PLANE).abs() < 1e-9);
        let step = |x: f64| PressStep { depth_mm: Some(4.0), slide_mm: Some([x, 0.0]), hold_s: 0.0 };
        let slid = |x: f64| setup(&|press| (press.depths_mm, press.step) = (None, vec![step(x)]));
        let far = slid(5.0).unwrap();
        assert!(far.kinematics == Kinematics::ThreeDimensional && (far.reach_mm() - 13.0).abs() < 1e-9);
        assert!((far.phantom.resolution.contact_mm - 8.0 / CURVED_SOLID).abs() < 1e-9);
        let said = slid(22.5).unwrap_err().to_string();
        assert!(said.contains("press.step") && said.contains("over the phantom's side"), "{said}");
        // A phantom narrower than the ball ends the footprint; a flat one is meshed as a sensor is.
        let wide = setup(&|press| press.indenter = Some(Indenter::Round { radius_mm: 1000.0 })).unwrap();
        assert_eq!(wide.reach_mm(), 30.0);
        let flat = Indenter::RoundedFlat { flat_mm: 4.5, edge_radius_mm: 0.5 };
        let flat = setup(&|press| press.indenter = Some(flat.clone())).unwrap();
        assert_eq!((flat.reach_mm(), flat.body().resolution.rim_mm), (5.0, 0.5));
    }

    #[test]
    fn bodies_and_faces_keep_their_sizes() {
        let cylinder = PhantomBody::Cylinder { radius_mm: 30.0, height_mm: 25.0 };
        assert_eq!(phantom_shape(&cylinder), PhantomShape::Cylinder { radius_mm: 30.0, height_mm: 25.0 });
        let block = PhantomBody::Block { size_mm: [60.0, 40.0], height_mm: 25.0 };
        assert_eq!(phantom_shape(&block), PhantomShape::Block { size_mm: [60.0, 40.0], height_mm: 25.0 });
        assert_eq!(footprint(&FaceOutline::Round { radius_mm: 15.0 }), Footprint::Round { radius_mm: 15.0 });
        let half_widths_mm = [10.0, 20.0];
        assert_eq!(footprint(&FaceOutline::Rectangle { half_widths_mm }), Footprint::Rectangle { half_widths_mm });
    }
}
