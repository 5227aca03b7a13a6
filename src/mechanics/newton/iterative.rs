//! Newton's step by Krylov's method: displacements, pressures and contact tractions together, so that neither
//! incompressibility nor contact makes the matrix of displacements stiff.
//!
//! The matrix is the augmented one (Fortin and Glowinski 1983): a moderate bulk modulus and a spring as stiff as the
//! body go into the displacements' block, which multigrid takes; pressures and tractions are preconditioned by what is
//! then left of their Schur complements, moduli over volumes and springs over areas (Elman, Silvester and Wathen 2014).

use super::krylov::gmres;
use super::system::unknowns;
use super::touch::{Hold, Touch, Touching, moved, pushes};
use super::{Change, HELD, Solver, StepError};
use crate::mechanics::multigrid::Multigrid;
use crate::mechanics::problem::Traction;
use crate::mechanics::solid::ElementSystem;
use rayon::prelude::*;

/// Spring of contacts there, in springs as stiff as the body: with few, tractions at the edge of a tied face are slow
/// to be found.
pub(super) const CONTACT: f64 = 128.0;
/// Residual that is left of a step's, as a share of it: at first, at the least and at the most; and most directions.
/// In between it is this share of the square of Newton's own progress (Eisenstat and Walker, SIAM J. Sci. Comput. 17,
/// 16, 1996), and no less than a share of what is left to do.
const TOLERANCE: [f64; 3] = [0.1, 1e-6, 0.1];
const PROGRESS: f64 = 0.9;
const WORTH: f64 = 0.2;
const DIRECTIONS: usize = 120;
/// What an element's Schur complement has beside the bulk modulus, in shear moduli.
const SHEAR: f64 = 1.0;

/// Entries of a traction: the normal one, then the vector.
const PARTS: usize = 4;

/// The parts of a vector of unknowns.
struct Parts {
    displacements: usize,
    pressures: usize,
}

/// What an element adds to the rows of pressures.
struct Volume {
    /// Mass of the pressure functions, mm^3, by rows.
    mass: [[f64; 4]; 4],
    /// 1 / bulk modulus of the material, and of the tangent, per kPa.
    compliance: [f64; 2],
    /// Modulus of the Schur complement, kPa.
    modulus: f64,
    /// Scale of the rows.
    scale: f64,
}

impl Solver<'_> {
    pub(super) fn solve_iteratively(
        &mut self,
        multigrid: &mut Multigrid,
        held: Vec<f64>,
        right: Vec<f64>,
        systems: &[ElementSystem],
        touches: &[Touching],
        worth: f64,
    ) -> Result<Change, StepError> {
        multigrid.finish()?;
        let (problem, dim) = (self.problem, self.problem.kinematics.dim());
        let per_element = problem.pressures();
        let volumes: Vec<Volume> = systems.iter().enumerate().map(|(e, system)| self.volume(e, system)).collect();
        let all: Vec<&Touch> = touches.iter().flat_map(|t| &t.nodes).collect();
        let parts = Parts { displacements: held.len(), pressures: per_element * systems.len() };
        let (u, p) = (parts.displacements, parts.displacements + parts.pressures);
        let whole = p + PARTS * all.len();
        let own: Vec<f64> = self.own_stiffness.iter().map(|k| k.max(f64::MIN_POSITIVE).sqrt().recip()).collect();
        let free = |k: usize| self.equation[k] != HELD;

        // The right side, each row by its scale.
        let mut start = vec![0.0; whole];
        for k in (0..u).filter(|&k| free(k)) {
            start[k] = own[k] * right[k];
        }
        for (e, (system, volume)) in systems.iter().zip(&volumes).enumerate() {
            let unknowns = unknowns(problem.mesh.element(e), dim);
            for (k, slope) in system.pressure_slope.chunks(unknowns.len()).enumerate() {
                let along: f64 = unknowns.iter().zip(slope).map(|(&k, s)| s * held[k]).sum();
                start[u + per_element * e + k] =
                    -volume.scale * volume.compliance[1] * (system.pressure_defect[k] + along);
            }
        }
        for (k, touch) in all.iter().enumerate() {
            let (gap, offset) = moved(&touch.gap, &held, dim);
            let offset: [f64; 3] = std::array::from_fn(|i| touch.gap.offset[i] + offset[i]);
            for (row, value) in constraint(touch, touch.gap.gap + gap, offset).into_iter().enumerate() {
                start[p + PARTS * k + row] = -scale(touch) * value;
            }
        }

        let odd = self.odd(touches);
        let mut cycles = 0;
        // The step that the preconditioner makes of a residual.
        let mut precondition = |multigrid: &mut Multigrid, residual: &[f64]| -> Vec<f64> {
            cycles += 1;
            let mut step = vec![0.0; whole];
            let mut force: Vec<f64> = (0..u).map(|k| if free(k) { residual[k] / own[k] } else { 0.0 }).collect();
            for (e, volume) in volumes.iter().enumerate() {
                for k in u + per_element * e..u + per_element * (e + 1) {
                    step[k] = -volume.modulus * residual[k] / volume.scale;
                }
            }
            for (k, touch) in all.iter().enumerate().filter(|(_, touch)| touch.hold != Hold::Free) {
                for row in p + PARTS * k..p + PARTS * (k + 1) {
                    step[row] = touch.stiff / touch.gap.area * residual[row] / scale(touch);
                }
            }
            self.add_pressures(multigrid, &mut force, -1.0, &step[u..p], systems, &volumes);
            self.add_tractions(&mut force, 1.0, &step[p..], &all);
            force.iter_mut().enumerate().filter(|(k, _)| !free(*k)).for_each(|(_, f)| *f = 0.0);
            step[..u].copy_from_slice(&multigrid.cycle(&force));
            (0..u).filter(|&k| !free(k)).for_each(|k| step[k] = 0.0);
            step
        };
        let mut multiply = |residual: &[f64]| -> Vec<f64> {
            let step = precondition(multigrid, residual);
            let mut out = vec![0.0; whole];
            let mut force = vec![0.0; u];
            multigrid.multiply(&step[..u], &mut force);
            if let Some(odd) = &odd {
                force.iter_mut().zip(odd(&step[..u])).for_each(|(force, odd)| *force += odd);
            }
            self.add_pressures(multigrid, &mut force, 1.0, &step[u..p], systems, &volumes);
            self.add_tractions(&mut force, -1.0, &step[p..], &all);
            for k in (0..u).filter(|&k| free(k)) {
                out[k] = own[k] * force[k];
            }
            let rows = out[u..p].par_chunks_mut(per_element).enumerate();
            rows.for_each(|(e, out)| {
                let (system, volume) = (&systems[e], &volumes[e]);
                let unknowns = unknowns(problem.mesh.element(e), dim);
                for (k, slope) in system.pressure_slope.chunks(unknowns.len()).enumerate() {
                    let along: f64 = unknowns.iter().zip(slope).map(|(&k, s)| s * step[k]).sum();
                    let pressure = step[u + per_element * e + k];
                    out[k] = volume.scale * (volume.compliance[1] * along - volume.compliance[0] * pressure);
                }
            });
            for (k, touch) in all.iter().enumerate() {
                let (gap, offset) = moved(&touch.gap, &step[..u], dim);
                for (row, value) in constraint(touch, gap, offset).into_iter().enumerate() {
                    out[p + PARTS * k + row] = scale(touch) * value;
                }
            }
            out
        };
        let size = start.iter().map(|x| x * x).sum::<f64>().sqrt();
        let tolerance = tolerance(self.last_right, size, worth);
        let found = gmres(start, &mut multiply, tolerance, DIRECTIONS).0;
        let step = precondition(multigrid, &found);
        drop(odd);
        self.cycles += cycles;
        self.last_right = Some(size);
        let mut change = held;
        for k in (0..u).filter(|&k| free(k)) {
            change[k] = step[k];
        }
        let mut rows = step[p..].chunks(PARTS);
        let mut traction = Vec::new();
        for touching in touches {
            let mut list = Vec::new();
            for (touch, row) in touching.nodes.iter().zip(&mut rows) {
                let [now, mut by] = touch.step(&change, dim);
                let more = borne(touch, row);
                by.normal += more.normal;
                (0..3).for_each(|i| by.vector[i] += more.vector[i]);
                list.push([now, by]);
            }
            traction.push(list);
        }
        Ok(Change { displacement: change, pressure: step[u..p].to_vec(), traction })
    }

    fn volume(&self, e: usize, system: &ElementSystem) -> Volume {
        let material = &self.problem.materials[self.problem.mesh.region[e] as usize];
        let shear = material.law.shear_kpa();
        let own = material.bulk_kpa().recip();
        let tangent = own + if material.bulk_kpa() > self.bulk_kpa(e) { self.bulk_kpa(e).recip() } else { 0.0 };
        let modulus = (own + (tangent.recip() + SHEAR * shear).recip()).recip();
        let mass = system.mass;
        Volume { mass, compliance: [own, tangent], modulus, scale: (modulus * mass[0][0]).sqrt() }
    }

    /// Adds the forces of pressure steps.
    fn add_pressures(
        &self,
        multigrid: &Multigrid,
        force: &mut [f64],
        sign: f64,
        step: &[f64],
        systems: &[ElementSystem],
        volumes: &[Volume],
    ) {
        let count = self.problem.pressures();
        let mut weights = vec![0.0; step.len()];
        let elements = weights.par_chunks_mut(count).zip(step.par_chunks(count)).zip(volumes);
        elements.with_min_len(256).for_each(|((weights, pressure), volume)| {
            let [own, tangent] = volume.compliance;
            // What the augmented block has of the material's own compliance is taken out.
            let factor = sign * tangent * (1.0 - own / tangent);
            for (weight, mass) in weights.iter_mut().zip(&volume.mass) {
                *weight = factor * mass.iter().zip(pressure).map(|(m, p)| m * p).sum::<f64>();
            }
        });
        force.par_chunks_mut(3).enumerate().with_min_len(256).for_each(|(node, force)| {
            for &(e, a) in multigrid.elements_of(node) {
                let (e, a) = (e as usize, a as usize);
                let slopes = systems[e].pressure_slope.chunks(systems[e].force.len());
                for (slope, weight) in slopes.zip(&weights[count * e..count * (e + 1)]) {
                    (0..3).for_each(|i| force[i] += weight * slope[3 * a + i]);
                }
            }
        });
    }

    /// Adds the forces of traction steps.
    fn add_tractions(&self, force: &mut [f64], sign: f64, step: &[f64], all: &[&Touch]) {
        let dim = self.problem.kinematics.dim();
        for (touch, row) in all.iter().zip(step.chunks(PARTS)).filter(|(touch, _)| touch.hold != Hold::Free) {
            for (node, push) in pushes(touch, &borne(touch, row)) {
                (0..dim).for_each(|i| force[node as usize * dim + i] += sign * push[i]);
            }
        }
    }
}

/// How far Krylov's method goes: see [`TOLERANCE`].
fn tolerance(last: Option<f64>, size: f64, worth: f64) -> f64 {
    let [first, least, most] = TOLERANCE;
    let progress = last.map_or(first, |last| PROGRESS * (size / last).powi(2));
    progress.max(WORTH * worth).clamp(least, most)
}

/// Scale of a node's constraints.
fn scale(touch: &Touch) -> f64 {
    if touch.gap.area > 0.0 { (touch.stiff / touch.gap.area).sqrt() } else { 1.0 }
}

/// What is to vanish, of a gap and an offset: nothing where free, the gap where it slips.
fn constraint(touch: &Touch, gap: f64, offset: [f64; 3]) -> [f64; PARTS] {
    let vector = match touch.hold {
        Hold::Bonded | Hold::Sticks => touch.along_face(offset),
        Hold::Free | Hold::Slips => [0.0; 3],
    };
    let normal = if matches!(touch.hold, Hold::Sticks | Hold::Slips) { gap } else { 0.0 };
    [normal, vector[0], vector[1], vector[2]]
}

/// The traction that a constraint's unknowns stand for.
fn borne(touch: &Touch, row: &[f64]) -> Traction {
    let vector = match touch.hold {
        Hold::Bonded | Hold::Sticks => touch.along_face([row[1], row[2], row[3]]),
        Hold::Free | Hold::Slips => [0.0; 3],
    };
    let normal = if matches!(touch.hold, Hold::Sticks | Hold::Slips) { row[0] } else { 0.0 };
    Traction { normal, vector: [0, 1, 2].map(|i| vector[i] + touch.drag[i] * normal) }
}
