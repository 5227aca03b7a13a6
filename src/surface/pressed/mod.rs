//! From a press to interfaces and contact as the tracer sees them.
//!
//! The finite elements' displacement moves every point of an interface along and across the stack; the tracer's height
//! above a place is that of the point that lies there now.

mod sheet;

use super::{ContactMap, HeightField, Profile, Surface, SurfaceError, TissueDisc};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::Footprint;
use crate::mechanics::press::facets::FacetMesh;
use crate::mechanics::press::{ContactPoint, PressStep, Pressed, SensorBody, pressure_facets};
use crate::scene::LoadedScene;
use sheet::Sheet;

/// Shape of all interfaces under a press.
///
/// # Errors
/// When the footprint is too small for a height field.
pub fn pressed_surface(loaded: &LoadedScene, pressed: &Pressed, step: &PressStep) -> Result<Surface, SurfaceError> {
    let (SensorBody::Layers { layers, .. }, [_, sensor]) = (&pressed.setup.sensor, pressed.assembly.bodies.as_slice())
    else {
        return Ok(Surface::Flat);
    };
    let scene = &loaded.scene;
    let points = scene.render.height_field_points as usize;
    let interfaces = scene.stack.layer.len() + 1;
    let footprint = scene.stack.footprint_mm;
    let moved = &step.state.displacement[pressed.assembly.phantom_nodes..];
    let first = interfaces - layers.len();
    let soft_mm = layers.iter().map(|(thickness_mm, _)| thickness_mm).sum();
    let sheet = |i: usize| (i >= first).then(|| Sheet::of_layer(pressed, sensor, moved, (i - first) as u32, soft_mm));
    let round = pressed.setup.kinematics == Kinematics::Axisymmetric;
    let surface = if round {
        let profile = |sheet: Sheet| Profile::sample(points, footprint, [0.0; 2], |r| sheet.height([r, 0.0]));
        every(interfaces, |i| sheet(i).map(profile)).map(Surface::Profiles)
    } else {
        let field = |sheet: Sheet| HeightField::sample(points, footprint, |x, y| sheet.height([x, y]));
        every(interfaces, |i| sheet(i).map(field)).map(Surface::Fields)
    };
    surface.ok_or_else(|| SurfaceError::Shape {
        key: "stack.footprint_mm",
        message: "a height field needs 3 x 3 samples".into(),
    })
}

/// What each interface has, if all that have something have enough samples for it.
fn every<T>(interfaces: usize, of: impl Fn(usize) -> Option<Option<T>>) -> Option<Vec<Option<T>>> {
    (0..interfaces).map(|i| of(i).map_or(Some(None), |sampled| sampled.map(Some))).collect()
}

/// Share of true contact under a press; `None` where the scene has no optical contact.
pub fn pressed_contact(loaded: &LoadedScene, pressed: &Pressed, step: &PressStep) -> Option<ContactMap> {
    let contact = loaded.scene.touch.contact.as_ref()?;
    let footprint = loaded.scene.stack.footprint_mm;
    let (columns, rows, pressures) = pressure_map(pressed, step, footprint, super::contact::SHARE_CELLS);
    Some(ContactMap {
        columns,
        rows,
        share: pressures.iter().map(|&p| contact.law.share(p)).collect(),
        uniform: 0.0,
        disc: match pressed.setup.phantom.footprint {
            Footprint::Round { radius_mm } => Some(TissueDisc { center_mm: [0.0; 2], radius_mm }),
            Footprint::Rectangle { .. } => None,
        },
    })
}

/// Contact pressure at the middles of cells over a rectangle about the axis, kPa: columns, rows, values, row 0 at
/// negative y. `cells` lie along the longer side.
pub fn pressure_map(pressed: &Pressed, step: &PressStep, size_mm: [f64; 2], cells: usize) -> (usize, usize, Vec<f64>) {
    let pressure = pressure_at(pressed, step);
    super::contact::sample(size_mm, cells, |x, y| pressure([x, y]))
}

/// Contact pressure at a place (x, y) over the touched face, mm, as a function: kPa, 0 off the face.
pub fn pressure_at(pressed: &Pressed, step: &PressStep) -> impl Fn([f64; 2]) -> f64 {
    let up = pressed.setup.kinematics.dim() - 1;
    let place = |point: &ContactPoint| {
        let [x, y] = [0, 1].map(|i| point.reference_mm[i] + point.displacement_mm[i]);
        [x, if up == 2 { y } else { 0.0 }]
    };
    let facets = pressure_facets(&pressed.assembly.problem.contacts[0], &step.points, place);
    let face = FacetMesh::of(pressed, facets);
    move |at| face.between_nodes(face.meshed(at)).map_or(0.0, |pressure| pressure.max(0.0))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mechanics::from_scene::press_setup;
    use crate::mechanics::press::{PressSettings, press};
    use crate::scene::{Dimensions, Elastic};

    #[test]
    fn slopes_of_a_pressed_phantom_do_not_depend_on_the_number_of_points() {
        let mut loaded = crate::scene::preset("phantom-size-8mm").unwrap();
        loaded.scene.press.as_mut().unwrap().depths_mm = Some(vec![2.0]);
        let setup = press_setup(&loaded).unwrap();
        let pressed = press(&setup, PressSettings::default(), &mut |_| true).unwrap();
        let mut surface = |points| {
            loaded.scene.render.height_field_points = points;
            pressed_surface(&loaded, &pressed, pressed.steps.last().unwrap()).unwrap()
        };
        let (default, finer) = (surface(256), surface(512));
        for interface in 2..=4 {
            let (coarse, fine) = (default.relief(interface).unwrap(), finer.relief(interface).unwrap());
            let off = |range: std::ops::Range<u32>| {
                let places = range.map(|k| 0.01 * f64::from(k));
                places.map(|r| (coarse.at(r, 0.0)[1] - fine.at(r, 0.0)[1]).abs()).fold(0.0, f64::max)
            };
            // Slopes are about 0.015. At the outline interfaces bend most, by 0.1 per mm; samples are 0.06 and 0.12 mm
            // apart.
            let [within, edge] = [off(0..1300), off(1300..2120)];
            assert!(within < 1e-5 && edge < 0.01, "{within}, {edge}");
            // Of the singular edge, 0.6 steep in these elements, nothing is seen.
            assert!(fine.steepest() < 0.15, "{}", fine.steepest());
        }
        // Where nothing is pressed nothing moves: the two faces of the glass.
        assert!(default.relief(0).is_none() && default.relief(1).is_none());
    }

    #[test]
    fn a_press_in_three_dimensions_bends_the_face_as_its_axisymmetric_sibling_out_to_the_rim() {
        let mut loaded = crate::scene::preset("phantom-size-8mm").unwrap();
        let mut face = |dimensions, ring_share: Option<f64>| {
            let press_of = loaded.scene.press.as_mut().unwrap();
            (press_of.dimensions, press_of.depths_mm) = (dimensions, Some(vec![2.0]));
            let mut setup = press_setup(&loaded).unwrap();
            let size = &mut setup.phantom.resolution;
            size.ring_share = ring_share.unwrap_or(size.ring_share);
            let pressed =
                press(&setup, PressSettings { estimate_error: false, ..Default::default() }, &mut |_| true).unwrap();
            pressed_surface(&loaded, &pressed, pressed.steps.last().unwrap()).unwrap()
        };
        let plane = face(Dimensions::Two, None);
        let mut off = |ring_share| {
            let solid = face(Dimensions::Three, ring_share);
            let (solid, plane) = (solid.relief(4).unwrap(), plane.relief(4).unwrap());
            let squares = (0..140).map(|k| {
                let r = 0.1 * f64::from(k) + 0.05;
                (0..4).map(move |turn| {
                    let (sin, cos) = (0.1 + 0.4 * f64::from(turn)).sin_cos();
                    let [_, x, y] = solid.at(r * cos, r * sin);
                    (x * cos + y * sin - plane.at(r, 0.0)[1]).powi(2)
                })
            });
            (squares.flatten().sum::<f64>() / 560.0).sqrt()
        };
        let (default, wide) = (off(None), off(Some(1.0)));
        println!("slopes differ by {default:.6}, with rings as wide as they are high by {wide:.6}");
        assert!(default < 3e-4 && wide > 2.0 * default, "{default}, {wide}");
    }

    #[test]
    fn the_slope_at_the_outline_under_soft_tissue_is_that_of_a_finer_mesh() {
        let mut loaded = crate::scene::preset("phantom-size-8mm").unwrap();
        loaded.scene.press.as_mut().unwrap().depths_mm = Some(vec![2.0]);
        loaded.scene.phantom.as_mut().unwrap().material =
            Elastic::NeoHookean { youngs_kpa: 3.0, poisson: 0.4999, relaxation: Vec::new() };
        let mut slope = |resolution, ring_share: Option<f64>| {
            loaded.scene.press.as_mut().unwrap().resolution = resolution;
            let mut setup = press_setup(&loaded).unwrap();
            let size = &mut setup.phantom.resolution;
            size.ring_share = ring_share.unwrap_or(size.ring_share);
            let pressed = press(&setup, PressSettings::default(), &mut |_| true).unwrap();
            let surface = pressed_surface(&loaded, &pressed, pressed.steps.last().unwrap()).unwrap();
            surface.relief(4).unwrap().at(15.0, 0.0)[1]
        };
        let fine = slope(2.0, None);
        let [default, wide] = [None, Some(1.0)].map(|share| slope(1.0, share) / fine - 1.0);
        println!("slope {fine:.5}, off by {default:.4}, where elements are as wide as high by {wide:.4}");
        assert!(default.abs() < 0.01 && wide.abs() > 0.05, "{default}, {wide}");
    }

    #[test]
    fn the_slope_at_the_outline_does_not_follow_the_elements_that_pass_it() {
        let mut loaded = crate::scene::preset("phantom-size-8mm").unwrap();
        let depths = [1.5, 1.75, 2.0, 2.25, 2.5];
        loaded.scene.press.as_mut().unwrap().depths_mm = Some(depths.to_vec());
        let setup = press_setup(&loaded).unwrap();
        let pressed = press(&setup, PressSettings::default(), &mut |_| true).unwrap();
        // The tissue bulges, and its singular edge with it, by an element of 0.15 mm over these depths.
        let per_depth: Vec<f64> = pressed
            .steps
            .iter()
            .map(|step| {
                let surface = pressed_surface(&loaded, &pressed, step).unwrap();
                surface.relief(4).unwrap().at(15.0, 0.0)[1] / step.depth_mm
            })
            .collect();
        for three in per_depth.windows(3) {
            let bend = (three[0] - 2.0 * three[1] + three[2]) / three[1];
            assert!(bend.abs() < 0.02, "{bend} of {per_depth:?}");
        }
    }
}
