//! From a press to interfaces and contact as the tracer sees them.
//!
//! The finite elements' displacement moves every point of an interface along and across the stack; the tracer's height
//! above a place is that of the point that lies there now. Beyond the rim of the pressed face an interface keeps the height
//! of the rim, straight out from the axis.

use super::{ContactMap, HeightField, Profile, Surface, SurfaceError};
use crate::mechanics::element::{Shape, lagrange};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::{Footprint, Mesh};
use crate::mechanics::press::{ContactPoint, PressStep, Pressed, SensorBody};
use crate::scene::LoadedScene;
use std::collections::{HashMap, HashSet};

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
    let face = |i: usize| (i >= first).then(|| Face::of_layer(pressed, sensor, moved, (i - first) as u32));
    let round = pressed.setup.kinematics == Kinematics::Axisymmetric;
    let surface = if round {
        let profile = |face: Face| Profile::sample(points, footprint, [0.0; 2], |r| face.height(r, 0.0));
        every(interfaces, |i| face(i).map(profile)).map(Surface::Profiles)
    } else {
        let field = |face: Face| HeightField::sample(points, footprint, |x, y| face.height(x, y));
        every(interfaces, |i| face(i).map(field)).map(Surface::Fields)
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
        center_mm: [0.0; 2],
        radius_mm: match pressed.setup.phantom.footprint {
            Footprint::Round { radius_mm } => radius_mm,
            Footprint::Rectangle { .. } => f64::INFINITY,
        },
    })
}

/// Contact pressure at the middles of cells over a rectangle about the axis, kPa: columns, rows, values, row 0 at negative
/// y. `cells` lie along the longer side.
pub fn pressure_map(pressed: &Pressed, step: &PressStep, size_mm: [f64; 2], cells: usize) -> (usize, usize, Vec<f64>) {
    let pressure = PressureFace::of(pressed, step);
    super::contact::sample(size_mm, cells, |x, y| pressure.at(x, y))
}

/// A curved face in its present place: facets of 3 nodes along r, or of 9 over x and y.
struct Face {
    flat: bool,
    mirrored: [bool; 2],
    /// Present positions across the stack, and the value of each node.
    facets: Vec<(Vec<[f64; 2]>, Vec<f64>)>,
    /// Lowest and highest position of each facet.
    boxes: Vec<[[f64; 2]; 2]>,
}

impl Face {
    fn new(pressed: &Pressed, facets: Vec<(Vec<[f64; 2]>, Vec<f64>)>) -> Self {
        let bound = |(nodes, _): &(Vec<[f64; 2]>, Vec<f64>)| {
            let fold =
                |start: f64, pick: fn(f64, f64) -> f64| [0, 1].map(|i| nodes.iter().map(|x| x[i]).fold(start, pick));
            [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)]
        };
        Self {
            flat: pressed.setup.kinematics != Kinematics::ThreeDimensional,
            mirrored: pressed.setup.phantom.symmetry,
            boxes: facets.iter().map(bound).collect(),
            facets,
        }
    }

    /// The upper face of a sensor's layer; values are displacements along z, so that a rounded rim is left out.
    fn of_layer(pressed: &Pressed, sensor: &Mesh, moved: &[[f64; 3]], region: u32) -> Self {
        let up = sensor.dim - 1;
        let face = 3usize.pow(up as u32);
        let layer = || (0..sensor.element_count()).filter(|&e| sensor.region[e] == region).map(|e| sensor.element(e));
        let covered: HashSet<u32> = layer().flat_map(|nodes| &nodes[..face]).copied().collect();
        let tops = layer().map(|nodes| &nodes[2 * face..]).filter(|top| !covered.contains(&top[0]));
        let facets = tops.map(|nodes| {
            let place = |&a: &u32| {
                let (x, u) = (sensor.nodes[a as usize], moved[a as usize]);
                [x[0] + u[0], if up == 2 { x[1] + u[1] } else { 0.0 }]
            };
            (nodes.iter().map(place).collect(), nodes.iter().map(|&a| moved[a as usize][up]).collect())
        });
        Self::new(pressed, facets.collect())
    }

    /// The facet at a place and the local coordinates there.
    fn locate(&self, x: f64, y: f64) -> Option<(usize, [f64; 3])> {
        let at = if self.flat { [x.hypot(y), 0.0] } else { self.unmirrored([x, y]) };
        let axes = if self.flat { 1 } else { 2 };
        (0..self.facets.len()).find_map(|k| {
            let [low, high] = self.boxes[k];
            let slack = 1e-6 * (high[0] - low[0]);
            let near = (0..axes).all(|i| low[i] - slack <= at[i] && at[i] <= high[i] + slack);
            let xi = if near { local(axes, &self.facets[k].0, at) } else { None }?;
            Some((k, xi))
        })
    }

    fn unmirrored(&self, x: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| if self.mirrored[i] { x[i].abs() } else { x[i] })
    }

    /// Height above a place; beyond the rim, that of the rim straight towards the axis.
    fn height(&self, x: f64, y: f64) -> f64 {
        let value = |(k, xi): (usize, [f64; 3])| {
            let shape = Shape::at(if self.flat { 1 } else { 2 }, xi);
            self.facets[k].1.iter().zip(&shape.value).map(|(v, n)| v * n).sum()
        };
        if let Some(found) = self.locate(x, y) {
            return value(found);
        }
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..RIM_HALVINGS {
            let middle = 0.5 * (inside + outside);
            match self.locate(middle * x, middle * y) {
                Some(_) => inside = middle,
                None => outside = middle,
            }
        }
        self.locate(inside * x, inside * y).map_or(0.0, value)
    }
}

/// Halvings that find the rim: to 1e-9 of the way.
const RIM_HALVINGS: usize = 30;

/// Pressure on the touched face.
struct PressureFace {
    face: Face,
}

impl PressureFace {
    fn of(pressed: &Pressed, step: &PressStep) -> Self {
        let contact = &pressed.assembly.problem.contacts[0];
        let by_node: HashMap<u32, &ContactPoint> = step.points.iter().map(|point| (point.node, point)).collect();
        let points = |nodes: Vec<u32>| nodes.iter().filter_map(|node| by_node.get(node).copied()).collect::<Vec<_>>();
        let up = pressed.setup.kinematics.dim() - 1;
        let facets = contact.facets().map(points).map(|points| {
            let place = |p: &&ContactPoint| {
                let across = [0, 1].map(|i| p.reference_mm[i] + p.displacement_mm[i]);
                [across[0], if up == 2 { across[1] } else { 0.0 }]
            };
            (points.iter().map(place).collect(), points.iter().map(|p| p.pressure_kpa).collect())
        });
        Self { face: Face::new(pressed, facets.collect()) }
    }

    /// Pressure at a place, kPa: linear over half facets, as the contact has it; 0 off the touched face.
    fn at(&self, x: f64, y: f64) -> f64 {
        let Some((k, xi)) = self.face.locate(x, y) else { return 0.0 };
        let hats = |c: f64| [(-c).max(0.0), 1.0 - c.abs().min(1.0), c.max(0.0)];
        let [first, second] = [hats(xi[0]), hats(xi[1])];
        let weight = |a: usize| first[a % 3] * if self.face.flat { 1.0 } else { second[a / 3] };
        self.face.facets[k].1.iter().enumerate().map(|(a, p)| p * weight(a)).sum::<f64>().max(0.0)
    }
}

/// Local coordinates of a place in a facet, if it lies there.
fn local(axes: usize, nodes: &[[f64; 2]], at: [f64; 2]) -> Option<[f64; 3]> {
    let mut xi = [0.0; 3];
    for _ in 0..30 {
        let lines = [lagrange(xi[0]), lagrange(xi[1])];
        let (mut off, mut slope) = ([-at[0], -at[1]], [[0.0; 2]; 2]);
        for (a, node) in nodes.iter().enumerate() {
            let [n, d] = lines[0][a % 3];
            let [m, e] = if axes == 2 { lines[1][a / 3] } else { [1.0, 0.0] };
            for i in 0..2 {
                off[i] += n * m * node[i];
                slope[i][0] += d * m * node[i];
                slope[i][1] += n * e * node[i];
            }
        }
        let step = if axes == 1 {
            [-off[0] / slope[0][0], 0.0]
        } else {
            let determinant = slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0];
            [
                -(slope[1][1] * off[0] - slope[0][1] * off[1]) / determinant,
                -(slope[0][0] * off[1] - slope[1][0] * off[0]) / determinant,
            ]
        };
        (0..2).for_each(|i| xi[i] = (xi[i] + step[i]).clamp(-2.0, 2.0));
        if step[0].abs().max(step[1].abs()) < 1e-12 {
            break;
        }
    }
    let inside = xi.iter().all(|c| c.abs() <= 1.0 + 1e-9);
    inside.then_some(xi)
}
