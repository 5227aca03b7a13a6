//! One element's forces, volume balance and tangent stiffness.
//!
//! Stationary point of  int W_iso(F) + p (J - 1) - p^2 / (2 kappa) dV  over displacement and pressure; for the linear
//! law J - 1 is replaced by the trace of the strain. The pressure lives in one element, so it is condensed there. At
//! the incompressible limit the pressure block vanishes; the *tangent* then keeps a small compressibility 1 / (1e4 mu),
//! the *residual* does not: Newton's steps reach the exact solution, a thousandfold closer each time.

use super::element::{MAX_NODES, MAX_PRESSURES, quadrature};
use super::kinematics::{Kinematics, MaterialPoint, cofactor};
use super::material::{History, Material, Response, Tensor};

/// Largest bulk modulus of the tangent, in shear moduli.
const TANGENT_BULK: f64 = 1e4;

/// What an element adds to the system. Unknown 3-vectors of nodes are laid out with stride `dim`.
#[derive(Debug, Clone)]
pub struct ElementSystem {
    /// Internal force minus nothing: derivative of the potential by each displacement, mN.
    pub force: Vec<f64>,
    /// Tangent with the pressure condensed, full and row-major; empty where only residuals were asked for.
    pub stiffness: Vec<f64>,
    /// Force with the pressure's defect condensed in: the right side of Newton's step.
    pub condensed: Vec<f64>,
    /// Pressure step: `defect + slope . du`.
    pub pressure_defect: [f64; MAX_PRESSURES],
    /// Rows of the pressure's slope by displacement, kPa per mm.
    pub pressure_slope: Vec<f64>,
    /// Products of the pressure functions over the element, mm^3.
    pub mass: [[f64; MAX_PRESSURES]; MAX_PRESSURES],
    /// Largest volume defect, mean of |J - 1 - p / kappa| weighted by the pressure functions.
    pub volume_defect: f64,
    /// Smallest J at the quadrature points.
    pub min_jacobian: f64,
}

/// Pressure functions at a reference position: 1 and the distances from the element's middle in half sizes.
pub fn pressure_functions(dim: usize, frame: &[[f64; 3]; 2], position: [f64; 3]) -> [f64; MAX_PRESSURES] {
    let mut functions = [0.0; MAX_PRESSURES];
    functions[0] = 1.0;
    for i in 0..dim {
        functions[1 + i] = (position[i] - frame[0][i]) / frame[1][i];
    }
    functions
}

/// Middle and half size of the box around an element.
pub fn pressure_frame(nodes: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for node in nodes {
        for i in 0..3 {
            low[i] = low[i].min(node[i]);
            high[i] = high[i].max(node[i]);
        }
    }
    let half = [0, 1, 2].map(|i| (0.5 * (high[i] - low[i])).max(f64::MIN_POSITIVE));
    [[0, 1, 2].map(|i| 0.5 * (low[i] + high[i])), half]
}

/// Evaluates an element; `None` where it is inside out or its law has no finite answer. The number of pressure
/// coefficients tells the order of the pressure.
pub fn element_system(
    kinematics: Kinematics,
    nodes: &[[f64; 3]],
    displacement: &[[f64; 3]],
    pressure: &[f64],
    material: &Material,
    history: Option<(&[History], f64)>,
    tangent_bulk_kpa: Option<f64>,
) -> Option<ElementSystem> {
    let asked = Asked { kinematics, nodes, displacement, pressure, material, history, tangent_bulk_kpa };
    pulp::Arch::new().dispatch(asked)
}

/// What an element is evaluated from.
struct Asked<'a> {
    kinematics: Kinematics,
    nodes: &'a [[f64; 3]],
    displacement: &'a [[f64; 3]],
    pressure: &'a [f64],
    material: &'a Material,
    history: Option<(&'a [History], f64)>,
    tangent_bulk_kpa: Option<f64>,
}

/// In vectors as wide as the CPU has; what is added in which order stays as it is written.
impl pulp::NullaryFnOnce for Asked<'_> {
    type Output = Option<ElementSystem>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { kinematics, nodes, displacement, pressure, material, history, tangent_bulk_kpa } = self;
        let dim = kinematics.dim();
        let tangent = tangent_bulk_kpa.is_some();
        let (unknowns, pressures) = (nodes.len() * dim, pressure.len().min(dim + 1));
        let frame = pressure_frame(nodes);
        let small = material.law.is_small_strain();
        let compliance = 1.0 / material.bulk_kpa();
        let mut force = vec![0.0; unknowns];
        let mut stiffness = Stiffness::new(dim, if tangent { nodes.len() } else { 0 });
        let mut slope = vec![0.0; pressures * unknowns];
        let mut mass = [[0.0; MAX_PRESSURES]; MAX_PRESSURES];
        let mut balance = [0.0; MAX_PRESSURES];
        let mut min_jacobian = f64::INFINITY;
        for (q, at) in quadrature(dim).iter().enumerate() {
            let point = kinematics.point(nodes, at)?;
            let mut f = point.displacement_gradient(dim, displacement);
            let trace = f[0][0] + f[1][1] + f[2][2];
            (0..3).for_each(|i| f[i][i] += 1.0);
            let functions = pressure_functions(dim, &frame, point.position);
            let p: f64 = (0..pressures).map(|k| functions[k] * pressure[k]).sum();
            let (change, direction) = if small { (trace, IDENTITY) } else { (determinant(&f) - 1.0, cofactor(&f)) };
            if !small && change <= -1.0 {
                return None;
            }
            min_jacobian = min_jacobian.min(1.0 + change);
            let mut response = material.isochoric(&f, history.and_then(|(list, dt)| list.get(q).map(|h| (h, dt))))?;
            for k in 0..9 {
                response.stress[k] += p * direction[k / 3][k % 3];
            }
            let volume = point.volume;
            let mut divergence = [0.0; MAX_NODES * 3];
            if tangent && !small {
                add_cofactor_derivative(&f, p, &mut response.tangent);
            }
            let sums = Sums { force: &mut force, divergence: &mut divergence[..unknowns] };
            stiffness.add(kinematics, &point, &response, &flat(&direction), sums);
            for k in 0..pressures {
                balance[k] += volume * functions[k] * (change - compliance * p);
                for l in 0..pressures {
                    mass[k][l] += volume * functions[k] * functions[l];
                }
                for (row, d) in slope[k * unknowns..(k + 1) * unknowns].iter_mut().zip(&divergence) {
                    *row += functions[k] * d;
                }
            }
        }
        let volume_defect = balance[..pressures].iter().fold(0.0, |m: f64, b| m.max((b / mass[0][0]).abs()));
        let mut system = ElementSystem {
            condensed: force.clone(),
            force,
            stiffness: stiffness.spell_out(),
            pressure_defect: [0.0; MAX_PRESSURES],
            pressure_slope: slope,
            mass,
            volume_defect,
            min_jacobian,
        };
        if let Some(largest) = tangent_bulk_kpa {
            let bulk = material.bulk_kpa().min(f64::MAX).recip() + softening(material, largest);
            system.condense(unknowns, pressures, &mass, &balance, 1.0 / bulk)?;
        }
        Some(system)
    }
}

/// The memory of an element after a step of `dt_s` seconds.
pub fn advance_history(
    kinematics: Kinematics,
    nodes: &[[f64; 3]],
    displacement: &[[f64; 3]],
    material: &Material,
    history: &[History],
    dt_s: f64,
) -> Option<Vec<History>> {
    let dim = kinematics.dim();
    let points = quadrature(dim).iter().zip(history);
    points
        .map(|(at, history)| {
            let point = kinematics.point(nodes, at)?;
            let mut f = point.displacement_gradient(dim, displacement);
            (0..3).for_each(|i| f[i][i] += 1.0);
            history.advance(material, &f, dt_s)
        })
        .collect()
}

/// Compressibility that the tangent keeps beyond the law's own, per kPa.
fn softening(material: &Material, largest_kpa: f64) -> f64 {
    if material.bulk_kpa() > largest_kpa { 1.0 / largest_kpa } else { 0.0 }
}

/// Largest bulk modulus of the tangent for a body of these materials, kPa: by the stiffest of them, because a soft part
/// inside a stiff one is held by the stiff one.
pub fn tangent_bulk_kpa(materials: &[Material]) -> f64 {
    TANGENT_BULK * materials.iter().map(|material| material.law.shear_kpa()).fold(0.0, f64::max)
}

impl ElementSystem {
    /// K += kappa B^T M^-1 B, and the defect of the pressure into the forces.
    #[inline(always)]
    fn condense(
        &mut self,
        unknowns: usize,
        pressures: usize,
        mass: &[[f64; MAX_PRESSURES]; MAX_PRESSURES],
        balance: &[f64; MAX_PRESSURES],
        bulk: f64,
    ) -> Option<()> {
        let factor = small_cholesky(mass, pressures)?;
        let divergence = self.pressure_slope.clone();
        let solve = |right: [f64; MAX_PRESSURES]| small_solve(&factor, pressures, right);
        self.pressure_defect = solve(*balance).map(|x| bulk * x);
        for j in 0..unknowns {
            let mut column = [0.0; MAX_PRESSURES];
            (0..pressures).for_each(|k| column[k] = divergence[k * unknowns + j]);
            let column = solve(column);
            (0..pressures).for_each(|k| self.pressure_slope[k * unknowns + j] = bulk * column[k]);
        }
        for k in 0..pressures {
            let (rows, slope) = (&divergence[k * unknowns..], &self.pressure_slope[k * unknowns..(k + 1) * unknowns]);
            let lines = self.stiffness.chunks_exact_mut(unknowns).zip(&mut self.condensed);
            for (row, (line, condensed)) in rows.iter().zip(lines) {
                *condensed += row * self.pressure_defect[k];
                line.iter_mut().zip(slope).for_each(|(entry, s)| *entry += row * s);
            }
        }
        Some(())
    }
}

const IDENTITY: Tensor = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn flat(t: &Tensor) -> [f64; 9] {
    [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|k| t[k / 3][k % 3])
}

/// Determinant of a 3 x 3 matrix.
pub fn determinant(m: &Tensor) -> f64 {
    let c = cofactor(m);
    m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2]
}

/// Adds p d2J/dF dF: entry (iJ, kL) is e_ikm e_JLN F_mN.
fn add_cofactor_derivative(f: &Tensor, p: f64, tangent: &mut [[f64; 9]; 9]) {
    for i in 0..3 {
        for j in 0..3 {
            for (k, l, sign) in [(1, 1, 1.0), (2, 2, 1.0), (1, 2, -1.0), (2, 1, -1.0)] {
                // e_ikm e_jln over k = i + 1, i + 2 and l = j + 1, j + 2.
                let (m, n) = ((i + 3 - k) % 3, (j + 3 - l) % 3);
                tangent[3 * i + j][3 * ((i + k) % 3) + (j + l) % 3] += sign * p * f[m][n];
            }
        }
    }
}

/// Numbers of nodes in three and two dimensions, rounded up to even ones.
const SOLID_NODES: usize = 28;
const PLANE_NODES: usize = 10;

/// Components of F that a displacement component moves: by the gradients of its node's function along two axes, and
/// along the third or as hoop. In two dimensions the second component has no third part.
const fn moves(dim: usize) -> [[usize; 3]; 3] {
    if dim == 3 { [[0, 1, 2], [3, 4, 5], [6, 7, 8]] } else { [[0, 1, 8], [3, 4, 0], [0; 3]] }
}

/// The strain operator at a point: how each unknown moves the nine components of F.
struct Operator<const D: usize, const N: usize> {
    /// How many components of F each displacement component moves.
    parts: [usize; 3],
    /// Weights of these by node, 0 beyond the last.
    weight: [[f64; N]; 3],
    nodes: usize,
}

/// An element's stiffness, as its number of dimensions lays it out.
enum Stiffness {
    Plane(Blocks<PLANE_NODES>),
    Solid(Blocks<SOLID_NODES>),
}

/// What a point adds to, one entry a displacement component.
struct Sums<'a> {
    force: &'a mut [f64],
    divergence: &'a mut [f64],
}

impl Stiffness {
    /// For so many nodes; with none, only the sums are kept.
    fn new(dim: usize, nodes: usize) -> Self {
        if dim == 3 { Self::Solid(Blocks::new(nodes)) } else { Self::Plane(Blocks::new(nodes)) }
    }

    /// Adds a point's stiffness, its stress to the forces and the direction of its volume to the divergence.
    #[inline(always)]
    fn add(
        &mut self,
        kinematics: Kinematics,
        point: &MaterialPoint,
        response: &Response,
        direction: &[f64; 9],
        sums: Sums,
    ) {
        match self {
            Self::Plane(blocks) => add_point::<2, PLANE_NODES>(kinematics, point, response, direction, sums, blocks),
            Self::Solid(blocks) => add_point::<3, SOLID_NODES>(kinematics, point, response, direction, sums, blocks),
        }
    }

    fn spell_out(&self) -> Vec<f64> {
        match self {
            Self::Plane(blocks) => blocks.spell_out(2),
            Self::Solid(blocks) => blocks.spell_out(3),
        }
    }
}

#[inline(always)]
fn add_point<const D: usize, const N: usize>(
    kinematics: Kinematics,
    point: &MaterialPoint,
    response: &Response,
    direction: &[f64; 9],
    sums: Sums,
    blocks: &mut Blocks<N>,
) {
    let operator = Operator::<D, N>::new(kinematics, point, sums.force.len() / D);
    operator.scatter(&response.stress, point.volume, sums.force);
    operator.scatter(direction, point.volume, sums.divergence);
    if blocks.nodes() > 0 {
        operator.add_stiffness(&response.tangent, point.volume, blocks);
    }
}

/// Stiffness by pairs of components (c, d) with c <= d: entry [pair][b][a] joins component c of node a and d of node b.
struct Blocks<const N: usize>([Vec<[f64; N]>; 6]);

/// The pairs of components, those of two dimensions first.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]];

const fn pairs(dim: usize) -> usize {
    dim * (dim + 1) / 2
}

impl<const N: usize> Blocks<N> {
    fn new(nodes: usize) -> Self {
        Self(std::array::from_fn(|_| vec![[0.0; N]; nodes]))
    }

    fn nodes(&self) -> usize {
        self.0[0].len()
    }

    /// The full row-major matrix.
    fn spell_out(&self, dim: usize) -> Vec<f64> {
        let nodes = self.nodes();
        let unknowns = nodes * dim;
        let mut stiffness = vec![0.0; unknowns * unknowns];
        for ([c, d], block) in PAIRS.iter().zip(&self.0).take(pairs(dim)) {
            for (b, row) in block.iter().enumerate() {
                for (a, entry) in row.iter().enumerate().take(nodes) {
                    stiffness[(b * dim + d) * unknowns + a * dim + c] = *entry;
                    stiffness[(a * dim + c) * unknowns + b * dim + d] = *entry;
                }
            }
        }
        stiffness
    }
}

impl<const D: usize, const N: usize> Operator<D, N> {
    #[inline(always)]
    fn new(kinematics: Kinematics, point: &MaterialPoint, nodes: usize) -> Self {
        let hoop = kinematics == Kinematics::Axisymmetric;
        let mut weight = [[0.0; N]; 3];
        for (a, (gradient, hoop)) in point.gradient.iter().zip(&point.hoop).enumerate().take(nodes.min(N)) {
            let third = if D == 3 { gradient[2] } else { *hoop };
            [weight[0][a], weight[1][a], weight[2][a]] = [gradient[0], gradient[1], third];
        }
        let parts = if D == 3 { [3; 3] } else { [if hoop { 3 } else { 2 }, 2, 0] };
        Self { parts, weight, nodes }
    }

    /// forces += volume G^T stress.
    #[inline(always)]
    fn scatter(&self, stress: &[f64; 9], volume: f64, force: &mut [f64]) {
        for c in 0..D {
            let mut part = [0.0; 3];
            (0..self.parts[c]).for_each(|j| part[j] = volume * stress[moves(D)[c][j]]);
            let [x, y, z] = &self.weight;
            for a in 0..self.nodes.min(N) {
                force[a * D + c] += part[0] * x[a] + part[1] * y[a] + part[2] * z[a];
            }
        }
    }

    /// blocks += volume G^T tangent G.
    #[inline(always)]
    fn add_stiffness(&self, tangent: &[[f64; 9]; 9], volume: f64, blocks: &mut Blocks<N>) {
        let [x, y, z] = &self.weight;
        for ([c, d], block) in PAIRS.iter().zip(&mut blocks.0).take(pairs(D)) {
            let mut part = [[0.0; 3]; 3];
            for j in 0..self.parts[*c] {
                for l in 0..self.parts[*d] {
                    part[j][l] = volume * tangent[moves(D)[*c][j]][moves(D)[*d][l]];
                }
            }
            for (b, row) in block.iter_mut().enumerate() {
                let [p, q, r] = part.map(|part| part[0] * x[b] + part[1] * y[b] + part[2] * z[b]);
                for a in 0..N {
                    row[a] += p * x[a] + q * y[a] + r * z[a];
                }
            }
        }
    }
}

type Small = [[f64; MAX_PRESSURES]; MAX_PRESSURES];

/// Cholesky factor of the leading n x n block.
fn small_cholesky(matrix: &Small, n: usize) -> Option<Small> {
    let mut factor = Small::default();
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = matrix[i][j] - (0..j).map(|k| factor[i][k] * factor[j][k]).sum::<f64>();
            factor[i][j] = if i == j { sum.sqrt() } else { sum / factor[j][j] };
        }
        if factor[i][i].is_nan() || factor[i][i] <= 0.0 {
            return None;
        }
    }
    Some(factor)
}

fn small_solve(factor: &Small, n: usize, mut x: [f64; MAX_PRESSURES]) -> [f64; MAX_PRESSURES] {
    for i in 0..n {
        x[i] = (x[i] - (0..i).map(|k| factor[i][k] * x[k]).sum::<f64>()) / factor[i][i];
    }
    for i in (0..n).rev() {
        x[i] = (x[i] - (i + 1..n).map(|k| factor[k][i] * x[k]).sum::<f64>()) / factor[i][i];
    }
    x
}
