//! States of one press as guesses of another: of the same press on a coarser mesh, or of a phantom much like it
//! (docs/decisions/warm-starts.md).

use super::{Assembly, Pressed};
use crate::mechanics::element::{MAX_NODES, ShapeFunctions};
use crate::mechanics::problem::{Problem, State, Traction};
use crate::mechanics::solid::{pressure_frame, pressure_functions};
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use rayon::prelude::*;
use std::ops::Range;
use std::time::Duration;

/// The elements of one body, to be found by a place in the undeformed body.
struct Body<'a> {
    problem: &'a Problem,
    elements: Range<usize>,
    tree: Bvh2,
}

/// A point of an element.
struct Place {
    element: usize,
    value: [f64; MAX_NODES],
}

/// Steps of Newton's method that find a place in an element.
const STEPS: usize = 12;
/// How far outside an element, in local coordinates, a place counts as in it; inclusions' surfaces are not the same on
/// two meshes.
const OUTSIDE: f64 = 0.3;
/// Room around an element's box, as a share of its size: for single precision and for what lies outside.
const ROOM: f32 = 0.05;

impl<'a> Body<'a> {
    fn new(problem: &'a Problem, elements: Range<usize>) -> Self {
        let corner = |x: [f64; 3]| Vec3A::from_array(x.map(|c| c as f32));
        let of = |e: usize| {
            let nodes = problem.mesh.element(e).iter().map(|&a| corner(problem.mesh.nodes[a as usize]));
            let all = nodes.fold(Aabb::empty(), |all, node| all.union(&Aabb::new(node, node)));
            let room = ROOM * all.diagonal().length();
            Aabb::new(all.min - room, all.max + room)
        };
        let boxes: Vec<Aabb> = elements.clone().map(of).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::fastest_build(), &mut Duration::default());
        Self { problem, elements, tree }
    }

    /// Where a place lies; the element that it is least outside of.
    fn find(&self, at: [f64; 3]) -> Option<Place> {
        let mut found: Option<(f64, Place)> = None;
        self.tree.point_traverse(Vec3A::from_array(at.map(|c| c as f32)), |tree, leaf| {
            let node = &tree.nodes[leaf as usize];
            for k in node.first_index..node.first_index + node.prim_count {
                let element = self.elements.start + tree.primitive_indices[k as usize] as usize;
                let nearer = |(outside, _): &(f64, Place)| found.as_ref().is_none_or(|(least, _)| outside < least);
                if let Some(place) = self.within(element, at).filter(nearer) {
                    found = Some(place);
                }
            }
            true
        });
        found.map(|(_, place)| place)
    }

    /// A place in an element, and how far outside it lies in local coordinates.
    fn within(&self, element: usize, at: [f64; 3]) -> Option<(f64, Place)> {
        let mesh = &self.problem.mesh;
        let nodes = mesh.element(element);
        let dim = mesh.dim;
        let mut xi = [0.0_f64; 3];
        let mut shape = ShapeFunctions::at(dim, xi);
        for _ in 0..STEPS {
            let mut off = [0.0; 3];
            let mut slope = [[0.0; 3]; 3];
            (dim..3).for_each(|i| slope[i][i] = 1.0);
            (0..dim).for_each(|i| off[i] = at[i]);
            for (a, &node) in nodes.iter().enumerate() {
                let x = mesh.nodes[node as usize];
                for i in 0..dim {
                    off[i] -= shape.value[a] * x[i];
                    (0..dim).for_each(|j| slope[j][i] += shape.gradient[a][j] * x[i]);
                }
            }
            let step = glam::DMat3::from_cols_array_2d(&slope).inverse() * glam::DVec3::from_array(off);
            if !step.is_finite() {
                return None;
            }
            (0..dim).for_each(|i| xi[i] = (xi[i] + step[i]).clamp(-2.0, 2.0));
            shape = ShapeFunctions::at(dim, xi);
            if step.abs().max_element() < 1e-10 {
                break;
            }
        }
        let outside = xi.iter().map(|c| (c.abs() - 1.0).max(0.0)).fold(0.0, f64::max);
        (outside <= OUTSIDE).then_some((outside, Place { element, value: shape.value }))
    }
}

fn frame(problem: &Problem, element: usize) -> [[f64; 3]; 2] {
    let nodes: Vec<[f64; 3]> = problem.mesh.element(element).iter().map(|&a| problem.mesh.nodes[a as usize]).collect();
    pressure_frame(&nodes)
}

/// States of another press, on this one's mesh.
pub(super) struct Guesses {
    states: Vec<State>,
    /// Whether what the other press does from load to load is to be added to what this one has done. Around the edge of
    /// a bond a finer mesh folds further than a coarser one, whose own state there is no guess.
    steps: bool,
}

/// Share of the elements below which a mesh is a coarser one.
const COARSER: f64 = 0.6;

impl Guesses {
    pub const NONE: Self = Self { states: Vec::new(), steps: false };

    /// Those of a press.
    pub fn of(near: &Pressed, to: &Assembly) -> Self {
        let problem = &to.problem;
        let elements = |assembly: &Assembly| assembly.problem.mesh.element_count() as f64;
        let coarser = elements(&near.assembly) < COARSER * elements(to);
        let carried = Carrier::new(&near.assembly, to);
        let carried = carried.iter().flat_map(|carrier| near.steps.iter().map(|step| carrier.carried(&step.state)));
        Self { states: carried.collect(), steps: coarser && !problem.slides() }
    }

    /// Loads with a guess above one and up to another, ascending.
    pub fn between(&self, above: f64, most: f64) -> Vec<f64> {
        self.states.iter().map(|state| state.load).filter(|&load| above < load && load <= most).collect()
    }

    /// A guess of the state at a load, from the balanced one before it.
    pub fn at(&self, before: &State, load: f64) -> Option<State> {
        let known = |load: f64| self.states.iter().find(|state| state.load == load);
        let mut guess = known(load)?.clone();
        if !self.steps || before.load == 0.0 {
            return Some(guess);
        }
        let start = known(before.load)?;
        let add = |guess: &mut f64, now: f64, then: f64| *guess += now - then;
        for ((guess, now), then) in guess.displacement.iter_mut().zip(&before.displacement).zip(&start.displacement) {
            (0..3).for_each(|i| add(&mut guess[i], now[i], then[i]));
        }
        for ((guess, now), then) in guess.pressure.iter_mut().zip(&before.pressure).zip(&start.pressure) {
            add(guess, *now, *then);
        }
        let tractions = before.traction.iter().flatten().zip(start.traction.iter().flatten());
        for (guess, (now, then)) in guess.traction.iter_mut().flatten().zip(tractions) {
            if guess.normal > 0.0 {
                guess.normal = (guess.normal + now.normal - then.normal).max(0.5 * guess.normal);
            }
            (0..3).for_each(|i| add(&mut guess.vector[i], now.vector[i], then.vector[i]));
        }
        Some(guess)
    }
}

/// The way from one mesh to another of much the same bodies.
struct Carrier<'a> {
    from: &'a Problem,
    to: &'a Problem,
    /// Where each node lies.
    nodes: Vec<Place>,
    /// In which element each element's middle lies.
    middles: Vec<usize>,
}

impl<'a> Carrier<'a> {
    /// `None` where the bodies are others, or a node lies in none of them.
    fn new(from: &'a Assembly, to: &'a Assembly) -> Option<Self> {
        let (old, new) = (&from.problem, &to.problem);
        let same = |of: fn(&Problem) -> usize| of(old) == of(new);
        let alike = same(|p| p.mesh.dim) && same(Problem::pressures);
        if !alike || from.bodies.len() != to.bodies.len() {
            return None;
        }
        let elements = [0..from.phantom_elements, from.phantom_elements..old.mesh.element_count()];
        let [phantom, sensor] = elements.map(|elements| Body::new(old, elements));
        let node = |(a, &at): (usize, &[f64; 3])| if a < to.phantom_nodes { &phantom } else { &sensor }.find(at);
        let nodes = new.mesh.nodes.par_iter().enumerate().map(node).collect::<Option<_>>()?;
        let middle = |e: usize| {
            let body = if e < to.phantom_elements { &phantom } else { &sensor };
            body.find(frame(new, e)[0]).map(|place| place.element)
        };
        let middles = (0..new.mesh.element_count()).into_par_iter().map(middle).collect::<Option<_>>()?;
        Some(Self { from: old, to: new, nodes, middles })
    }

    /// A state on the other mesh.
    fn carried(&self, state: &State) -> State {
        let Self { from: old, to: new, .. } = *self;
        let mut next = new.start();
        next.load = state.load;
        for (u, place) in next.displacement.iter_mut().zip(&self.nodes) {
            let nodes = old.mesh.element(place.element).iter().zip(&place.value);
            nodes.for_each(|(&a, n)| (0..3).for_each(|i| u[i] += n * state.displacement[a as usize][i]));
        }
        let pressures = new.pressures();
        let pressure = |element: usize, at: [f64; 3]| -> f64 {
            let functions = pressure_functions(old.mesh.dim, &frame(old, element), at);
            (0..pressures).map(|k| functions[k] * state.pressure[element * pressures + k]).sum()
        };
        for (e, &element) in self.middles.iter().enumerate() {
            let [middle, half] = frame(new, e);
            let mean = pressure(element, middle);
            next.pressure[e * pressures] = mean;
            for axis in 0..pressures - 1 {
                let mut end = middle;
                end[axis] += half[axis];
                next.pressure[e * pressures + 1 + axis] = pressure(element, end) - mean;
            }
        }
        // A coarse mesh may have no face that meets the sensor's side wall.
        let contacts = old.contacts.iter().zip(&state.traction).zip(&new.contacts).zip(&mut next.traction);
        for (((old_contact, known), new_contact), traction) in contacts {
            let places: Vec<[f64; 3]> = old_contact.nodes.iter().map(|&a| old.mesh.nodes[a as usize]).collect();
            let count = 1 << (new.mesh.dim - 1);
            let of_node = |&a: &u32| weighted(&places, known, new.mesh.nodes[a as usize], count);
            *traction = new_contact.nodes.par_iter().map(of_node).collect();
        }
        next
    }
}

/// Traction at a place by those of the nearest nodes, each by the inverse of its distance.
fn weighted(places: &[[f64; 3]], known: &[Traction], at: [f64; 3], count: usize) -> Traction {
    let apart = |x: &[f64; 3]| (0..3).map(|i| (x[i] - at[i]).powi(2)).sum::<f64>().sqrt();
    let mut near: Vec<(f64, &Traction)> = places.iter().map(apart).zip(known).collect();
    if near.len() > count {
        near.select_nth_unstable_by(count, |a, b| a.0.total_cmp(&b.0));
        near.truncate(count);
    }
    let weight = |distance: f64| 1.0 / distance.max(1e-100);
    let whole: f64 = near.iter().map(|(distance, _)| weight(*distance)).sum();
    let mut sum = Traction::default();
    for (distance, traction) in near {
        let share = weight(distance) / whole;
        sum.normal += share * traction.normal;
        (0..3).for_each(|i| sum.vector[i] += share * traction.vector[i]);
    }
    sum
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mechanics::from_scene::press_setup;
    use crate::scene::preset;

    /// Elements of any shape hold displacements and pressures that are linear in space: carried to another mesh they
    /// are what they were.
    #[test]
    fn what_elements_can_hold_is_carried_as_it_is() {
        for dimensions in [crate::scene::Dimensions::Two, crate::scene::Dimensions::Three] {
            let mut loaded = preset("phantom-size-8mm").unwrap();
            let press = loaded.scene.press.as_mut().unwrap();
            (press.dimensions, press.resolution) = (dimensions, 0.5);
            let setup = press_setup(&loaded).unwrap();
            let (fine, coarse) =
                (Assembly::new(&setup.without_inclusions()).unwrap(), Assembly::new(&setup.coarsened()).unwrap());
            let field =
                |x: [f64; 3]| [x[0] - 0.1 * x[2], 0.3 + x[1] - 0.2 * x[0], 0.5 * x[0] + 0.7 * x[1] - 2.0 * x[2]];
            let pressure = |x: [f64; 3]| 3.0 - 0.5 * x[0] + 0.25 * x[2] + 0.125 * x[1];
            let of_pressure = |problem: &Problem, e: usize| {
                let [middle, half] = frame(problem, e);
                let mut ends = [middle; 3];
                (0..3).for_each(|axis| ends[axis][axis] += half[axis]);
                let slope = |axis: usize| pressure(ends[axis]) - pressure(middle);
                let axes = if problem.mesh.dim == 2 { 0..2 } else { 0..3 };
                std::iter::once(pressure(middle)).chain(axes.map(slope)).collect::<Vec<f64>>()
            };
            let whole = |problem: &Problem| {
                let mut state = problem.start();
                state.load = 2.0;
                state.displacement = problem.mesh.nodes.iter().map(|&x| field(x)).collect();
                state.pressure = (0..problem.mesh.element_count()).flat_map(|e| of_pressure(problem, e)).collect();
                state
            };
            let carried = Carrier::new(&coarse, &fine).unwrap().carried(&whole(&coarse.problem));
            let wanted = whole(&fine.problem);
            let parts = carried.displacement.iter().flatten().zip(wanted.displacement.iter().flatten());
            let off = parts.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-8, "{off} mm");
            let pressures = carried.pressure.iter().zip(&wanted.pressure);
            let off = pressures.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9 && carried.load == 2.0, "{off}");
        }
    }
}
