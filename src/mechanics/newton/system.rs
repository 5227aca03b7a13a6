//! Newton's linear system: residual, tangent, step.

use super::krylov::gmres;
use super::touch::{Hold, Touch, Touching, pushes};
use super::{Balance, CHUNK, Change, FLOOR_STRAIN, HELD, LinearSolver, Solver, StepError};
use crate::mechanics::contact::Coupling;
use crate::mechanics::element::quadrature;
use crate::mechanics::multigrid::Multigrid;
use crate::mechanics::problem::{Problem, State};
use crate::mechanics::solid::ElementSystem;
use crate::mechanics::sparse::{SparseError, SparseLdl};
use rayon::prelude::*;

/// Bulk modulus in the displacements' block that multigrid takes, in shear moduli.
pub(super) const BULK: f64 = 2.0;

/// Least residual of what is not symmetric, as a share of the first, and most directions, each of one solve: more than
/// it has ranks, for near a snap all of them count.
const ODD_TOLERANCE: f64 = 1e-10;
const ODD_DIRECTIONS: usize = 240;

/// Newton's tangent, as its method holds it.
pub(super) enum Tangent {
    Direct(Box<SparseLdl>),
    Multigrid(Box<Multigrid>),
}

/// Sums over the elements.
pub(super) struct Forces {
    residual: Vec<f64>,
    /// Of the magnitudes: what the residual is to be small against.
    size: Vec<f64>,
    /// Largest volume defect.
    volume: f64,
}

/// Elements in a state.
pub(super) struct Evaluated {
    pub forces: Forces,
    /// All of them with their tangents, where these were asked for ahead.
    pub systems: Vec<ElementSystem>,
}

impl Tangent {
    fn clear(&mut self) {
        match self {
            Self::Direct(matrix) => matrix.values.fill(0.0),
            Self::Multigrid(multigrid) => multigrid.clear(),
        }
    }

    fn couples(&self, nodes: &[u32]) -> bool {
        match self {
            Self::Direct(matrix) => matrix.couples(nodes),
            Self::Multigrid(multigrid) => multigrid.couples(nodes),
        }
    }

    /// Bytes of the factor, or of the levels.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Direct(matrix) => matrix.factor_bytes(),
            Self::Multigrid(multigrid) => multigrid.bytes(),
        }
    }
}

impl Solver<'_> {
    /// What the elements push with, `ahead` with their tangents; `None` where one is inside out.
    pub(super) fn evaluate(&self, state: &State, ahead: bool) -> Option<Evaluated> {
        let problem = self.problem;
        let mut forces = Forces { residual: vec![0.0; self.prescribed.len()], size: self.floor.clone(), volume: 0.0 };
        let mut systems = Vec::new();
        let elements: Vec<usize> = (0..problem.mesh.element_count()).collect();
        for chunk in elements.chunks(CHUNK) {
            let of = |&e: &usize| self.element(e, state, ahead.then(|| self.bulk_kpa(e)));
            let mut found = chunk.par_iter().map(of).collect::<Option<Vec<ElementSystem>>>()?;
            for (&e, system) in chunk.iter().zip(&found) {
                let unknowns = unknowns(problem.mesh.element(e), problem.kinematics.dim());
                for (k, f) in unknowns.into_iter().zip(&system.force) {
                    forces.residual[k] += f;
                    forces.size[k] += f.abs();
                }
                forces.volume = forces.volume.max(system.volume_defect);
            }
            if ahead {
                systems.append(&mut found);
            }
        }
        Some(Evaluated { forces, systems })
    }

    /// How far a state is from balance.
    pub(super) fn balance(&self, state: &State, forces: Forces, touches: &[Touching]) -> Balance {
        let problem = self.problem;
        let dim = problem.kinematics.dim();
        let Forces { mut residual, mut size, volume } = forces;
        for &(node, force) in &problem.forces {
            for c in 0..dim {
                residual[node as usize * dim + c] -= state.load * force[c];
                size[node as usize * dim + c] += (state.load * force[c]).abs();
            }
        }
        let mut gap: f64 = 0.0;
        let mut settled = true;
        for touch in touches.iter().flat_map(|t| &t.nodes) {
            gap = gap.max(touch.defect);
            settled &= touch.settled;
            for &(node, push) in &pushes(touch, &touch.now) {
                for c in 0..dim {
                    residual[node as usize * dim + c] -= push[c];
                    size[node as usize * dim + c] += push[c].abs();
                }
            }
        }
        let mut squares = [0.0; 2];
        for k in 0..residual.len() {
            squares[1] += size[k] * size[k];
            if self.equation[k] == HELD {
                let target = self.target(k, state.load);
                settled &= (state.displacement[k / dim][k % dim] - target).abs() <= 1e-12 * (1.0 + target.abs());
            } else {
                squares[0] += residual[k] * residual[k];
            }
        }
        let force = if squares[0] == 0.0 { 0.0 } else { (squares[0] / squares[1]).sqrt() };
        Balance { force, volume, gap, settled }
    }

    /// The tangent, and all elements with theirs; those that are `known` are not evaluated again.
    pub(super) fn assemble(
        &mut self,
        state: &State,
        known: Vec<ElementSystem>,
        touches: &[Touching],
    ) -> Result<Vec<ElementSystem>, StepError> {
        self.prepare(touches)?;
        let problem = self.problem;
        let dim = problem.kinematics.dim();
        let mut systems = Vec::with_capacity(problem.mesh.element_count());
        let mut tangent = self.tangent.take().ok_or(SparseError::TooLarge)?;
        tangent.clear();
        let elements: Vec<usize> = (0..problem.mesh.element_count()).collect();
        let is_known = !known.is_empty();
        let mut known = known.into_iter();
        for chunk in elements.chunks(CHUNK) {
            let chunk_systems: Option<Vec<ElementSystem>> = match is_known {
                true => Some(known.by_ref().take(chunk.len()).collect()),
                false => chunk.par_iter().map(|&e| self.element(e, state, Some(self.bulk_kpa(e)))).collect(),
            };
            let Some(mut chunk_systems) = chunk_systems else {
                self.tangent = Some(tangent);
                return Err(StepError::InsideOut);
            };
            let of = |e: usize| (problem.mesh.element(e), chunk_systems[e - chunk[0]].stiffness.as_slice());
            self.add_elements(&mut tangent, &chunk.iter().map(|&e| of(e)).collect::<Vec<_>>());
            chunk_systems.par_iter_mut().zip(chunk).for_each(|(system, &e)| {
                let unknowns = unknowns(problem.mesh.element(e), dim);
                system.stiffness = held_columns(&unknowns, &self.equation, &system.stiffness);
            });
            systems.append(&mut chunk_systems);
        }
        self.add_contacts(&mut tangent, touches);
        if self.damping.share > 0.0 {
            for (node, stiffness) in self.own_stiffness.chunks(dim).enumerate() {
                let mut block = [0.0; 9];
                (0..dim).for_each(|c| block[4 * c] = self.damping.share * stiffness[c]);
                self.add_pair(&mut tangent, node as u32, node as u32, &block);
            }
        }
        self.tangent = Some(tangent);
        Ok(systems)
    }

    /// Bulk modulus that an element has in the tangent, kPa.
    pub(super) fn bulk_kpa(&self, e: usize) -> f64 {
        match self.method {
            LinearSolver::Direct => self.tangent_bulk_kpa,
            LinearSolver::Multigrid => {
                let material = &self.problem.materials[self.problem.mesh.region[e] as usize];
                BULK * material.law.shear_kpa()
            }
        }
    }

    /// Makes sure that the pattern holds all pairs that now bear on each other. A new one holds those that only face
    /// each other too: they may bear next.
    fn prepare(&mut self, touches: &[Touching]) -> Result<(), SparseError> {
        let group = |touch: &Touch| touch.gap.moved.iter().map(|entry| entry.0).collect::<Vec<u32>>();
        let touching = || touches.iter().flat_map(|t| &t.nodes);
        let known = |tangent: &Tangent| touching().filter(|t| t.bears()).all(|touch| tangent.couples(&group(touch)));
        if self.tangent.as_ref().is_some_and(known) {
            return Ok(());
        }
        let contacts: Vec<Vec<u32>> = touching().map(group).collect();
        let (mesh, dim) = (&self.problem.mesh, self.problem.kinematics.dim());
        self.tangent = Some(match self.method {
            LinearSolver::Direct => {
                let mut groups: Vec<Vec<u32>> = (0..mesh.element_count()).map(|e| mesh.element(e).to_vec()).collect();
                groups.extend(contacts);
                let mut first = vec![0];
                for unknowns in self.equation.chunks(dim) {
                    let free = unknowns.iter().filter(|e| **e != HELD).count() as u32;
                    first.push(first.last().map_or(0, |last| last + free));
                }
                Tangent::Direct(Box::new(SparseLdl::new(first, &mesh.nodes, &groups)?))
            }
            LinearSolver::Multigrid => {
                let held = (0..mesh.nodes.len() as u32).map(|node| self.held(node)).collect();
                Tangent::Multigrid(Box::new(Multigrid::new(mesh, held, &contacts)))
            }
        });
        self.symbolic += 1;
        Ok(())
    }

    /// Adds the stiffnesses of elements, given with their nodes.
    fn add_elements(&self, tangent: &mut Tangent, elements: &[(&[u32], &[f64])]) {
        match tangent {
            Tangent::Direct(matrix) => {
                let dim = self.problem.kinematics.dim();
                for (nodes, stiffness) in elements {
                    let numbers: Vec<u32> = unknowns(nodes, dim).iter().map(|&k| self.equation[k]).collect();
                    matrix.add(nodes, &numbers, stiffness);
                }
            }
            Tangent::Multigrid(multigrid) => multigrid.add_elements(elements),
        }
    }

    /// Adds to the stiffness of a pair of nodes, in this order.
    fn add_pair(&self, tangent: &mut Tangent, row: u32, column: u32, block: &[f64; 9]) {
        match tangent {
            Tangent::Direct(matrix) => {
                let dim = self.problem.kinematics.dim();
                for i in 0..dim {
                    for j in 0..dim {
                        let [row, column] =
                            [row as usize * dim + i, column as usize * dim + j].map(|k| self.equation[k]);
                        if row >= column
                            && row != HELD
                            && column != HELD
                            && let Some(place) = matrix.position(row, column)
                        {
                            matrix.values[place] += block[3 * i + j];
                        }
                    }
                }
            }
            Tangent::Multigrid(multigrid) => multigrid.add_pair(row, column, block),
        }
    }

    fn add_contacts(&self, tangent: &mut Tangent, touches: &[Touching]) {
        for touch in touches.iter().flat_map(|t| &t.nodes).filter(|touch| touch.hold != Hold::Free) {
            let normal = touch.spring / touch.gap.area;
            let along = touch.along.map(|row| row.map(|spring| spring / touch.gap.area));
            for (a, m, n) in &touch.gap.moved {
                for (b, o, p) in &touch.gap.moved {
                    let entry = |i: usize, j: usize| normal * n[i] * p[j] + m * o * along[i][j];
                    self.add_pair(tangent, *a, *b, &std::array::from_fn(|k| entry(k / 3, k % 3)));
                }
            }
        }
        for (a, b, stiffness) in touches.iter().flat_map(|t| &t.bending.even) {
            self.add_pair(tangent, *a, *b, &std::array::from_fn(|k| stiffness[k / 3][k % 3]));
        }
    }

    /// Newton's step.
    pub(super) fn solve(
        &mut self,
        state: &State,
        systems: &[ElementSystem],
        touches: &[Touching],
        balance: Balance,
    ) -> Result<Change, StepError> {
        let mut tangent = self.tangent.take().ok_or(SparseError::TooLarge)?;
        let (held, right) = self.right_side(state, systems, touches);
        let solved = match &mut tangent {
            Tangent::Direct(matrix) => self.solve_directly(matrix, held, &right, systems, touches),
            Tangent::Multigrid(multigrid) => {
                self.solve_iteratively(multigrid, held, right, systems, touches, balance.worth(self.within))
            }
        };
        self.tangent = Some(tangent);
        solved
    }

    /// Motion of the held components, and the forces on all that it and the state leave.
    fn right_side(&self, state: &State, systems: &[ElementSystem], touches: &[Touching]) -> (Vec<f64>, Vec<f64>) {
        let problem = self.problem;
        let dim = problem.kinematics.dim();
        let mut right = vec![0.0; self.prescribed.len()];
        let mut change = vec![0.0; self.prescribed.len()];
        for k in 0..change.len() {
            if self.equation[k] == HELD {
                change[k] = self.target(k, state.load) - state.displacement[k / dim][k % dim];
            }
        }
        for (e, system) in systems.iter().enumerate() {
            let unknowns = unknowns(problem.mesh.element(e), dim);
            let n = unknowns.len();
            unknowns.iter().zip(&system.condensed).for_each(|(&k, f)| right[k] -= f);
            let held = unknowns.iter().filter(|&&k| self.equation[k] == HELD);
            for (&k, column) in held.zip(system.stiffness.chunks(n)) {
                unknowns.iter().zip(column).for_each(|(&row, value)| right[row] -= value * change[k]);
            }
        }
        for &(node, force) in &problem.forces {
            (0..dim).for_each(|c| right[node as usize * dim + c] += state.load * force[c]);
        }
        for touch in touches.iter().flat_map(|t| &t.nodes) {
            // Prescribed motion of held nodes in contact moves the gap too.
            for (node, push) in pushes(touch, &touch.stepped(&change, dim)) {
                (0..dim).for_each(|c| right[node as usize * dim + c] += push[c]);
            }
        }
        (change, right)
    }

    fn solve_directly(
        &self,
        matrix: &mut SparseLdl,
        mut change: Vec<f64>,
        right: &[f64],
        systems: &[ElementSystem],
        touches: &[Touching],
    ) -> Result<Change, StepError> {
        matrix.factorize()?;
        let mut vector: Vec<f64> = self.free(right);
        matrix.solve(&mut vector);
        if let Some(odd) = self.odd(touches) {
            // The matrix lacks what is not symmetric.
            let mut spread = vec![0.0; self.prescribed.len()];
            let mut multiply = |v: &[f64]| {
                for (&e, s) in self.equation.iter().zip(&mut spread).filter(|(e, _)| **e != HELD) {
                    *s = v[e as usize];
                }
                let mut next = self.free(&odd(&spread));
                matrix.solve(&mut next);
                next.iter_mut().zip(v).for_each(|(next, v)| *next += v);
                next
            };
            vector = gmres(vector, &mut multiply, ODD_TOLERANCE, ODD_DIRECTIONS).0;
        }
        for (k, &e) in self.equation.iter().enumerate().filter(|(_, e)| **e != HELD) {
            change[k] = vector[e as usize];
        }
        let dim = self.problem.kinematics.dim();
        let mut pressure = Vec::new();
        for (e, system) in systems.iter().enumerate() {
            let unknowns = unknowns(self.problem.mesh.element(e), dim);
            let rows = system.pressure_slope.chunks(unknowns.len()).zip(system.pressure_defect);
            let along = |slope: &[f64]| unknowns.iter().zip(slope).map(|(&k, s)| s * change[k]).sum::<f64>();
            pressure.extend(rows.map(|(slope, defect)| defect + along(slope)));
        }
        let traction = touches.iter().map(|t| t.nodes.iter().map(|touch| touch.step(&change, dim)).collect()).collect();
        Ok(Change { displacement: change, pressure, traction })
    }

    /// Forces by a motion that the symmetric tangent lacks, where there are any.
    pub(super) fn odd<'t>(&'t self, touches: &'t [Touching]) -> Option<impl Fn(&[f64]) -> Vec<f64> + 't> {
        let dim = self.problem.kinematics.dim();
        let dragged: Vec<_> = touches.iter().flat_map(|t| &t.nodes).filter(|t| t.is_odd()).collect();
        let odd: Vec<&Coupling> = touches.iter().flat_map(|t| &t.bending.odd).collect();
        let forces = move |motion: &[f64]| {
            let mut force = vec![0.0; motion.len()];
            for touch in &dragged {
                for (a, push) in pushes(touch, &touch.odd_answer(motion, dim)) {
                    (0..dim).for_each(|i| force[a as usize * dim + i] -= push[i]);
                }
            }
            for (a, b, k) in &odd {
                for i in 0..dim {
                    let pull: f64 = (0..dim).map(|j| k[i][j] * motion[*b as usize * dim + j]).sum();
                    force[*a as usize * dim + i] += pull;
                }
            }
            force
        };
        let any = touches.iter().any(|t| !t.bending.odd.is_empty() || t.nodes.iter().any(|t| t.is_odd()));
        any.then_some(forces)
    }

    /// The free ones of all components.
    fn free(&self, all: &[f64]) -> Vec<f64> {
        all.iter().zip(&self.equation).filter(|(_, e)| **e != HELD).map(|(value, _)| *value).collect()
    }
}

/// Sum over elements of shear modulus, volume and squared gradient of each node's shape function, mN/mm.
pub(super) fn own_stiffness(problem: &Problem) -> Vec<f64> {
    gathered(problem, |gradient| gradient.iter().map(|g| g * g).sum())
}

/// Sum over elements of shear modulus, volume and gradient of each node's shape function, times `FLOOR_STRAIN`.
pub(super) fn floor(problem: &Problem) -> Vec<f64> {
    gathered(problem, |gradient| FLOOR_STRAIN * gradient.iter().map(|g| g * g).sum::<f64>().sqrt())
}

/// Sum over elements of shear modulus, volume and a size of the gradient of each node's shape function.
fn gathered(problem: &Problem, size: impl Fn(&[f64; 3]) -> f64 + Sync) -> Vec<f64> {
    let dim = problem.kinematics.dim();
    let of = |e: usize| -> Vec<f64> {
        let nodes = problem.mesh.element_positions(e);
        let shear = problem.materials[problem.mesh.region[e] as usize].law.shear_kpa();
        let points = quadrature(dim).iter().filter_map(|at| problem.kinematics.point(&nodes, at));
        let here = |volume: f64, gradient: &[f64; 3]| shear * volume * size(gradient);
        points.flat_map(|point| point.gradient.iter().map(|g| here(point.volume, g)).collect::<Vec<_>>()).collect()
    };
    let mut sum = vec![0.0; problem.mesh.nodes.len() * dim];
    let elements: Vec<usize> = (0..problem.mesh.element_count()).collect();
    for chunk in elements.chunks(CHUNK) {
        let own: Vec<Vec<f64>> = chunk.par_iter().map(|&e| of(e)).collect();
        for (&e, own) in chunk.iter().zip(&own) {
            for (&a, here) in problem.mesh.element(e).iter().cycle().zip(own) {
                (0..dim).for_each(|c| sum[a as usize * dim + c] += here);
            }
        }
    }
    sum
}

/// Rows of the tangent's columns at held unknowns; the rest is in the matrix.
fn held_columns(unknowns: &[usize], equation: &[u32], stiffness: &[f64]) -> Vec<f64> {
    let n = unknowns.len();
    let held = (0..n).filter(|&j| equation[unknowns[j]] == HELD);
    held.flat_map(|j| (0..n).map(move |i| stiffness[i * n + j])).collect()
}

pub(super) fn unknowns(element: &[u32], dim: usize) -> Vec<usize> {
    element.iter().flat_map(|&a| (0..dim).map(move |c| a as usize * dim + c)).collect()
}
