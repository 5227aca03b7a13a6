//! Rays along height fields: from a point of the face into the layer on either side, and from within the layer to that
//! point, nearly in the tangent plane. The search for the next crossing has its hardest work there.

use super::tracer::Start;
use crate::trace::Model;
use crate::trace::cpu::vec3::{V3, v3};
use crate::trace::cpu::{Limits, Path};
use crate::trace::model::Deformation;
use std::f64::consts::FRAC_PI_2;

/// Distances from the middle of the fields, mm: crest, flanks, rims and level parts of the dents and presses.
const RADII_MM: [f64; 9] = [0.0, 0.8, 1.5, 2.6, 4.0, 5.5, 7.5, 10.0, 13.0];
/// Angles to the surface, powers of ten in radians.
const POWERS: std::ops::RangeInclusive<i32> = -7..=-1;
/// How far within the layer a ray starts that comes to the surface, mm.
const BACK_MM: f64 = 1.5;
/// How far it must then be from both faces of the layer, mm.
const CLEAR_MM: f64 = 1e-4;
/// Steps that a ray is followed for.
pub const STEPS: u32 = 64;

/// Rays along each interface of a model that is a height field; none where there is no such interface.
pub fn starts(model: &Model<f64>) -> Vec<Start> {
    let Deformation::Field(field) = &model.shape else { return Vec::new() };
    let mut path = Path::new(model, Limits::default());
    let mut starts = Vec::new();
    let curved = (0..model.faces.len()).filter(|&i| model.faces[i].share != 0.0);
    for (i, (place, radius)) in curved.flat_map(|i| RADII_MM.into_iter().enumerate().map(move |at| (i, at))) {
        let turn = 0.4 + 1.9 * place as f64;
        let (x, y) = (field.center[0] + radius * turn.cos(), field.center[1] + radius * turn.sin());
        if x.abs() >= model.half_size[0] || y.abs() >= model.half_size[1] {
            continue;
        }
        let at = v3(x, y, path.surface_height(i, x, y));
        let normal = path.surface_normal(i, at, 0.0);
        for quarter in 0..4 {
            let heading = turn + f64::from(quarter) * FRAC_PI_2;
            let level = v3(heading.cos(), heading.sin(), 0.0);
            let along = (level - normal * level.dot(normal)).normalize();
            for angle in POWERS.map(|power| 10f64.powi(power)) {
                for (layer, side) in [(i, -1.0), (i + 1, 1.0)] {
                    let away = along * angle.cos() + normal * (side * angle.sin());
                    starts.push(start(model, layer, at, away));
                    let toward = along * angle.cos() - normal * (side * angle.sin());
                    let from = at - toward * BACK_MM;
                    if within(&mut path, layer, from) {
                        starts.push(start(model, layer, from, toward));
                    }
                }
            }
        }
    }
    starts
}

fn start(model: &Model<f64>, layer: usize, o: V3<f64>, d: V3<f64>) -> Start {
    let p = d * model.layers[layer].n;
    Start { o: [o.x, o.y, o.z].map(|v| v as f32), p: [p.x, p.y, p.z].map(|v| v as f32), layer, steps: STEPS }
}

/// Whether a point is in a layer, clear of both faces.
fn within(path: &mut Path<f64>, layer: usize, o: V3<f64>) -> bool {
    let faces = path.model.faces.len();
    let inside = o.x.abs() < path.model.half_size[0] && o.y.abs() < path.model.half_size[1];
    let mut height = |i: usize| match path.model.faces[i] {
        face if face.share == 0.0 => face.z,
        _ => path.surface_height(i, o.x, o.y),
    };
    inside && o.z > height(layer - 1) + CLEAR_MM && (layer == faces || o.z < height(layer) - CLEAR_MM)
}
