//! Newton's linear system: residual, tangent, step.

use super::krylov::gmres;
use super::touch::{Hold, Touching, pushes};
use super::{Balance, CHUNK, FLOOR_STRAIN, HELD, Solver, StepError};
use crate::mechanics::contact::Coupling;
use crate::mechanics::element::quadrature;
use crate::mechanics::problem::{Problem, State};
use crate::mechanics::solid::ElementSystem;
use crate::mechanics::sparse::{SparseCholesky, SparseError};
use rayon::prelude::*;

impl Solver<'_> {
    /// All elements with their tangents, and how far the state is from balance.
    pub(super) fn evaluate(
        &mut self,
        state: &State,
        touches: &[Touching],
    ) -> Result<(Vec<ElementSystem>, Balance), StepError> {
        self.prepare(touches)?;
        let problem = self.problem;
        let dim = problem.kinematics.dim();
        let mut systems = Vec::with_capacity(problem.mesh.element_count());
        let mut residual = vec![0.0; self.prescribed.len()];
        let mut size = self.floor.clone();
        let mut volume: f64 = 0.0;
        let mut matrix = self.matrix.take().ok_or(SparseError::TooLarge)?;
        matrix.values.fill(0.0);
        let elements: Vec<usize> = (0..problem.mesh.element_count()).collect();
        for chunk in elements.chunks(CHUNK) {
            let chunk_systems: Option<Vec<ElementSystem>> =
                chunk.par_iter().map(|&e| self.element(e, state, Some(self.tangent_bulk_kpa))).collect();
            let Some(chunk_systems) = chunk_systems else {
                self.matrix = Some(matrix);
                return Err(StepError::InsideOut);
            };
            for (&e, mut system) in chunk.iter().zip(chunk_systems) {
                let unknowns = unknowns(problem.mesh.element(e), dim);
                for (&k, f) in unknowns.iter().zip(&system.force) {
                    residual[k] += f;
                    size[k] += f.abs();
                }
                volume = volume.max(system.volume_defect);
                self.add_element(&mut matrix, problem.mesh.element(e), &unknowns, &system.stiffness);
                system.stiffness = held_columns(&unknowns, &self.equation, &system.stiffness);
                systems.push(system);
            }
        }
        self.add_contacts(&mut matrix, touches);
        if self.damping.share > 0.0 {
            for (&e, stiffness) in self.equation.iter().zip(&self.own_stiffness).filter(|(e, _)| **e != HELD) {
                if let Some(place) = matrix.position(e, e) {
                    matrix.values[place] += self.damping.share * stiffness;
                }
            }
        }
        self.matrix = Some(matrix);
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
                let target = state.load * self.prescribed[k];
                settled &= (state.displacement[k / dim][k % dim] - target).abs() <= 1e-12 * (1.0 + target.abs());
            } else {
                squares[0] += residual[k] * residual[k];
            }
        }
        let force = if squares[0] == 0.0 { 0.0 } else { (squares[0] / squares[1]).sqrt() };
        Ok((systems, Balance { force, volume, gap, settled }))
    }

    /// Makes sure that the pattern holds all pairs that now touch.
    fn prepare(&mut self, touches: &[Touching]) -> Result<(), SparseError> {
        let touching = touches.iter().flat_map(|t| &t.nodes);
        let contacts: Vec<Vec<u32>> =
            touching.map(|touch| touch.gap.moved.iter().map(|entry| entry.0).collect()).collect();
        if self.matrix.as_ref().is_some_and(|matrix| contacts.iter().all(|group| matrix.couples(group))) {
            return Ok(());
        }
        let (mesh, dim) = (&self.problem.mesh, self.problem.kinematics.dim());
        let mut groups: Vec<Vec<u32>> = (0..mesh.element_count()).map(|e| mesh.element(e).to_vec()).collect();
        groups.extend(contacts);
        let mut first = vec![0];
        for unknowns in self.equation.chunks(dim) {
            let free = unknowns.iter().filter(|e| **e != HELD).count() as u32;
            first.push(first.last().map_or(0, |last| last + free));
        }
        self.matrix = Some(SparseCholesky::new(first, &mesh.nodes, &groups)?);
        self.symbolic += 1;
        Ok(())
    }

    fn add_element(&self, matrix: &mut SparseCholesky, nodes: &[u32], unknowns: &[usize], stiffness: &[f64]) {
        let numbers: Vec<u32> = unknowns.iter().map(|&k| self.equation[k]).collect();
        matrix.add(nodes, &numbers, stiffness);
    }

    fn add_contacts(&self, matrix: &mut SparseCholesky, touches: &[Touching]) {
        let dim = self.problem.kinematics.dim();
        let mut add = |row: u32, i: usize, column: u32, j: usize, value: f64| {
            let (row, column) = (self.equation[row as usize * dim + i], self.equation[column as usize * dim + j]);
            if row >= column
                && row != HELD
                && column != HELD
                && let Some(place) = matrix.position(row, column)
            {
                matrix.values[place] += value;
            }
        };
        for touch in touches.iter().flat_map(|t| &t.nodes).filter(|touch| touch.hold != Hold::Free) {
            let normal = touch.spring / touch.gap.area;
            let along = touch.along.map(|row| row.map(|spring| spring / touch.gap.area));
            for (a, m, n) in &touch.gap.moved {
                for (b, o, p) in &touch.gap.moved {
                    for i in 0..dim {
                        for j in 0..dim {
                            add(*a, i, *b, j, normal * n[i] * p[j] + m * o * along[i][j]);
                        }
                    }
                }
            }
        }
        for (a, b, stiffness) in touches.iter().flat_map(|t| &t.bending.even) {
            for i in 0..dim {
                for j in 0..dim {
                    add(*a, i, *b, j, stiffness[i][j]);
                }
            }
        }
    }

    /// Newton's step of the displacements.
    pub(super) fn solve(
        &mut self,
        state: &State,
        systems: &[ElementSystem],
        touches: &[Touching],
    ) -> Result<Vec<f64>, StepError> {
        let problem = self.problem;
        let dim = problem.kinematics.dim();
        let mut right = vec![0.0; self.prescribed.len()];
        let mut change = vec![0.0; self.prescribed.len()];
        for k in 0..change.len() {
            if self.equation[k] == HELD {
                change[k] = state.load * self.prescribed[k] - state.displacement[k / dim][k % dim];
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
        let vector: Vec<f64> = self.free(&right);
        let mut matrix = self.matrix.take().ok_or(SparseError::TooLarge)?;
        let solved = matrix.factorize().map(|()| {
            let dragged: Vec<_> = touches.iter().flat_map(|t| &t.nodes).filter(|t| t.is_odd()).collect();
            let odd: Vec<&Coupling> = touches.iter().flat_map(|t| &t.bending.odd).collect();
            if dragged.is_empty() && odd.is_empty() {
                let mut vector = vector;
                matrix.solve(&mut vector);
                return vector;
            }
            // The matrix lacks what is not symmetric.
            let mut spread = vec![0.0; self.prescribed.len()];
            gmres(vector, &mut |v| matrix.solve(v), &mut |v| {
                self.equation
                    .iter()
                    .zip(&mut spread)
                    .for_each(|(&e, s)| *s = v.get(e as usize).copied().unwrap_or(0.0));
                let mut force = vec![0.0; self.prescribed.len()];
                for touch in &dragged {
                    for (a, push) in pushes(touch, &touch.odd_answer(&spread, dim)) {
                        (0..dim).for_each(|i| force[a as usize * dim + i] -= push[i]);
                    }
                }
                for (a, b, k) in &odd {
                    for i in 0..dim {
                        let pull: f64 = (0..dim).map(|j| k[i][j] * spread[*b as usize * dim + j]).sum();
                        force[*a as usize * dim + i] += pull;
                    }
                }
                self.free(&force)
            })
        });
        self.matrix = Some(matrix);
        let vector = solved?;
        for (k, &e) in self.equation.iter().enumerate().filter(|(_, e)| **e != HELD) {
            change[k] = vector[e as usize];
        }
        Ok(change)
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
fn gathered(problem: &Problem, size: impl Fn(&[f64; 3]) -> f64) -> Vec<f64> {
    let dim = problem.kinematics.dim();
    let mut sum = vec![0.0; problem.mesh.nodes.len() * dim];
    for e in 0..problem.mesh.element_count() {
        let nodes = problem.mesh.element_positions(e);
        let shear = problem.materials[problem.mesh.region[e] as usize].law.shear_kpa();
        for point in quadrature(dim).iter().filter_map(|at| problem.kinematics.point(&nodes, at)) {
            for (&a, gradient) in problem.mesh.element(e).iter().zip(&point.gradient) {
                let here = shear * point.volume * size(gradient);
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
