//! What is read from a state: reactions, stress, pressure; and dead loads from tractions.
//!
//! A nodal reaction is the derivative of the energy by that node's displacement, less the dead force. Work done over
//! any displacement of supported nodes is therefore exact for the mesh, and sums of reactions converge twice as fast as
//! stresses do. Relaxing materials are read by what they remember: a held state has the stresses of its history.

use super::element::{GAUSS_3, ShapeFunctions, quadrature};
use super::kinematics::Kinematics;
use super::material::{History, Tensor};
use super::mesh::{Boundary, Facet, Mesh};
use super::problem::{Problem, State};
use super::solid::{determinant, element_system, pressure_frame, pressure_functions};
use std::collections::HashMap;

/// Stress and strain at a quadrature point of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Reference position, mm.
    pub position: [f64; 3],
    /// Reference volume that it stands for, mm^3 (mm^2 in plane strain).
    pub volume: f64,
    /// Deformation gradient; axes x (r), z and the third (hoop) in two dimensions.
    pub deformation: Tensor,
    /// Volume over reference volume; 1 + trace of the strain under the linear law.
    pub jacobian: f64,
    /// Mean stress, kPa; tension positive.
    pub pressure: f64,
    /// Cauchy stress, kPa; axes as in the deformation gradient.
    pub cauchy: Tensor,
}

/// Force that supports and contacts exert on each node, mN; 0, but for the solver's tolerance, on free nodes.
///
/// `None` where the state has an element that is inside out.
pub fn reactions(problem: &Problem, state: &State) -> Option<Vec<[f64; 3]>> {
    let dim = problem.kinematics.dim();
    let mut forces = vec![[0.0; 3]; problem.mesh.nodes.len()];
    for e in 0..problem.mesh.element_count() {
        let element = Element::new(problem, state, e);
        let system = element_system(
            problem.kinematics,
            &element.nodes,
            &element.displacement,
            element.pressure,
            &problem.materials[problem.mesh.region[e] as usize],
            // Nothing relaxes in no time.
            Some((element.history, 0.0)),
            None,
        )?;
        for (&node, force) in problem.mesh.element(e).iter().zip(system.force.chunks(dim)) {
            (0..dim).for_each(|i| forces[node as usize][i] += force[i]);
        }
    }
    for (node, force) in &problem.forces {
        (0..dim).for_each(|i| forces[*node as usize][i] -= state.load * force[i]);
    }
    Some(forces)
}

/// Sum of the reactions on one part of the boundary, mN. Nodes on its rim count in full.
pub fn boundary_force(mesh: &Mesh, reactions: &[[f64; 3]], boundary: Boundary) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for node in mesh.boundary_nodes(boundary) {
        (0..3).for_each(|i| sum[i] += reactions[node as usize][i]);
    }
    sum
}

/// Nodal dead forces, mN, of a traction on facets; the traction in kPa is a function of position and outward normal in
/// the reference configuration.
pub fn traction_forces(
    kinematics: Kinematics,
    mesh: &Mesh,
    facets: &[Facet],
    traction: &dyn Fn([f64; 3], [f64; 3]) -> [f64; 3],
) -> Vec<(u32, [f64; 3])> {
    let axes = kinematics.dim() - 1;
    let mut forces = Vec::new();
    for &facet in facets {
        let nodes = mesh.facet_nodes(facet);
        let positions: Vec<[f64; 3]> = nodes.iter().map(|&a| mesh.nodes[a as usize]).collect();
        let element = mesh.element(facet.element as usize);
        let middle = mesh.nodes[element[element.len() / 2] as usize];
        let mut sums = vec![[0.0; 3]; nodes.len()];
        for q in 0..3usize.pow(axes as u32) {
            let [first, second] = [GAUSS_3[q % 3], if axes == 2 { GAUSS_3[q / 3] } else { [0.0, 1.0] }];
            let shape = ShapeFunctions::at(axes, [first[0], second[0], 0.0]);
            let (position, area) = surface(&shape, &positions, middle, axes);
            let size = area.iter().map(|a| a * a).sum::<f64>().sqrt();
            let force = traction(position, area.map(|a| a / size));
            let weight = first[1] * second[1] * size * kinematics.weight(position[0]);
            for (sum, value) in sums.iter_mut().zip(shape.value) {
                (0..3).for_each(|i| sum[i] += weight * value * force[i]);
            }
        }
        forces.extend(nodes.into_iter().zip(sums));
    }
    forces
}

/// Position on a facet and its area vector, which points away from `inside`.
fn surface(shape: &ShapeFunctions, nodes: &[[f64; 3]], inside: [f64; 3], axes: usize) -> ([f64; 3], [f64; 3]) {
    let mut position = [0.0; 3];
    let mut t = [[0.0; 3]; 2];
    for (a, node) in nodes.iter().enumerate() {
        for i in 0..3 {
            position[i] += shape.value[a] * node[i];
            t[0][i] += shape.gradient[a][0] * node[i];
            t[1][i] += shape.gradient[a][1] * node[i];
        }
    }
    if axes == 1 {
        t[1] = [0.0, 0.0, 1.0];
    }
    let area = [0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        t[0][j] * t[1][k] - t[0][k] * t[1][j]
    });
    let outward: f64 = (0..3).map(|i| area[i] * (position[i] - inside[i])).sum();
    (position, if outward < 0.0 { area.map(|a| -a) } else { area })
}

/// Stress at the quadrature points of element `e`; `None` where it is inside out.
pub fn samples(problem: &Problem, state: &State, e: usize) -> Option<Vec<Sample>> {
    let element = Element::new(problem, state, e);
    (0..quadrature(problem.kinematics.dim()).len()).map(|q| element.sample(problem, e, q)).collect()
}

/// Smallest volume over reference volume at all quadrature points; `None` where an element is inside out.
pub fn min_jacobian(problem: &Problem, state: &State) -> Option<f64> {
    let least = element_least_jacobian(problem, state);
    least.into_iter().try_fold(f64::INFINITY, |least, here| (!here.is_nan()).then(|| least.min(here)))
}

/// Smallest volume over reference volume at the quadrature points of each element; NaN where it is inside out.
pub fn element_least_jacobian(problem: &Problem, state: &State) -> Vec<f64> {
    let smallest = |samples: Vec<Sample>| samples.iter().fold(f64::INFINITY, |least, s| least.min(s.jacobian));
    (0..problem.mesh.element_count()).map(|e| samples(problem, state, e).map_or(f64::NAN, smallest)).collect()
}

/// Cauchy stress of each element, kPa: its mean over the undeformed volume; NaN where the element is inside out.
pub fn element_stress(problem: &Problem, state: &State) -> Vec<Tensor> {
    let mean = |samples: Vec<Sample>| {
        let volume: f64 = samples.iter().map(|sample| sample.volume).sum();
        let of = |i: usize, j: usize| samples.iter().map(|s| s.volume * s.cauchy[i][j]).sum::<f64>() / volume;
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| of(i, j)))
    };
    (0..problem.mesh.element_count()).map(|e| samples(problem, state, e).map_or([[f64::NAN; 3]; 3], mean)).collect()
}

/// Mean compressive stress at each node of each element, kPa, in the order of the mesh's elements. It may jump between
/// elements: the pressure is discontinuous.
pub fn element_pressure(problem: &Problem, state: &State) -> Vec<f64> {
    let dim = problem.kinematics.dim();
    let at_nodes = |e: usize| {
        let element = Element::new(problem, state, e);
        let frame = pressure_frame(&element.nodes);
        let remembered = element.remembered_pressure(problem, e);
        element.nodes.iter().map(|&x| -element.pressure_at(dim, &frame, x) - remembered).collect::<Vec<_>>()
    };
    (0..problem.mesh.element_count()).flat_map(at_nodes).collect()
}

/// Jump of the discontinuous pressure between neighbours of one region, rms over the shared faces' middles, as a share
/// of the rms spread of the pressure. It falls with the square of the element size; a checkerboard has 2. 0 in a
/// uniform state.
pub fn pressure_jump(problem: &Problem, state: &State) -> f64 {
    let mesh = &problem.mesh;
    let dim = problem.kinematics.dim();
    let mut faces: HashMap<Vec<u32>, (usize, f64)> = HashMap::new();
    let (mut squares, mut count, mut values) = (0.0, 0.0, Vec::new());
    for e in 0..mesh.element_count() {
        let element = Element::new(problem, state, e);
        let frame = pressure_frame(&element.nodes);
        for side in 0..2 * dim as u8 {
            let mut nodes = mesh.facet_nodes(Facet { element: e as u32, side, boundary: Boundary::Side });
            let middle = mesh.nodes[nodes[nodes.len() / 2] as usize];
            let value = element.pressure_at(dim, &frame, middle);
            values.push(value);
            nodes.sort_unstable();
            match faces.remove(&nodes) {
                Some((other, before)) if mesh.region[other] == mesh.region[e] => {
                    squares += (value - before) * (value - before);
                    count += 1.0;
                }
                Some(_) => {}
                None => {
                    faces.insert(nodes, (e, value));
                }
            }
        }
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let spread = (values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / values.len() as f64).sqrt();
    let jump = (squares / f64::max(count, 1.0)).sqrt();
    if jump > 1e-12 * mean.abs() { jump / spread } else { 0.0 }
}

/// What a state says of one element.
struct Element<'a> {
    nodes: Vec<[f64; 3]>,
    displacement: Vec<[f64; 3]>,
    pressure: &'a [f64],
    /// What its quadrature points remember; empty for elastic materials.
    history: &'a [History],
}

impl<'a> Element<'a> {
    fn new(problem: &Problem, state: &'a State, e: usize) -> Self {
        let pick = |all: &[[f64; 3]]| problem.mesh.element(e).iter().map(|&a| all[a as usize]).collect();
        let count = problem.pressures();
        Self {
            nodes: pick(&problem.mesh.nodes),
            displacement: pick(&state.displacement),
            pressure: &state.pressure[e * count..(e + 1) * count],
            history: &state.history[e],
        }
    }

    /// Mean over the element of what its memory adds to the mean stress, kPa; 0 where it is elastic or inside out.
    fn remembered_pressure(&self, problem: &Problem, e: usize) -> f64 {
        if self.history.is_empty() {
            return 0.0;
        }
        let (dim, frame) = (problem.kinematics.dim(), pressure_frame(&self.nodes));
        let samples = (0..self.history.len()).filter_map(|q| self.sample(problem, e, q));
        let add = |sum: [f64; 2], at: Sample| {
            let own = self.pressure_at(dim, &frame, at.position);
            [sum[0] + at.volume * (at.pressure - own), sum[1] + at.volume]
        };
        let [sum, volume] = samples.fold([0.0; 2], add);
        if volume > 0.0 { sum / volume } else { 0.0 }
    }

    fn pressure_at(&self, dim: usize, frame: &[[f64; 3]; 2], position: [f64; 3]) -> f64 {
        self.pressure.iter().zip(pressure_functions(dim, frame, position)).map(|(p, f)| p * f).sum()
    }

    fn sample(&self, problem: &Problem, e: usize, q: usize) -> Option<Sample> {
        let dim = problem.kinematics.dim();
        let point = problem.kinematics.point(&self.nodes, &quadrature(dim)[q])?;
        let (position, volume) = (point.position, point.volume);
        let mut f = point.displacement_gradient(dim, &self.displacement);
        let trace = f[0][0] + f[1][1] + f[2][2];
        (0..3).for_each(|i| f[i][i] += 1.0);
        let material = &problem.materials[problem.mesh.region[e] as usize];
        let piola = material.isochoric(&f, self.history.get(q).map(|history| (history, 0.0)))?.stress;
        let pressure = self.pressure_at(dim, &pressure_frame(&self.nodes), position);
        let small = material.law.is_small_strain();
        let jacobian = if small { 1.0 + trace } else { determinant(&f) };
        let cauchy = [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| {
                let isochoric = if small {
                    piola[3 * i + j]
                } else {
                    (0..3).map(|k| piola[3 * i + k] * f[j][k]).sum::<f64>() / jacobian
                };
                isochoric + if i == j { pressure } else { 0.0 }
            })
        });
        // What a material remembers is a deviator where it arose, and only nearly one here.
        let pressure = (cauchy[0][0] + cauchy[1][1] + cauchy[2][2]) / 3.0;
        Some(Sample { position, volume, deformation: f, jacobian, pressure, cauchy })
    }
}
