//! Newton's method over displacement, pressure and contact traction.

use super::contact::{Coupling, Grip, NodeGap, Positions, SPRING};
use super::element::quadrature;
use super::material::History;
use super::problem::{Problem, State, Traction};
use super::solid::{ElementSystem, advance_history, element_system, tangent_bulk_kpa};
use super::sparse::{SparseCholesky, SparseError};
use rayon::prelude::*;
use thiserror::Error;

/// What a solver holds over many steps: numbering, pattern, factor.
pub struct Solver<'a> {
    problem: &'a Problem,
    /// Equation of each displacement component; `HELD` where it is prescribed.
    equation: Vec<u32>,
    equations: usize,
    /// Prescribed displacement of each component at load factor 1.
    prescribed: Vec<f64>,
    matrix: Option<SparseCholesky>,
    tangent_bulk_kpa: f64,
    /// Forces of a strain of `FLOOR_STRAIN`, mN.
    floor: Vec<f64>,
    /// Time of the present step, s.
    seconds: f64,
    /// Newton iterations so far.
    pub iterations: usize,
    /// Symbolic factorisations so far.
    pub symbolic: usize,
}

const HELD: u32 = u32::MAX;

/// When a state counts as balanced.
const FORCE_TOLERANCE: f64 = 1e-9;
/// Strain whose stresses count among the size of the forces: pressures are only known to the rounding of F times the
/// tangent's bulk modulus, 1e-12 mu.
const FLOOR_STRAIN: f64 = 1e-3;
/// Largest mean volume defect.
const VOLUME_TOLERANCE: f64 = 1e-9;
/// Largest gap of nodes in contact and largest slip of sticking ones, mm.
const GAP_TOLERANCE: f64 = 1e-8;
/// Newton iterations of one load step.
const ITERATIONS: usize = 40;
/// Rounds of friction in a step.
const FRICTION_ROUNDS: usize = 30;
/// Largest change of the friction's bound between rounds, as a share of its largest.
const FRICTION_TOLERANCE: f64 = 1e-5;
/// Newton iterations without progress in a step before it is given up.
const PATIENCE: usize = 3;
/// Rise of the forces' residual above its least at which a step is given up, and the least that counts.
const RISE: f64 = 10.0;
const WORTH: f64 = 1e-2;
/// Halvings of a Newton step that turns an element inside out.
const HALVINGS: usize = 10;
/// Elements evaluated at a time.
const CHUNK: usize = 512;

/// Why a load step did not converge.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StepError {
    /// The iterations did not settle.
    #[error(
        "no balance after {iterations} iterations: forces off by {force:.1e} of their size, volume by {volume:.1e}, contact by {gap:.1e} mm"
    )]
    Diverged {
        /// Iterations.
        iterations: usize,
        /// Relative residual of the forces.
        force: f64,
        /// Largest volume defect.
        volume: f64,
        /// Largest gap in contact, mm.
        gap: f64,
    },
    /// The rounds of friction did not settle.
    #[error("the friction does not settle")]
    Friction,
    /// An element turned inside out however short the step.
    #[error("an element turns inside out")]
    InsideOut,
    /// The linear system.
    #[error(transparent)]
    Sparse(#[from] SparseError),
}

impl StepError {
    /// Whether the matrix does not fit in memory.
    pub fn is_too_large(&self) -> bool {
        matches!(self, Self::Sparse(SparseError::TooLarge | SparseError::Memory { .. }))
    }
}

/// How far a state is from balance.
#[derive(Debug, Clone, Copy)]
struct Balance {
    force: f64,
    volume: f64,
    gap: f64,
    settled: bool,
}

impl Balance {
    fn holds(&self) -> bool {
        self.settled && self.force <= FORCE_TOLERANCE && self.volume <= VOLUME_TOLERANCE && self.gap <= GAP_TOLERANCE
    }
}

/// A contact in a state.
struct Touching {
    nodes: Vec<Touch>,
    /// Stiffness from the bending of the gaps under pressure.
    stiffness: Vec<Coupling>,
}

/// What a touched node does in a state.
struct Touch {
    gap: NodeGap,
    /// Traction that the residual uses.
    now: Traction,
    /// Traction that the next step starts from: with the spring's share.
    trial: Traction,
    /// Spring against the normal gap and against slip (or any offset), kPa per mm; 0 where free.
    spring: [f64; 2],
    /// What is left of the constraint, mm.
    defect: f64,
    settled: bool,
}

impl<'a> Solver<'a> {
    /// Numbers the unknowns of a problem.
    pub fn new(problem: &'a Problem) -> Self {
        let dim = problem.kinematics.dim();
        let mut prescribed = vec![0.0; problem.mesh.nodes.len() * dim];
        let mut equation = vec![0; prescribed.len()];
        for support in &problem.supports {
            let k = support.node as usize * dim + support.axis;
            prescribed[k] = support.displacement_mm;
            equation[k] = HELD;
        }
        let mut equations = 0;
        for e in equation.iter_mut().filter(|e| **e != HELD) {
            *e = equations;
            equations += 1;
        }
        Self {
            problem,
            equation,
            equations: equations as usize,
            prescribed,
            matrix: None,
            tangent_bulk_kpa: tangent_bulk_kpa(&problem.materials),
            floor: floor(problem),
            seconds: 0.0,
            iterations: 0,
            symbolic: 0,
        }
    }

    /// The state at load factor `load` after the balanced state `from`, sought from `guess`. Friction is found in rounds: each bears what the pressures of
    /// the last one allow.
    ///
    /// # Errors
    /// [`StepError`] where the step is too long or the structure unstable.
    pub fn step(&mut self, from: &State, guess: &State, load: f64) -> Result<State, StepError> {
        let seconds = self.problem.seconds_per_load.map_or(f64::INFINITY, |s| s * (load - from.load).abs());
        self.over(from, guess, load, seconds)
    }

    /// The states' line, continued to a load; `None` where it turns an element inside out.
    pub fn extrapolated(&self, before: &State, last: &State, load: f64) -> Option<State> {
        let share = (load - last.load) / (last.load - before.load);
        let line = |a: f64, b: f64| b + share * (b - a);
        let mut next = last.clone();
        next.load = load;
        for (next, before) in next.displacement.iter_mut().zip(&before.displacement) {
            (0..3).for_each(|i| next[i] = line(before[i], next[i]));
        }
        next.pressure.iter_mut().zip(&before.pressure).for_each(|(next, before)| *next = line(*before, *next));
        for (next, before) in next.traction.iter_mut().flatten().zip(before.traction.iter().flatten()) {
            if next.normal > 0.0 {
                next.normal = line(before.normal, next.normal).max(0.5 * next.normal);
            }
            (0..3).for_each(|i| next.vector[i] = line(before.vector[i], next.vector[i]));
        }
        let sound = |e| self.element(e, &next, None).is_some();
        (share.is_finite() && (0..next.history.len()).into_par_iter().all(sound)).then_some(next)
    }

    /// The state after the load was held for a time, s.
    ///
    /// # Errors
    /// [`StepError`].
    pub fn hold(&mut self, from: &State, seconds: f64) -> Result<State, StepError> {
        self.over(from, from, from.load, seconds)
    }

    fn over(&mut self, from: &State, guess: &State, load: f64, seconds: f64) -> Result<State, StepError> {
        let mut state = self.round(from, guess, load, seconds)?;
        for _ in 0..FRICTION_ROUNDS {
            if self.renew_friction(from, &mut state) <= FRICTION_TOLERANCE {
                state.history = self.remember(&state, from, seconds).ok_or(StepError::InsideOut)?;
                return Ok(state);
            }
            state = self.round(from, &state, load, seconds)?;
        }
        Err(StepError::Friction)
    }

    /// Memory of the materials at the end of a step.
    fn remember(&self, state: &State, from: &State, seconds: f64) -> Option<Vec<Vec<History>>> {
        let advance = |(e, history): (usize, &Vec<History>)| {
            if history.is_empty() {
                return Some(Vec::new());
            }
            let (nodes, element) = self.nodes(e);
            let displacement: Vec<[f64; 3]> = element.iter().map(|&a| state.displacement[a as usize]).collect();
            let material = &self.problem.materials[self.problem.mesh.region[e] as usize];
            advance_history(self.problem.kinematics, &nodes, &displacement, material, history, seconds)
        };
        from.history.iter().enumerate().map(advance).collect()
    }

    /// Sets the bounds of friction from the pressures; the largest change as a share of the largest bound. A node that did
    /// not touch at the step's start bears none yet: its way before it touched is no slip.
    fn renew_friction(&self, from: &State, state: &mut State) -> f64 {
        let (mut change, mut largest) = (0.0f64, f64::MIN_POSITIVE);
        let lists = from.traction.iter().zip(&mut state.traction);
        for (contact, (before, list)) in self.problem.contacts.iter().zip(lists) {
            let Grip::Coulomb(friction) = contact.grip else { continue };
            for (before, traction) in before.iter().zip(list) {
                let bound = if before.normal > 0.0 { friction * traction.normal.max(0.0) } else { 0.0 };
                change = change.max((bound - traction.bound).abs());
                largest = largest.max(bound);
                traction.bound = bound;
            }
        }
        change / largest
    }

    /// Newton's method from the guess `start`, with slip counted from the state `from`.
    fn round(&mut self, from: &State, start: &State, load: f64, seconds: f64) -> Result<State, StepError> {
        self.seconds = seconds;
        let before = self.problem.positions(from);
        let mut state = start.clone();
        state.load = load;
        let mut last = Balance { force: f64::INFINITY, volume: 0.0, gap: 0.0, settled: false };
        let first = self.iterations;
        let mut first_force = f64::INFINITY;
        let (mut best, mut stale) = (f64::INFINITY, 0);
        for iteration in 0..ITERATIONS {
            let touches = self.touches(&state, &before);
            let (systems, balance) = self.evaluate(&state, &touches)?;
            last = balance;
            if balance.holds() {
                return Ok(state);
            }
            let off = balance.force + balance.volume;
            if balance.settled {
                first_force = first_force.min(balance.force.max(WORTH));
                if iteration > 0 && balance.force > RISE * first_force {
                    break;
                }
            }
            // The first balance is that of the last step, and contacts that open or close are progress too.
            if iteration == 0 || !balance.settled {
                (best, stale) = (f64::INFINITY, 0);
            } else if off < 0.5 * best {
                best = off;
            } else if stale < PATIENCE {
                stale += 1;
            } else {
                break;
            }
            self.iterations += 1;
            let change = self.solve(&state, &systems, &touches)?;
            state = self.advance(&state, &systems, &touches, &change)?;
        }
        Err(StepError::Diverged {
            iterations: self.iterations - first,
            force: last.force,
            volume: last.volume,
            gap: last.gap,
        })
    }

    /// The problem.
    pub fn problem(&self) -> &'a Problem {
        self.problem
    }

    /// Bytes of the last factor.
    pub fn factor_bytes(&self) -> usize {
        self.matrix.as_ref().map_or(0, SparseCholesky::factor_bytes)
    }

    fn nodes(&self, e: usize) -> (Vec<[f64; 3]>, &[u32]) {
        let element = self.problem.mesh.element(e);
        (element.iter().map(|&a| self.problem.mesh.nodes[a as usize]).collect(), element)
    }

    fn element(&self, e: usize, state: &State, tangent_bulk_kpa: Option<f64>) -> Option<ElementSystem> {
        let (nodes, element) = self.nodes(e);
        let displacement: Vec<[f64; 3]> = element.iter().map(|&a| state.displacement[a as usize]).collect();
        let pressures = self.problem.kinematics.dim() + 1;
        let material = &self.problem.materials[self.problem.mesh.region[e] as usize];
        let pressure = &state.pressure[e * pressures..(e + 1) * pressures];
        let history = Some((state.history[e].as_slice(), self.seconds));
        element_system(self.problem.kinematics, &nodes, &displacement, pressure, material, history, tangent_bulk_kpa)
    }

    fn touches(&self, state: &State, before: &[[f64; 3]]) -> Vec<Touching> {
        let now = self.problem.positions(state);
        let at = Positions { reference: &self.problem.mesh.nodes, before, now: &now };
        let contacts = self.problem.contacts.iter().zip(&state.traction);
        contacts
            .map(|(contact, traction)| {
                let pressure: Vec<f64> = traction.iter().map(|t| t.normal).collect();
                let (gaps, stiffness) = contact.gaps(at, &pressure);
                let held = traction.iter().zip(&contact.spring);
                let touch = |(gap, (&now, &spring))| touch(contact.grip, gap, now, spring);
                Touching { nodes: gaps.into_iter().zip(held).map(touch).collect(), stiffness }
            })
            .collect()
    }

    /// All elements with their tangents, and how far the state is from balance.
    fn evaluate(&mut self, state: &State, touches: &[Touching]) -> Result<(Vec<ElementSystem>, Balance), StepError> {
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
        for touch in touches.iter().flat_map(|t| &t.nodes).filter(|touch| touch.spring != [0.0; 2]) {
            let projector = tangential(&touch.gap, touch.spring[0] > 0.0);
            let [normal, along] = touch.spring.map(|spring| spring / touch.gap.area);
            for (a, m, n) in &touch.gap.moved {
                for (b, o, p) in &touch.gap.moved {
                    for i in 0..dim {
                        for j in 0..dim {
                            let value = normal * n[i] * p[j] + along * m * o * projector[i][j];
                            add(*a, i, *b, j, value);
                        }
                    }
                }
            }
        }
        for (a, b, stiffness) in touches.iter().flat_map(|t| &t.stiffness) {
            for i in 0..dim {
                for j in 0..dim {
                    add(*a, i, *b, j, stiffness[i][j]);
                }
            }
        }
    }

    /// Newton's step of the displacements.
    fn solve(&mut self, state: &State, systems: &[ElementSystem], touches: &[Touching]) -> Result<Vec<f64>, StepError> {
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
            for (node, push) in pushes(touch, &touch.trial) {
                (0..dim).for_each(|c| right[node as usize * dim + c] += push[c]);
            }
            // Prescribed motion of held nodes in contact moves the gap too.
            let [normal, along] = touch.spring.map(|s| if touch.gap.area > 0.0 { s / touch.gap.area } else { 0.0 });
            let (gap, offset) = moved(&touch.gap, &change, dim);
            let projector = tangential(&touch.gap, touch.spring[0] > 0.0);
            for (a, m, n) in &touch.gap.moved {
                for i in 0..dim {
                    let slip: f64 = (0..dim).map(|j| projector[i][j] * offset[j]).sum();
                    right[*a as usize * dim + i] -= normal * n[i] * gap + along * m * slip;
                }
            }
        }
        let mut vector = vec![0.0; self.equations];
        for (k, &e) in self.equation.iter().enumerate().filter(|(_, e)| **e != HELD) {
            vector[e as usize] = right[k];
        }
        let matrix = self.matrix.as_mut().ok_or(SparseError::TooLarge)?;
        matrix.factorize()?;
        matrix.solve(&mut vector);
        for (k, &e) in self.equation.iter().enumerate().filter(|(_, e)| **e != HELD) {
            change[k] = vector[e as usize];
        }
        Ok(change)
    }

    /// Moves a state along Newton's step, as far as no element turns inside out.
    fn advance(
        &self,
        state: &State,
        systems: &[ElementSystem],
        touches: &[Touching],
        change: &[f64],
    ) -> Result<State, StepError> {
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let next = self.moved(state, systems, touches, change, share);
            let sound = (0..systems.len()).into_par_iter().all(|e| self.element(e, &next, None).is_some());
            if sound {
                return Ok(next);
            }
            share *= 0.5;
        }
        Err(StepError::InsideOut)
    }

    fn moved(
        &self,
        state: &State,
        systems: &[ElementSystem],
        touches: &[Touching],
        change: &[f64],
        share: f64,
    ) -> State {
        let dim = self.problem.kinematics.dim();
        let mut next = state.clone();
        for (k, du) in change.iter().enumerate() {
            next.displacement[k / dim][k % dim] += share * du;
        }
        for (e, system) in systems.iter().enumerate() {
            let unknowns = unknowns(self.problem.mesh.element(e), dim);
            for p in 0..=dim {
                let slope = &system.pressure_slope[p * unknowns.len()..];
                let moved: f64 = unknowns.iter().zip(slope).map(|(&k, s)| s * change[k]).sum();
                next.pressure[e * (dim + 1) + p] += share * (system.pressure_defect[p] + moved);
            }
        }
        for (list, touching) in next.traction.iter_mut().zip(touches) {
            for (traction, touch) in list.iter_mut().zip(&touching.nodes) {
                let target = touch.stepped(change, dim);
                traction.normal = touch.now.normal + share * (target.normal - touch.now.normal);
                for i in 0..3 {
                    traction.vector[i] = touch.now.vector[i] + share * (target.vector[i] - touch.now.vector[i]);
                }
            }
        }
        next
    }
}

/// Sum over elements of shear modulus, volume and gradient of each node's shape function, times `FLOOR_STRAIN`.
fn floor(problem: &Problem) -> Vec<f64> {
    let dim = problem.kinematics.dim();
    let mut floor = vec![0.0; problem.mesh.nodes.len() * dim];
    for e in 0..problem.mesh.element_count() {
        let nodes = problem.mesh.element_positions(e);
        let shear = problem.materials[problem.mesh.region[e] as usize].law.shear_kpa();
        for point in quadrature(dim).iter().filter_map(|at| problem.kinematics.point(&nodes, at)) {
            for (&a, gradient) in problem.mesh.element(e).iter().zip(&point.gradient) {
                let size = FLOOR_STRAIN * shear * point.volume * gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
                (0..dim).for_each(|c| floor[a as usize * dim + c] += size);
            }
        }
    }
    floor
}

/// Rows of the tangent's columns at held unknowns; the rest is in the matrix.
fn held_columns(unknowns: &[usize], equation: &[u32], stiffness: &[f64]) -> Vec<f64> {
    let n = unknowns.len();
    let held = (0..n).filter(|&j| equation[unknowns[j]] == HELD);
    held.flat_map(|j| (0..n).map(move |i| stiffness[i * n + j])).collect()
}

fn unknowns(element: &[u32], dim: usize) -> Vec<usize> {
    element.iter().flat_map(|&a| (0..dim).map(move |c| a as usize * dim + c)).collect()
}

/// What the traction of a touched node does to the nodes that move its gap.
fn pushes(touch: &Touch, traction: &Traction) -> Vec<(u32, [f64; 3])> {
    let push = |m: f64, n: &[f64; 3]| [0, 1, 2].map(|i| traction.normal * n[i] + traction.vector[i] * m);
    touch.gap.moved.iter().map(|(a, m, n)| (*a, push(*m, n))).collect()
}

/// Integrals of hat times normal gap and times offset that a displacement adds.
fn moved(gap: &NodeGap, change: &[f64], dim: usize) -> (f64, [f64; 3]) {
    let (mut normal, mut offset) = (0.0, [0.0; 3]);
    for (a, m, n) in &gap.moved {
        for i in 0..dim {
            let du = change[*a as usize * dim + i];
            normal += n[i] * du;
            offset[i] += m * du;
        }
    }
    (normal, offset)
}

/// Projector on the face where slip is tangential; the identity for bonded faces.
fn tangential(gap: &NodeGap, unilateral: bool) -> [[f64; 3]; 3] {
    let square: f64 = gap.normal.iter().map(|n| n * n).sum();
    let keep =
        |i: usize, j: usize| if unilateral && square > 0.0 { gap.normal[i] * gap.normal[j] / square } else { 0.0 };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| f64::from(i == j) - keep(i, j)))
}

/// Decides what a node does: bonded, free, sticking or slipping.
fn touch(grip: Grip, gap: NodeGap, now: Traction, spring: f64) -> Touch {
    if gap.area <= 0.0 {
        let free = Traction::default();
        return Touch { gap, now: free, trial: free, spring: [0.0; 2], defect: 0.0, settled: now.normal == 0.0 };
    }
    let offset = gap.offset.map(|o| o / gap.area);
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let pulled = [0, 1, 2].map(|i| now.vector[i] - spring * offset[i]);
    if grip == Grip::Bonded {
        let trial = Traction { vector: pulled, ..Traction::default() };
        return Touch { gap, now, trial, spring: [0.0, spring], defect: length(offset), settled: true };
    }
    let mean = gap.gap / gap.area;
    let pressed = now.normal - spring * mean;
    // What decides is a spring as stiff as the body: a stiffer one would let go at each curved step.
    if now.normal - spring / SPRING * mean <= 0.0 {
        let free = Traction { bound: now.bound, ..Traction::default() };
        return Touch { gap, now: free, trial: free, spring: [0.0; 2], defect: 0.0, settled: now.normal <= 0.0 };
    }
    let settled = now.normal > 0.0;
    let bound = now.bound;
    if bound == 0.0 {
        let now = Traction { normal: now.normal, ..Traction::default() };
        let trial = Traction { normal: pressed, ..now };
        return Touch { gap, now, trial, spring: [spring, 0.0], defect: mean.abs(), settled };
    }
    let soft = [0, 1, 2].map(|i| now.vector[i] - spring / SPRING * offset[i]);
    let pull = length(soft);
    if pull <= bound {
        let trial = Traction { normal: pressed, vector: pulled, bound };
        let defect = mean.abs().max(length(offset));
        return Touch { gap, now, trial, spring: [spring, spring], defect, settled };
    }
    let slipping = soft.map(|c| c * bound / pull);
    let lag = length([0, 1, 2].map(|i| slipping[i] - now.vector[i]));
    let settled = settled && lag <= 1e-6 * bound;
    let now = Traction { normal: now.normal, vector: slipping, bound };
    let trial = Traction { normal: pressed, ..now };
    Touch { gap, now, trial, spring: [spring, 0.0], defect: mean.abs(), settled }
}

impl Touch {
    /// Traction after a full Newton step.
    fn stepped(&self, change: &[f64], dim: usize) -> Traction {
        let (gap, offset) = moved(&self.gap, change, dim);
        let [normal, along] = self.spring.map(|s| if self.gap.area > 0.0 { s / self.gap.area } else { 0.0 });
        let projector = tangential(&self.gap, self.spring[0] > 0.0);
        let mut next = self.trial;
        next.normal -= normal * gap;
        for i in 0..dim {
            next.vector[i] -= along * (0..dim).map(|j| projector[i][j] * offset[j]).sum::<f64>();
        }
        next
    }
}
