//! Newton's method over displacement, pressure and contact traction.
//!
//! Everything that it cannot solve at once is treated the same way: a stiff but finite stand-in in the tangent, the
//! exact equation in the residual. So pressure at the incompressible limit, bonds and contact leave one symmetric
//! matrix of displacements, one symbolic factorisation serves all steps, and the answer does not depend on the
//! stand-ins.
//!
//! The linear systems are factorised, or solved by Krylov's method with multigrid ([`LinearSolver`]): displacements,
//! pressures and tractions together, so that incompressibility does not stiffen the block that multigrid takes, and
//! contact only as far as it bears (docs/decisions/multigrid.md).

mod damping;
mod iterative;
mod krylov;
mod system;
mod touch;

use super::contact::{Positions, SPRING};
use super::material::History;
use super::problem::{Problem, State, Support, Traction};
use super::solid::{ElementSystem, advance_history, element_system, tangent_bulk_kpa};
use super::sparse::SparseError;
use damping::Damping;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use system::{Evaluated, Tangent, floor, own_stiffness};
use thiserror::Error;
use touch::{Hold, Touching, touch};

/// What a solver holds over many steps: numbering, pattern, factor.
pub struct Solver<'a> {
    problem: &'a Problem,
    /// Equation of each displacement component; `HELD` where it is prescribed.
    equation: Vec<u32>,
    /// Prescribed displacement of each component for one load factor, from where the motion last turned.
    prescribed: Vec<f64>,
    /// Displacement and load factor there; none at rest.
    turned: Option<(Vec<[f64; 3]>, f64)>,
    method: LinearSolver,
    tangent: Option<Tangent>,
    tangent_bulk_kpa: f64,
    /// Forces of a strain of `FLOOR_STRAIN`, mN.
    floor: Vec<f64>,
    /// Stiffness of each component's surroundings, mN/mm.
    own_stiffness: Vec<f64>,
    damping: Damping,
    /// Size of the last right side of Krylov's method in the present step.
    last_right: Option<f64>,
    /// How close to balance the present step goes.
    within: Tolerance,
    /// Time of the present step, s.
    seconds: f64,
    /// Newton iterations so far.
    pub iterations: usize,
    /// Cycles of multigrid so far.
    pub cycles: usize,
    /// Symbolic factorisations so far.
    pub symbolic: usize,
}

const HELD: u32 = u32::MAX;

/// How Newton's linear systems are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum LinearSolver {
    /// By factorisation: the fastest in two dimensions and for few unknowns.
    #[default]
    Direct,
    /// By Krylov's method with multigrid, in three dimensions: time and memory grow as the unknowns.
    Multigrid,
}

/// A step of Newton's method.
struct Change {
    /// Displacement of each component, mm.
    displacement: Vec<f64>,
    /// Pressure coefficients, kPa.
    pressure: Vec<f64>,
    /// Tractions of each contact that it starts from, and their change, kPa.
    traction: Vec<Vec<[Traction; 2]>>,
}

/// When a state counts as balanced.
#[derive(Debug, Clone, Copy)]
struct Tolerance {
    /// Residual of the forces, as a share of their size.
    force: f64,
    /// Largest mean volume defect.
    volume: f64,
    /// Largest gap of nodes in contact and largest slip of sticking ones, mm.
    gap_mm: f64,
}

/// Of a state that is read.
const READ: Tolerance = Tolerance { force: 1e-9, volume: 1e-9, gap_mm: 1e-8 };
/// Of one that is only passed on the way: far closer than the next step's guess is.
const PASSED: Tolerance = Tolerance { force: 2e-4, volume: 2e-3, gap_mm: 1e-5 };
/// Strain whose stresses count among the size of the forces: pressures are only known to the rounding of F times the
/// tangent's bulk modulus, 1e-12 mu.
const FLOOR_STRAIN: f64 = 1e-3;
/// Newton iterations of one load step, undamped and damped.
const ITERATIONS: usize = 25;
const DAMPED_ITERATIONS: usize = 120;
/// Newton iterations without progress in a step before it is given up.
const PATIENCE: usize = 5;
/// Rise of the forces' residual above its least at which a step is given up, and the least that counts.
const RISE: f64 = 10.0;
const WORTH: f64 = 1e-2;
/// Iterations that find which nodes touch; the growth of the widest gap seen in them at which a step is given up
/// afterwards, and the least of these gaps, as a share of the load.
const FOUND: usize = 5;
const APART: f64 = 2.0;
const CLOSING: f64 = 0.1;
/// Square of the forces' residual, over what is asked for, below which a step is expected to be the last.
const SQUARE: f64 = 1e-2;
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

/// Whether no contact bears anything.
fn bears_nothing(state: &State) -> bool {
    state.traction.iter().flatten().all(|traction| *traction == Traction::default())
}

impl Balance {
    /// How far it is from what is asked for: the least factor by which something has to fall.
    fn worth(&self, within: Tolerance) -> f64 {
        let left = [within.force / self.force, within.volume / self.volume, within.gap_mm / self.gap];
        left.into_iter().fold(1.0, f64::min)
    }

    /// Whether Newton's next step is expected to be the last: its residual goes as the square of this one.
    fn ends(&self, within: Tolerance) -> bool {
        self.force * self.force < SQUARE * within.force
    }

    fn holds(&self, within: Tolerance) -> bool {
        self.settled && self.force <= within.force && self.volume <= within.volume && self.gap <= within.gap_mm
    }
}

impl<'a> Solver<'a> {
    /// Numbers the unknowns of a problem. In two dimensions all is factorised.
    pub fn new(problem: &'a Problem, method: LinearSolver) -> Self {
        let dim = problem.kinematics.dim();
        let mut prescribed = vec![0.0; problem.mesh.nodes.len() * dim];
        let mut equation = vec![0; prescribed.len()];
        for support in &problem.supports {
            let k = support.node as usize * dim + support.axis;
            prescribed[k] = support.displacement_mm;
            equation[k] = HELD;
        }
        for (number, e) in (0..).zip(equation.iter_mut().filter(|e| **e != HELD)) {
            *e = number;
        }
        Self {
            problem,
            equation,
            prescribed,
            turned: None,
            method: if dim == 3 { method } else { LinearSolver::Direct },
            tangent: None,
            tangent_bulk_kpa: tangent_bulk_kpa(&problem.materials),
            floor: floor(problem),
            own_stiffness: own_stiffness(problem),
            damping: Damping::NONE,
            last_right: None,
            within: READ,
            seconds: 0.0,
            iterations: 0,
            cycles: 0,
            symbolic: 0,
        }
    }

    /// The state at load factor `load` after the balanced state `from`, sought from `guess`. Where Newton's method
    /// fails and `damped` allows, it is tried again with damping: slow, but it gets past loads at which the bodies
    /// snap.
    ///
    /// # Errors
    /// [`StepError`] where the step is too long or the structure unstable.
    pub fn step(&mut self, from: &State, guess: &State, load: f64, damped: bool) -> Result<State, StepError> {
        self.within = READ;
        let seconds = self.problem.seconds_per_load.map_or(f64::INFINITY, |s| s * (load - from.load).abs());
        self.over(from, guess, load, seconds, damped)
    }

    /// As [`Self::step`], to a state that is only passed: roughly in balance, unless the way there counts or faces that
    /// slide are yet to find each other.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn pass(&mut self, from: &State, guess: &State, load: f64, damped: bool) -> Result<State, StepError> {
        if self.problem.way_counts() || self.problem.slides() {
            return self.step(from, guess, load, damped);
        }
        self.within = PASSED;
        self.over(from, guess, load, f64::INFINITY, damped)
    }

    /// Lets held components move otherwise from a state on: `motion` is what they move by for one load factor.
    pub fn turn(&mut self, at: &State, motion: &[Support]) {
        let dim = self.problem.kinematics.dim();
        self.prescribed.fill(0.0);
        for support in motion {
            self.prescribed[support.node as usize * dim + support.axis] = support.displacement_mm;
        }
        self.turned = Some((at.displacement.clone(), at.load));
    }

    /// Prescribed displacement of a component at a load factor, mm.
    fn target(&self, component: usize, load: f64) -> f64 {
        let dim = self.problem.kinematics.dim();
        match &self.turned {
            None => load * self.prescribed[component],
            Some((displacement, from)) => {
                displacement[component / dim][component % dim] + (load - from) * self.prescribed[component]
            }
        }
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
        self.within = READ;
        self.over(from, from, from.load, seconds, true)
    }

    fn over(&mut self, from: &State, guess: &State, load: f64, seconds: f64, damped: bool) -> Result<State, StepError> {
        self.damping = Damping::NONE;
        let mut found = self.balanced(from, guess, load, seconds, ITERATIONS);
        if damped && matches!(found, Err(StepError::Diverged { .. } | StepError::InsideOut)) {
            self.damping = Damping::START;
            found = self.balanced(from, guess, load, seconds, DAMPED_ITERATIONS);
        }
        let mut state = found?;
        state.history = self.remember(&state, from, seconds).ok_or(StepError::InsideOut)?;
        Ok(state)
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

    /// Newton's method from the guess `start`, with slip counted from the state `from`.
    fn balanced(
        &mut self,
        from: &State,
        start: &State,
        load: f64,
        seconds: f64,
        iterations: usize,
    ) -> Result<State, StepError> {
        self.seconds = seconds;
        self.last_right = None;
        let before = self.problem.positions(from);
        let mut state = start.clone();
        state.load = load;
        let damped = self.damping != Damping::NONE;
        let mut last = Balance { force: f64::INFINITY, volume: 0.0, gap: 0.0, settled: false };
        let first = self.iterations;
        let mut first_force = f64::INFINITY;
        let mut widest = CLOSING * (load - from.load).abs();
        let (mut best, mut stale) = (f64::INFINITY, 0);
        let mut held: Vec<Hold> = Vec::new();
        let ahead = self.problem.kinematics.dim() == 2;
        let mut elements = self.evaluate(&state, ahead).ok_or(StepError::InsideOut)?;
        for iteration in 0..iterations {
            let touches = self.touches(&state, &before, iteration == 0 && bears_nothing(&state));
            let mut balance = self.balance(&state, elements.forces, &touches);
            // What was balanced while nodes did something else is no measure of progress.
            let holds: Vec<Hold> = touches.iter().flat_map(|t| t.nodes.iter().map(|touch| touch.hold)).collect();
            let same = held.is_empty() || held == holds;
            held = holds;
            last = balance;
            if balance.holds(self.within) {
                return Ok(state);
            }
            if iteration < FOUND {
                widest = widest.max(balance.gap);
            } else if !damped && balance.gap > APART * widest {
                break;
            }
            balance.settled &= same;
            let off = balance.force + balance.volume;
            if balance.settled {
                first_force = first_force.min(balance.force.max(WORTH));
                if !damped && iteration > 0 && balance.force > RISE * first_force {
                    break;
                }
            }
            // The first balance is that of the last step, and contacts that open or close are progress too.
            if damped || iteration == 0 || !balance.settled {
                (best, stale) = (f64::INFINITY, 0);
            } else if off < 0.5 * best {
                best = off;
            } else if stale < PATIENCE {
                stale += 1;
            } else {
                break;
            }
            let systems = self.assemble(&state, elements.systems, &touches)?;
            self.damping.renew(balance.force, same);
            self.iterations += 1;
            let change = self.solve(&state, &systems, &touches, balance)?;
            (state, elements) = self.advance(&state, &change, ahead && !balance.ends(self.within))?;
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
        self.tangent.as_ref().map_or(0, Tangent::bytes)
    }

    fn nodes(&self, e: usize) -> (Vec<[f64; 3]>, &[u32]) {
        let element = self.problem.mesh.element(e);
        (element.iter().map(|&a| self.problem.mesh.nodes[a as usize]).collect(), element)
    }

    fn element(&self, e: usize, state: &State, tangent_bulk_kpa: Option<f64>) -> Option<ElementSystem> {
        let (nodes, element) = self.nodes(e);
        let displacement: Vec<[f64; 3]> = element.iter().map(|&a| state.displacement[a as usize]).collect();
        let pressures = self.problem.pressures();
        let material = &self.problem.materials[self.problem.mesh.region[e] as usize];
        let pressure = &state.pressure[e * pressures..(e + 1) * pressures];
        let history = Some((state.history[e].as_slice(), self.seconds));
        element_system(self.problem.kinematics, &nodes, &displacement, pressure, material, history, tangent_bulk_kpa)
    }

    /// What touched nodes do; `first` where faces that lie on each other are to be pressed for the first time.
    fn touches(&self, state: &State, before: &[[f64; 3]], first: bool) -> Vec<Touching> {
        let now = self.problem.positions(state);
        let at = Positions { reference: &self.problem.mesh.nodes, before, now: &now };
        let contacts = self.problem.contacts.iter().zip(&state.traction);
        contacts
            .map(|(contact, traction)| {
                let pressure: Vec<f64> = traction.iter().map(|t| t.normal).collect();
                let (gaps, bending) = contact.gaps(at, &pressure);
                let nodes = gaps.into_iter().zip(traction).enumerate();
                let touch = |(k, (gap, &now))| {
                    touch(contact.grip, gap, now, self.springs(contact.spring[k]), self.held(contact.nodes[k]), first)
                };
                Touching { nodes: nodes.map(touch).collect(), bending }
            })
            .collect()
    }

    /// The spring as stiff as the body, and that of the tangent: multigrid bears no stiffness far above the body's, and
    /// has the tractions among its unknowns.
    fn springs(&self, stiff: f64) -> [f64; 2] {
        let soft = stiff / SPRING;
        match self.method {
            LinearSolver::Direct => [soft, stiff],
            LinearSolver::Multigrid => [soft, iterative::CONTACT * soft],
        }
    }

    /// Which displacements of a node are prescribed.
    fn held(&self, node: u32) -> [bool; 3] {
        let dim = self.problem.kinematics.dim();
        [0, 1, 2].map(|axis| axis < dim && self.equation[node as usize * dim + axis] == HELD)
    }

    /// Moves a state along Newton's step, as far as no element turns inside out, and evaluates the elements there,
    /// `ahead` with their tangents.
    fn advance(&self, state: &State, change: &Change, ahead: bool) -> Result<(State, Evaluated), StepError> {
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let next = self.moved(state, change, share);
            if let Some(elements) = self.evaluate(&next, ahead) {
                return Ok((next, elements));
            }
            share *= 0.5;
        }
        Err(StepError::InsideOut)
    }

    fn moved(&self, state: &State, change: &Change, share: f64) -> State {
        let dim = self.problem.kinematics.dim();
        let mut next = state.clone();
        for (k, du) in change.displacement.iter().enumerate() {
            next.displacement[k / dim][k % dim] += share * du;
        }
        next.pressure.iter_mut().zip(&change.pressure).for_each(|(p, dp)| *p += share * dp);
        for (traction, [from, by]) in next.traction.iter_mut().flatten().zip(change.traction.iter().flatten()) {
            traction.normal = from.normal + share * by.normal;
            traction.vector = [0, 1, 2].map(|i| from.vector[i] + share * by.vector[i]);
        }
        next
    }
}
