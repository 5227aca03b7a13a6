//! The deformed bodies as quadrilaterals between corners of elements: middle nodes are left out.

use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::{Boundary, Mesh};
use crate::mechanics::press::{PressStep, Pressed, element_pressure};
use crate::report::explore::{Packed, Solid, SolidKind, SolidLoad};
use std::collections::HashMap;

/// Corners on the lattice of an element's nodes, around it: of a quadrilateral, and of each face of a brick.
const CORNERS: [usize; 4] = [0, 2, 8, 6];
const FACES: [[usize; 4]; 6] =
    [[0, 6, 24, 18], [2, 8, 26, 20], [0, 2, 20, 18], [6, 8, 26, 24], [0, 2, 8, 6], [18, 20, 26, 24]];
/// Most corners: codes have 16 bits, and a telephone has to turn them.
const MOST_CORNERS: usize = 60_000;
/// Share of the values beyond either end of the colours, because pressure is singular at edges.
const BEYOND: f64 = 0.005;
/// A trace of tension beside much pressure does not deserve half of the colours.
const TRACE: f64 = 0.02;

/// Corners of elements as they are drawn: those of another region are others, since pressure jumps there.
#[derive(Default)]
struct Corners {
    /// By region and node of the problem.
    number: HashMap<(u32, u32), usize>,
    /// Node of each.
    nodes: Vec<usize>,
    /// Of each, places in the list of the elements' nodes.
    uses: Vec<Vec<usize>>,
}

impl Corners {
    fn of(&mut self, region: u32, node: u32, use_at: Option<usize>) -> usize {
        let number = *self.number.entry((region, node)).or_insert_with(|| {
            self.nodes.push(node as usize);
            self.uses.push(Vec::new());
            self.nodes.len() - 1
        });
        if let (Some(at), Some(uses)) = (use_at, self.uses.get_mut(number)) {
            uses.push(at);
        }
        number
    }
}

/// The bodies of a press at all of its loads; nothing where their mesh is too fine for a page.
pub(super) fn solid(pressed: &Pressed) -> Option<Solid> {
    let mesh = &pressed.assembly.problem.mesh;
    let mut corners = Corners::default();
    let symmetry = pressed.setup.phantom.symmetry;
    let (kind, copies, quads) = match pressed.setup.kinematics {
        Kinematics::Axisymmetric => (SolidKind::Revolved, vec![[1.0; 2]], section(mesh, &mut corners)),
        Kinematics::PlaneStrain => (SolidKind::Extruded, vec![[1.0, 1.0], [-1.0, 1.0]], section(mesh, &mut corners)),
        Kinematics::ThreeDimensional => {
            // Three quarters, or a half: who looks from positive x and negative y sees the cuts.
            let copies = match symmetry {
                [true, true] => vec![[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]],
                [true, false] => vec![[-1.0, 1.0]],
                [false, true] | [false, false] => vec![[1.0, 1.0]],
            };
            (SolidKind::Surface, copies, surface(mesh, symmetry == [false; 2], &mut corners))
        }
    };
    let outline = if mesh.dim == 2 { outline(pressed, &corners) } else { Vec::new() };
    if corners.nodes.is_empty() || corners.nodes.len() > MOST_CORNERS {
        return None;
    }
    let numbers = |numbers: &[usize]| Packed::linear(&numbers.iter().map(|&n| n as f64).collect::<Vec<_>>());
    let by_axis = |of: &dyn Fn(usize) -> [f64; 3]| {
        let axis = |i: usize| corners.nodes.iter().map(move |&node| of(node)[i]);
        (0..mesh.dim).flat_map(axis).collect::<Vec<f64>>()
    };
    let pressures: Vec<Vec<f64>> = pressed.steps.iter().map(|step| pressures(pressed, step, &corners)).collect();
    let load = |(step, pressure): (&PressStep, &Vec<f64>)| SolidLoad {
        moved: Packed::linear(&by_axis(&|node| step.state.displacement[node])),
        pressure_kpa: Packed::linear(pressure),
    };
    Some(Solid {
        kind,
        copies,
        quads: numbers(&quads),
        outline: numbers(&outline),
        places: Packed::linear(&by_axis(&|node| mesh.nodes[node])),
        loads: pressed.steps.iter().zip(&pressures).map(load).collect(),
        range_kpa: range(pressures.into_iter().next_back().unwrap_or_default()),
    })
}

/// All elements of a mesh in two dimensions.
fn section(mesh: &Mesh, corners: &mut Corners) -> Vec<usize> {
    let size = mesh.element_size();
    let mut quads = Vec::with_capacity(4 * mesh.element_count());
    for (e, &region) in mesh.region.iter().enumerate() {
        quads.extend(CORNERS.map(|i| corners.of(region, mesh.element(e)[i], Some(size * e + i))));
    }
    quads
}

/// An element, and corners of one of its faces on its lattice.
type Side = (usize, [usize; 4]);

/// Faces of bricks that no other of their region shares; with `half`, of those beyond y = 0 alone.
fn surface(mesh: &Mesh, half: bool, corners: &mut Corners) -> Vec<usize> {
    let size = mesh.element_size();
    let is_kept = |e: usize| !half || mesh.nodes[mesh.element(e)[size / 2] as usize][1] > 0.0;
    let mut faces: HashMap<[u32; 4], Option<Side>> = HashMap::new();
    for e in (0..mesh.element_count()).filter(|&e| is_kept(e)) {
        for face in FACES {
            let mut key = face.map(|i| mesh.element(e)[i]);
            key.sort_unstable();
            faces.entry(key).and_modify(|seen| *seen = None).or_insert(Some((e, face)));
        }
    }
    let mut open: Vec<Side> = faces.into_values().flatten().collect();
    open.sort_unstable();
    let corner = |(e, face): Side| face.map(|i| corners.of(mesh.region[e], mesh.element(e)[i], Some(size * e + i)));
    open.into_iter().flat_map(corner).collect()
}

/// Edges of the bodies' sections but those on the axis, as pairs of corners.
fn outline(pressed: &Pressed, corners: &Corners) -> Vec<usize> {
    let mut pairs = Vec::new();
    let (mut first_node, mut first_element) = (0, 0);
    for body in &pressed.assembly.bodies {
        for facet in body.facets.iter().filter(|facet| facet.boundary != Boundary::SymmetryX) {
            let region = pressed.assembly.problem.mesh.region[first_element + facet.element as usize];
            let nodes = body.facet_nodes(*facet);
            let ends = [nodes.first(), nodes.last()]
                .map(|node| node.and_then(|&node| corners.number.get(&(region, node + first_node as u32))).copied());
            if let [Some(a), Some(b)] = ends {
                pairs.extend([a, b]);
            }
        }
        (first_node, first_element) = (first_node + body.nodes.len(), first_element + body.element_count());
    }
    pairs
}

/// Mean over the elements of its region that meet at each corner, kPa.
fn pressures(pressed: &Pressed, step: &PressStep, corners: &Corners) -> Vec<f64> {
    let values = element_pressure(&pressed.assembly.problem, &step.state);
    let mean = |uses: &Vec<usize>| uses.iter().map(|&at| values[at]).sum::<f64>() / uses.len().max(1) as f64;
    corners.uses.iter().map(mean).collect()
}

/// Pressures of the first and the last colour: 0 is the first, or the middle where there is tension too.
fn range(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    let cut = (BEYOND * values.len() as f64) as usize;
    let least = values.get(cut).copied().unwrap_or(0.0).min(0.0);
    let most = values.get(values.len().saturating_sub(1 + cut)).copied().unwrap_or(0.0).max(0.0);
    let high = if most > 0.0 || least < 0.0 { most.max(-least) } else { 1.0 };
    match -least < TRACE * most {
        true => [0.0, high],
        false if least < 0.0 => [-high, high],
        false => [0.0, high],
    }
}
