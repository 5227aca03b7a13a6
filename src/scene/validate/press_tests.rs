#![allow(clippy::unwrap_used)]
use super::*;
use crate::scene::bad_scenes::{Bad, bad, check, check_scan, rule, text_of};
use crate::scene::{
    DepthTo, Dimensions, FaceOutline, Inclusion, InclusionBody, Indenter, Interface, PhantomLayer, Press, PressStep,
    Scene, parse, preset, scan_preset,
};
use std::path::Path;

/// The preset that the cases change: a sphere of 8 mm, 5 mm deep.
const SCENE: &str = "phantom-size-8mm";
const SPHERE: &str = "shape = { kind = \"sphere\", diameter_mm = 8.0 }\ndepth_mm = 5.0\n";
const TO_TOP: &str = "depth_to = \"top\" ";
const BACKGROUND: &str = "{ law = \"neo_hookean\", youngs_kpa = 5.0 }";
const DEPTHS: &str = "depths_mm = [1.0, 2.0, 4.0]";

fn scan_rule(from: &'static str, to: &'static str, key: &'static str, says: &'static str) -> Bad {
    rule("frames-galea", from, to, key, says)
}

fn press_rule(from: &'static str, to: &'static str, key: &'static str, says: &'static str) -> Bad {
    rule(SCENE, from, to, key, says)
}

const LAYER: &str = "[[phantom.layer]]\nthickness_mm = 2\nmaterial = { law = \"linear\", youngs_kpa = 50 }\n[press]\n";

/// A scene with layers, wrong in one way.
fn layer_rule(from: &str, to: &str, key: &'static str, says: &'static str) -> Bad {
    let text: &'static str = LAYER.replace(from, to).leak();
    press_rule("[press]\n", text, key, says)
}

#[test]
fn steps_go_somewhere_above_the_base_and_below_the_phantom() {
    let mut scene = crate::scene::preset("phantom-size-8mm").unwrap().scene;
    let press = scene.press.as_mut().unwrap();
    let step = PressStep { depth_mm: Some(2.0), ..PressStep::default() };
    press.step = vec![step];
    assert_eq!(validate(&scene).unwrap_err().key, "press.step");
    let key = |scene: &mut Scene, steps: Vec<PressStep>| {
        let press = scene.press.as_mut().unwrap();
        (press.depths_mm, press.step) = (None, steps);
        validate(scene).map_err(|error| (error.key, error.message))
    };
    let wrong = |scene: &mut Scene, step: PressStep, at: &str, says: &str| {
        let (found, message) =
            key(scene, vec![PressStep { depth_mm: Some(1.0), ..PressStep::default() }, step]).unwrap_err();
        assert!(found == at && message.contains(says), "{found}: {message}");
    };
    let none = PressStep::default();
    wrong(&mut scene, PressStep { depth_mm: Some(25.0), ..none }, "press.step[1].depth_mm", "below 25");
    wrong(&mut scene, PressStep { depth_mm: Some(-0.1), ..none }, "press.step[1].depth_mm", "at least 0");
    wrong(&mut scene, none, "press.step[1]", "changes nothing");
    wrong(&mut scene, PressStep { hold_s: 3.0, ..none }, "press.step[1].hold_s", "rate_mm_per_s");
    let far = PressStep { slide_mm: Some([0.0, 16.0]), ..none };
    wrong(&mut scene, far, "press.step[1].slide_mm", "over the phantom's side");
    let slid = PressStep { slide_mm: Some([0.0, 3.0]), ..none };
    assert_eq!(key(&mut scene, vec![step, slid, PressStep { depth_mm: Some(0.0), ..none }]), Ok(()));
    scene.press.as_mut().unwrap().dimensions = Dimensions::Two;
    let error = validate(&scene).unwrap_err();
    assert!(error.key == "press.dimensions" && error.message.contains("press.step slides"), "{}", error.message);
    let press = scene.press.as_mut().unwrap();
    (press.dimensions, press.tilt_deg) = (Dimensions::Auto, [1.0, 0.0]);
    assert_eq!(validate(&scene).unwrap_err().key, "press.tilt_deg");
}

#[test]
fn layers_fit_the_phantom_and_no_inclusion_crosses_them() {
    let two =
        "thickness_mm = 20\nmaterial = { law = \"linear\", youngs_kpa = 5 }\n[[phantom.layer]]\nthickness_mm = 5 #!";
    let wrong = [
        layer_rule("= 2", "= 0 #!", "phantom.layer[0].thickness_mm", "at least 0.001"),
        layer_rule("= 2", "= 25 #!", "phantom.layer[0].thickness_mm", "below 25"),
        layer_rule("thickness_mm = 2", two, "phantom.layer[1].thickness_mm", "no room for its own material"),
        layer_rule("= 50 }", "= 0 } #!", "phantom.layer[0].material.youngs_kpa", "positive"),
    ];
    wrong.iter().for_each(check);
    let mut scene = crate::scene::preset("phantom-size-8mm").unwrap().scene;
    let phantom = scene.phantom.as_mut().unwrap();
    let material = phantom.material.clone();
    phantom.layer = [4.9, 8.2].map(|thickness_mm| PhantomLayer { thickness_mm, material: material.clone() }).to_vec();
    assert!(validate(&scene).is_ok());
    // The sphere of 8 mm lies from 5 to 13 mm deep.
    for thickness in [[5.1, 8.0], [4.9, 8.0], [9.0, 9.0], [4.985, 8.2], [4.9, 8.11]] {
        let phantom = scene.phantom.as_mut().unwrap();
        phantom.layer.iter_mut().zip(thickness).for_each(|(layer, mm)| layer.thickness_mm = mm);
        let error = validate(&scene).unwrap_err();
        assert_eq!(error.key, "phantom.inclusion[0].depth_mm");
        assert!(error.message.contains("an inclusion lies in one layer"), "{}", error.message);
    }
}

#[test]
fn the_rules_of_phantoms_hold() {
    let cylinder = "{ kind = \"cylinder\", radius_mm = 30.0, height_mm = 25.0 }";
    let second = "[press]\n";
    #[rustfmt::skip]
    let wrong = [
        press_rule(cylinder, "{ kind = \"cylinder\", radius_mm = 0, height_mm = 25.0 } #!", "phantom.shape.radius_mm", "positive"),
        press_rule(cylinder, "{ kind = \"cylinder\", radius_mm = 30, height_mm = -1 } #!", "phantom.shape.height_mm", "positive"),
        press_rule(cylinder, "{ kind = \"block\", size_mm = [60, 1e9], height_mm = 25 } #!", "phantom.shape.size_mm[1]", "at most 1000"),
        press_rule(SPHERE, "shape = { kind = \"sphere\", diameter_mm = 0 } #!\ndepth_mm = 5\n", "phantom.inclusion[0].shape.diameter_mm", "positive"),
        press_rule(SPHERE, "shape = { kind = \"ellipsoid\", semi_axes_mm = [1, -1, 1] } #!\ndepth_mm = 5\n", "phantom.inclusion[0].shape.semi_axes_mm[1]", "positive"),
        press_rule(SPHERE, "shape = { kind = \"mesh\", file = \"a.gltf\" } #!\ndepth_mm = 5\n", "phantom.inclusion[0].shape.file", ".obj or .stl or .ply"),
        press_rule(SPHERE, "shape = { kind = \"mesh\", file = \"a.stl\", scale = 0 } #!\ndepth_mm = 5\n", "phantom.inclusion[0].shape.scale", "positive"),
        press_rule(SPHERE, "shape = { kind = \"sphere\", diameter_mm = 8 }\ndepth_mm = -0.5 #!\n", "phantom.inclusion[0].depth_mm", "at least 0"),
        press_rule(SPHERE, "shape = { kind = \"sphere\", diameter_mm = 8 }\ndepth_mm = 18 #!\n", "phantom.inclusion[0].depth_mm", "sticks out of the base by 1 mm: depth to top 18 mm and height 8 mm are more than the phantom's height 25 mm"),
        press_rule(SPHERE, "shape = { kind = \"sphere\", diameter_mm = 8 }\ncenter_mm = [20, -20] #!\ndepth_mm = 5\n", "phantom.inclusion[0].center_mm", "sticks out of the phantom's side by 2.28"),
        press_rule(second, "[[phantom.inclusion]] #!\nshape = { kind = \"sphere\", diameter_mm = 2 }\ndepth_mm = 5\ncenter_mm = [3.5, 0]\nmaterial = { law = \"linear\", youngs_kpa = 1 }\n[press]\n", "phantom.inclusion[1]", "overlaps phantom.inclusion[0]"),
    ];
    wrong.iter().for_each(check);
}

#[test]
fn an_inclusion_that_sticks_out_is_refused_with_its_numbers() {
    let text =
        text_of(SCENE).replace("diameter_mm = 8.0", "diameter_mm = 14.0").replace(TO_TOP, "depth_to = \"center\" ");
    let error = parse(&text, Path::new("s.toml")).unwrap_err();
    assert_eq!(error.key.as_deref(), Some("phantom.inclusion[0].depth_mm"));
    assert_eq!(
        error.message,
        "the inclusion sticks out of the touched face by 2 mm: depth to centre 5 mm is less than its half height 7 mm"
    );
}

#[test]
fn inclusions_may_touch_faces_and_each_other_but_not_overlap() {
    let mut scene = preset(SCENE).unwrap().scene;
    let phantom = scene.phantom.as_mut().unwrap();
    let material = phantom.material.clone();
    let one = |center_mm, semi_axes_mm: [f64; 3], depth_mm| Inclusion {
        shape: InclusionBody::Ellipsoid { semi_axes_mm },
        depth_mm,
        depth_to: DepthTo::Center,
        center_mm,
        material: material.clone(),
    };
    phantom.inclusion = vec![one([0.0; 2], [4.0, 2.0, 3.0], 3.0), one([6.0, 0.0], [2.0, 9.0, 3.0], 3.0)];
    assert_eq!(validate(&scene), Ok(()));
    let third = |center_mm| {
        let mut scene = scene.clone();
        scene.phantom.as_mut().unwrap().inclusion.push(one(center_mm, [1.0; 3], 24.0));
        validate(&scene).map_err(|broken| broken.key)
    };
    assert_eq!(third([29.0, 0.0]), Ok(()));
    assert_eq!(third([29.01, 0.0]), Err("phantom.inclusion[2].center_mm".to_owned()));
    scene.phantom.as_mut().unwrap().inclusion[1].center_mm[0] = 5.99;
    assert_eq!(validate(&scene).unwrap_err().key, "phantom.inclusion[1]");
    // Their boxes overlap, they do not.
    scene.phantom.as_mut().unwrap().inclusion = vec![one([0.0; 2], [3.0; 3], 5.0), one([4.5, 4.5], [3.0; 3], 5.0)];
    assert_eq!(validate(&scene), Ok(()));
}

#[test]
fn the_rules_of_elastic_laws_hold() {
    #[rustfmt::skip]
    let wrong = [
        press_rule(BACKGROUND, "{ law = \"linear\", youngs_kpa = 0 } #!", "phantom.material.youngs_kpa", "positive"),
        press_rule(BACKGROUND, "{ law = \"linear\", youngs_kpa = 5, poisson = 0.51 } #!", "phantom.material.poisson", "at least 0 and at most 0.5"),
        press_rule(BACKGROUND, "{ law = \"linear\", youngs_kpa = 5, poisson = -0.1 } #!", "phantom.material.poisson", "at least 0"),
        press_rule(BACKGROUND, "{ law = \"yeoh\", c_kpa = [0, 1, 1] } #!", "phantom.material.c_kpa[0]", "positive"),
        press_rule(BACKGROUND, "{ law = \"yeoh\", c_kpa = [0.6, -1.1, 1] } #!", "phantom.material.c_kpa[1]", "must be above -1 beside c1 = 0.6 and c3 = 1"),
        press_rule(BACKGROUND, "{ law = \"yeoh\", c_kpa = [1, 1, -1] } #!", "phantom.material.c_kpa[2]", "at least 0"),
        press_rule(BACKGROUND, "{ law = \"ogden\", terms = [] } #!", "phantom.material.terms", "from 1 to 16 terms, has 0"),
        press_rule(BACKGROUND, "{ law = \"ogden\", terms = [{ shear_kpa = 1, exponent = -2 }] } #!", "phantom.material.terms[0].shear_kpa", "of the sign of the exponent -2"),
        press_rule(BACKGROUND, "{ law = \"exponential\", modulus_kpa = 0, exponent = 9 } #!", "phantom.material.modulus_kpa", "positive"),
        press_rule(BACKGROUND, "{ law = \"exponential\", modulus_kpa = 4, exponent = 0 } #!", "phantom.material.exponent", "positive"),
        press_rule(BACKGROUND, "{ law = \"linear\", youngs_kpa = 5, relaxation = [{ share = 1, time_s = 1 }] } #!", "phantom.material.relaxation[0].share", "below 1"),
        press_rule(BACKGROUND, "{ law = \"linear\", youngs_kpa = 5, relaxation = [{ share = 0.5, time_s = 0 }] } #!", "phantom.material.relaxation[0].time_s", "positive"),
        press_rule(BACKGROUND, "{ law = \"linear\", youngs_kpa = 5, relaxation = [{ share = 0.5, time_s = 1 }, { share = 0.5, time_s = 9 }] } #!", "phantom.material.relaxation", "add up to 1"),
        bad(SCENE, BACKGROUND, "{ law = \"linear\", youngs_kpa = 5, c_kpa = [1, 0, 0] } #!", "unknown_key", "phantom.material.c_kpa", "the keys here are law, poisson, relaxation, youngs_kpa"),
        press_rule(BACKGROUND, "{ law = \"neohookean\", youngs_kpa = 5 } #!", "phantom.material.law", "did you mean neo_hookean?"),
        bad(SCENE, BACKGROUND, "{ youngs_kpa = 5 } #!", "missing_key", "phantom.material.law", "give one of \"linear\", \"neo_hookean\", \"yeoh\""),
        bad(SCENE, BACKGROUND, "5.0 #!", "wrong_type", "phantom.material", "must be a table with a law"),
        bad(SCENE, BACKGROUND, "{ law = \"linear\" } #!", "missing_key", "phantom.material.youngs_kpa", "give a number (Young's modulus, kPa)"),
        bad(SCENE, BACKGROUND, "{ law = \"linear\", youngs_kpa = 5, relaxation = [{ share = 0.1, time_s = 1, g = 1 }] } #!", "unknown_key", "phantom.material.relaxation[0].g", "share, time_s"),
    ];
    wrong.iter().for_each(check);
}

#[test]
fn rigid_layers_lie_lowest() {
    let mut scene = preset(SCENE).unwrap().scene;
    let elastic = scene.stack.layer[0].elastic.clone();
    scene.stack.layer[3].elastic = elastic.clone();
    assert_eq!(validate(&scene), Ok(()));
    scene.stack.layer[1].elastic = None;
    let broken = validate(&scene).unwrap_err();
    assert_eq!(broken.key, "stack.layer[2].elastic");
    assert!(broken.message.contains("below stack.layer[1], which is rigid"), "{broken}");
    scene.stack.layer.iter_mut().for_each(|layer| layer.elastic = None);
    assert_eq!(validate(&scene).unwrap_err().key, "press.sensor");
    scene.press.as_mut().unwrap().sensor = PressedSensor::Rigid;
    assert_eq!(validate(&scene), Ok(()));
    scene.stack.layer[0].elastic = elastic;
    let text = text_of(SCENE).replacen("youngs_kpa = 60.0", "youngs_kpa = 0.0", 1);
    let error = parse(&text, Path::new("s.toml")).unwrap_err();
    assert_eq!(error.key.as_deref(), Some("stack.layer[0].elastic.youngs_kpa"));
}

#[test]
fn the_rules_of_presses_hold() {
    let footprint = "footprint = { kind = \"round\", radius_mm = 15.0 }";
    let tied = "interface = { kind = \"tied\" }";
    let sensor = "sensor = \"deformable\"";
    let contact = "[touch.contact]\npressure = { kind = \"press\" }";
    #[rustfmt::skip]
    let wrong = [
        press_rule(DEPTHS, "depths_mm = [1, 1] #!", "press.depths_mm[1]", "must ascend, is 1 after 1"),
        press_rule(DEPTHS, "depths_mm = [0, 1] #!", "press.depths_mm[0]", "positive"),
        press_rule(DEPTHS, "depths_mm = [] #!", "press.depths_mm", "from 1 to 100 values, has 0"),
        press_rule(DEPTHS, "depths_mm = [25] #!", "press.depths_mm", "below the phantom's height of 25, reach 25"),
        press_rule(DEPTHS, "depths_mm = [1]\nforces_n = [1] #!", "press.forces_n", "not both"),
        press_rule(DEPTHS, "forces_n = [1, 0.5] #!", "press.forces_n[1]", "must ascend"),
        press_rule(DEPTHS, "forces_n = [1]\nrate_mm_per_s = 1 #!", "press.rate_mm_per_s", "goes with depths_mm"),
        press_rule(DEPTHS, "depths_mm = [1]\nrate_mm_per_s = 0 #!", "press.rate_mm_per_s", "positive"),
        press_rule(DEPTHS, "depths_mm = [1]\nhold_s = 5 #!", "press.hold_s", "nothing is left to relax"),
        press_rule(DEPTHS, "depths_mm = [1]\nhold_s = -5 #!", "press.hold_s", "at least 0"),
        press_rule(DEPTHS, "depths_mm = [1]\ntilt_deg = [0, 16] #!", "press.tilt_deg[1]", "at most 15"),
        press_rule(DEPTHS, "forces_n = [1]\ntilt_deg = [1, 0] #!", "press.tilt_deg", "give depths_mm, not forces_n"),
        press_rule(DEPTHS, "depths_mm = [1]\noffset_mm = [9, 12.1] #!", "press.offset_mm", "over the phantom's side at 30 mm"),
        press_rule(DEPTHS, "depths_mm = [1]\ndimensions = \"two\" #!\ntilt_deg = [1, 0]", "press.dimensions", "press.tilt_deg tilts the phantom"),
        press_rule(DEPTHS, "depths_mm = [1]\nresolution = 0.1 #!", "press.resolution", "at least 0.25"),
        press_rule(footprint, "footprint = { kind = \"round\", radius_mm = 15.1 } #!", "press.footprint.radius_mm", "at most 15 to lie within stack.footprint_mm"),
        press_rule(footprint, "footprint = { kind = \"rectangle\", half_widths_mm = [15, 0] } #!", "press.footprint.half_widths_mm[1]", "positive"),
        press_rule(tied, "interface = { kind = \"coulomb\", friction = 0 } #!", "press.interface.friction", "positive"),
        press_rule(DEPTHS, "depths_mm = [1]\nedge_radius_mm = -0.1 #!", "press.edge_radius_mm", "at least 0"),
        bad(SCENE, sensor, "sensor = \"soft\" #!", "invalid_value", "press.sensor", "\"deformable\", \"rigid\""),
        press_rule(contact, "[touch.contact]\npressure = { kind = \"disc\", radius_mm = 4, pressure_kpa = 1 } #!", "touch.contact.pressure", "use pressure = { kind = \"press\" }"),
        press_rule(contact, "[touch]\nshape = { kind = \"gaussian_dent\", depth_mm = 1, sigma_mm = 2 } #!\n[touch.contact]\npressure = { kind = \"press\" }", "touch.shape", "the press gives the shape"),
        press_rule(contact, "[touch]\ninner = \"flat\" #!\n[touch.contact]\npressure = { kind = \"press\" }", "touch.inner", "the press moves the inner"),
        press_rule(contact, "[render]\nintegrator = \"splat\" #!\n[touch.contact]\npressure = { kind = \"press\" }", "render.integrator", "the press deforms it"),
        rule("contact-disc", "{ kind = \"disc\", radius_mm = 4.0, pressure_kpa = 1.0 }", "{ kind = \"press\" } #!", "touch.contact.pressure", "needs a [press]"),
    ];
    wrong.iter().for_each(check);
}

#[test]
fn the_touched_face_lies_under_the_phantom() {
    let cylinder = "{ kind = \"cylinder\", radius_mm = 30.0, height_mm = 25.0 }";
    for (body, footprint, says) in [
        (
            "{ kind = \"cylinder\", radius_mm = 14, height_mm = 25 }",
            "radius_mm = 15.0",
            "reaches 15 mm from the axis, over the phantom's side at 14 mm",
        ),
        (
            "{ kind = \"block\", size_mm = [60, 29], height_mm = 25 }",
            "radius_mm = 15.0",
            "reaches 15 mm from the axis, over the phantom's side at 14.5 mm",
        ),
        ("{ kind = \"cylinder\", radius_mm = 20, height_mm = 25 }", "rectangle", "reaches 21.2"),
    ] {
        let mut text = text_of(SCENE).replace(cylinder, body);
        if footprint == "rectangle" {
            text = text.replace("footprint = { kind = \"round\", radius_mm = 15.0 }\n", "");
        }
        let error = parse(&text, Path::new("s.toml")).unwrap_err();
        assert_eq!(error.key.as_deref(), Some("press.footprint"), "{error}");
        assert!(error.message.contains(says), "{error}");
    }
}

#[test]
fn a_press_needs_a_phantom_and_a_phantom_a_press() {
    let mut scene = preset(SCENE).unwrap().scene;
    let press = scene.press.take();
    assert_eq!(validate(&scene).unwrap_err().key, "phantom");
    scene.phantom = None;
    assert_eq!(validate(&scene).unwrap_err().key, "touch.contact.pressure");
    scene.press = press;
    assert_eq!(validate(&scene).unwrap_err().key, "press");
}

#[test]
fn two_dimensions_need_bodies_of_revolution() {
    let scene = preset(SCENE).unwrap().scene;
    let refused = |change: fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        assert_eq!(validate(&scene), Ok(()));
        scene.press.as_mut().unwrap().dimensions = Dimensions::Two;
        let broken = validate(&scene).unwrap_err();
        assert_eq!(broken.key, "press.dimensions");
        broken.message
    };
    let square = refused(|scene| scene.press.as_mut().unwrap().footprint = None);
    assert!(square.contains("the touched face is a rectangle"), "{square}");
    let off_axis = refused(|scene| scene.phantom.as_mut().unwrap().inclusion[0].center_mm[1] = 1.0);
    assert!(off_axis.contains("phantom.inclusion[0] is off the axis"), "{off_axis}");
    let mut round = scene.clone();
    round.press.as_mut().unwrap().dimensions = Dimensions::Two;
    assert_eq!(validate(&round), Ok(()));
}

#[test]
fn a_rim_fits_the_face_and_the_layer_that_carries_it() {
    let rim = |edge_radius_mm, sensor, interface| {
        let mut scene = preset(SCENE).unwrap().scene;
        let press = scene.press.as_mut().unwrap();
        (press.edge_radius_mm, press.sensor, press.interface) = (edge_radius_mm, sensor, interface);
        let radius = press.clone().edge_radius_mm(&scene.stack);
        validate(&scene).map(|()| radius).map_err(|broken| {
            assert_eq!(broken.key, "press.edge_radius_mm");
            broken.message
        })
    };
    let (soft, rigid) = (PressedSensor::Deformable, PressedSensor::Rigid);
    assert_eq!(rim(None, soft, Interface::Tied), Ok(0.0));
    assert_eq!(rim(None, soft, Interface::Coulomb { friction: 0.2 }), Ok(0.5));
    assert_eq!(rim(None, rigid, Interface::Frictionless), Ok(0.5));
    assert_eq!(rim(Some(0.0), soft, Interface::Frictionless), Ok(0.0));
    assert_eq!(rim(Some(2.0), soft, Interface::Tied), Ok(2.0));
    assert_eq!(rim(Some(5.0), rigid, Interface::Frictionless), Ok(5.0));
    let refused = |radius, sensor, words: &str| {
        let message = rim(Some(radius), sensor, Interface::Frictionless).unwrap_err();
        assert!(message.contains(words), "{message}");
    };
    refused(2.1, soft, "at most 2, the thickness of the topmost soft layer, is 2.1");
    refused(5.1, rigid, "at most 5.000, a third of the touched face's half width, is 5.1");
    refused(0.0, rigid, "positive");
}

/// A press by a rigid ball of 6 mm without friction, by 1 mm.
fn by_ball() -> Scene {
    let mut scene = preset(SCENE).unwrap().scene;
    let press = scene.press.as_mut().unwrap();
    (press.depths_mm, press.footprint, press.interface) = (Some(vec![1.0]), None, Interface::Frictionless);
    (press.sensor, press.indenter) = (PressedSensor::Rigid, Some(Indenter::Round { radius_mm: 6.0 }));
    scene
}

#[test]
fn an_indenter_is_rigid_slides_and_shows_where_it_touches() {
    assert_eq!(validate(&by_ball()), Ok(()));
    let (round, rectangle) =
        (FaceOutline::Round { radius_mm: 4.0 }, FaceOutline::Rectangle { half_widths_mm: [4.0; 2] });
    let step = |depth_mm: f64, x: f64| PressStep { depth_mm: Some(depth_mm), slide_mm: Some([x, 0.0]), hold_s: 0.0 };
    let flat = |edge_radius_mm| Some(Indenter::RoundedFlat { flat_mm: 4.0, edge_radius_mm });
    let table = |file: &str| Some(Indenter::Table { file: file.into() });
    type Change<'a> = dyn Fn(&mut Press) + 'a;
    let wrong: [(&str, &str, &Change<'_>); 11] = [
        ("press.indenter", "add sensor = \"rigid\"", &|press| press.sensor = PressedSensor::Deformable),
        ("press.indenter.radius_mm", "positive", &|press| press.indenter = Some(Indenter::Round { radius_mm: 0.0 })),
        ("press.indenter.file", "must end in .csv", &|press| press.indenter = table("a.xls")),
        ("press.interface", "take frictionless or coulomb", &|press| press.interface = Interface::Tied),
        ("press.edge_radius_mm", "leave it out", &|press| press.edge_radius_mm = Some(0.5)),
        ("press.footprint", "is round", &|press| press.footprint = Some(rectangle)),
        ("press.depths_mm[1]", "radius of 6, is 6.5", &|press| press.depths_mm = Some(vec![1.0, 6.5])),
        ("press.step[0].depth_mm", "radius of 6, is 7", &|press| {
            (press.depths_mm, press.step) = (None, vec![step(7.0, 0.0)])
        }),
        ("press.step[1].slide_mm", "over the phantom's side", &|press| {
            (press.depths_mm, press.step) = (None, vec![step(1.0, 0.0), step(1.0, 30.5)])
        }),
        ("press.forces_n", "give footprint", &|press| {
            (press.depths_mm, press.forces_n) = (None, Some(vec![0.1]));
            press.indenter = flat(2.1);
        }),
        ("press.dimensions", "off the axis", &|press| {
            (press.offset_mm, press.dimensions) = ([1.0, 0.0], Dimensions::Two)
        }),
    ];
    for (key, says, change) in wrong {
        let mut scene = by_ball();
        change(scene.press.as_mut().unwrap());
        let error = validate(&scene).unwrap_err();
        assert!(error.key == key && error.message.contains(says) && error.others.is_empty(), "{key}: {error:?}");
    }
    // A footprint that is given, or that of a flat face, serves forces.
    for (footprint, indenter) in [(Some(round), flat(2.1)), (None, flat(2.0))] {
        let mut scene = by_ball();
        let press = scene.press.as_mut().unwrap();
        (press.depths_mm, press.forces_n, press.footprint, press.indenter) =
            (None, Some(vec![0.1]), footprint, indenter);
        assert_eq!(validate(&scene), Ok(()));
    }
}

#[test]
fn the_rules_of_scans_hold() {
    let round = "{ kind = \"round\", radius_mm = 20.0 }";
    let positions = "{ from = -20.0, to = 20.0, count = 41 }";
    let block = "{ kind = \"block\", size_mm = [260.0, 260.0], height_mm = 25.0 }";
    #[rustfmt::skip]
    let wrong = [
        scan_rule(round, "{ kind = \"round\", radius_mm = 0 } #!", "scan.indenter.radius_mm", "positive"),
        scan_rule(round, "{ kind = \"rounded_flat\", flat_mm = -1, edge_radius_mm = 1 } #!", "scan.indenter.flat_mm", "at least 0"),
        scan_rule(round, "{ kind = \"rounded_flat\", flat_mm = 1, edge_radius_mm = 0 } #!", "scan.indenter.edge_radius_mm", "positive"),
        scan_rule(round, "{ kind = \"table\", file = \"a.xls\" } #!", "scan.indenter.file", "must end in .csv"),
        scan_rule("depth_mm = 5.0\npos", "depth_mm = 25 #!\npos", "scan.depth_mm", "below the tissue's height of 25"),
        scan_rule("depth_mm = 5.0\npos", "depth_mm = 20 #!\npos", "scan.depth_mm", "below the indenter's radius of 20"),
        scan_rule(positions, "{ from = 20, to = 20, count = 41 } #!", "scan.positions_mm.to", "above from (20), is 20"),
        scan_rule(positions, "{ from = -20, to = 20, count = 1 } #!", "scan.positions_mm.count", "from 2 to 1000"),
        scan_rule("= 16.0 ", "= 110.5 #!", "scan.frame_half_width_mm", "reaches 130.5 mm from the middle, over the tissue's side at 130 mm"),
        scan_rule("= 129", "= 4 #!", "scan.frame_points", "from 5 to 10000"),
        scan_rule("window_mm = 10.0 ", "window_mm = 16.5 #!", "scan.window_mm", "at most 16"),
        scan_rule("\"frictionless\" }", "\"coulomb\", friction = -1 } #!", "scan.interface.friction", "positive"),
        scan_rule("\"frictionless\" }", "\"tied\" } #!", "scan.interface", "take frictionless or coulomb"),
        scan_rule(block, "{ kind = \"cylinder\", radius_mm = 130, height_mm = 25.0 } #!", "phantom.shape.kind", "needs a block"),
        scan_rule("depth_to = \"top\"", "center_mm = [0, 1] #!", "phantom.inclusion[0].center_mm[1]", "at most 0"),
        bad("frames-galea", "[scan]", "[led] #!\n[scan]", "unknown_key", "led", "the keys here are description, name, phantom, scan"),
    ];
    wrong.iter().for_each(check_scan);
}

#[test]
fn the_positions_of_a_scan_include_both_ends() {
    let positions = scan_preset("frames-galea").unwrap().scene.scan.positions_mm.all_mm();
    assert_eq!((positions.len(), positions[0], positions[20], positions[40]), (41, -20.0, 0.0, 20.0));
}
