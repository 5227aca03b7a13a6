//! Linear tissue: one factorisation for all positions.
//!
//! Where the tissue is linear and slides freely, only the contact is nonlinear. The base moves the tissue rigidly, and
//! the forces f of the contact add u = C f on the face, with the compliance C of its nodes from one factorisation. A
//! position is then a small complementarity problem: pressures p >= 0 and gaps >= 0, one of them 0 at each node. It is
//! solved by the Newton's method, the gaps, the active set and the forces of [`Contact`], so that the balance is the
//! same as that of the whole system.

use super::ScanSetup;
use crate::mechanics::contact::{Contact, Grip, NodeGap, Positions, SPRING};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Boundary, Facet, Footprint, Mesh};
use crate::mechanics::problem::{Problem, State};
use crate::mechanics::solid::{element_system, tangent_bulk_kpa};
use crate::mechanics::sparse::{SparseError, SparseLdl};
use faer::Mat;
use faer::prelude::Solve;
use std::collections::BTreeSet;

/// Largest bulk modulus in shear moduli for which an element's tangent is exact.
const MOST_BULK: f64 = 1e4;
/// Newton iterations of a position.
const ITERATIONS: usize = 60;
/// Largest error of a displacement and of a gap in contact, mm.
const TOLERANCE_MM: f64 = 1e-9;

/// Displacements of the face under forces on it.
pub(super) struct Compliance {
    /// The facets that can come into contact.
    pub facets: Vec<Facet>,
    /// Row and column of each displacement component of the mesh, 2 a node; `NONE` away from these facets.
    row: Vec<u32>,
    /// mm per mN.
    matrix: Mat<f64>,
}

const NONE: u32 = u32::MAX;

/// A position in balance.
pub(super) struct Balanced {
    pub state: State,
    pub iterations: usize,
}

impl Compliance {
    /// Whether a scan's tissue is linear, slides freely, and meets the indenter within the dense part of its face.
    pub fn suits(setup: &ScanSetup) -> bool {
        let linear = |m: &Material| {
            m.law.is_small_strain() && m.relaxation.is_empty() && m.bulk_kpa() <= MOST_BULK * m.law.shear_kpa()
        };
        let reach = setup.places_mm.last().copied().unwrap_or(0.0);
        let [below, ..] = setup.indenter.depth(reach);
        setup.grip == Grip::Frictionless && setup.materials.iter().all(linear) && below > setup.depth_mm
    }

    /// Factorises the tissue, the face last. `None` where `observe` stops it.
    ///
    /// # Errors
    /// Where the system cannot be factorised.
    pub fn new(setup: &ScanSetup, mesh: &Mesh, observe: &dyn Fn() -> bool) -> Result<Option<Self>, SparseError> {
        let reach = match setup.tissue.footprint {
            Footprint::Round { radius_mm } => radius_mm,
            Footprint::Rectangle { half_widths_mm } => half_widths_mm[0],
        };
        let within = |&a: &u32| mesh.nodes[a as usize][0].abs() <= reach * (1.0 + 1e-9);
        let mut facets = mesh.boundary_facets(Boundary::Touched);
        facets.retain(|&facet| mesh.facet_nodes(facet).iter().all(within));
        let nodes: BTreeSet<u32> = facets.iter().flat_map(|&facet| mesh.facet_nodes(facet)).collect();
        let mut row = vec![NONE; 2 * mesh.nodes.len()];
        let components: Vec<u32> = nodes.iter().flat_map(|a| [2 * a, 2 * a + 1]).collect();
        components.iter().zip(0..).for_each(|(&k, place)| row[k as usize] = place);
        let (mut equation, mut equations) = (vec![0; 2 * mesh.nodes.len()], 0);
        for node in mesh.boundary_nodes(Boundary::Base) {
            equation[2 * node as usize..2 * node as usize + 2].fill(NONE);
        }
        for e in equation.iter_mut().filter(|e| **e != NONE) {
            *e = equations;
            equations += 1;
        }
        if !observe() {
            return Ok(None);
        }
        let nodes: Vec<u32> = nodes.into_iter().collect();
        let system = assembled(setup, mesh, &equation, &nodes)?;
        let matrix = system.inverse_of_last(components.len()).ok_or(SparseError::Indefinite)?;
        Ok(Some(Self { facets, row, matrix }))
    }

    /// Balance of a problem whose contact has these facets; `None` where Newton's method does not settle.
    pub fn press(&self, problem: &Problem, depth_mm: f64) -> Option<Balanced> {
        let contact = problem.contacts.first()?;
        let mut state = problem.start();
        state.load = depth_mm;
        state.displacement.fill([0.0, -depth_mm, 0.0]);
        let mut pressure = vec![0.0; contact.nodes.len()];
        for iterations in 1..=ITERATIONS {
            let now = problem.positions(&state);
            let at = Positions { reference: &problem.mesh.nodes, before: &now, now: &now };
            let (gaps, bending) = contact.gaps(at, &pressure);
            let active = active(contact, &gaps, &pressure);
            let mut settled = active.iter().all(|&k| pressure[k] > 0.0);
            for (_, p) in pressure.iter_mut().enumerate().filter(|(k, p)| **p != 0.0 && !active.contains(k)) {
                settled = false;
                *p = 0.0;
            }
            // The components that the active gaps and their bending see.
            let held = active.iter().flat_map(|&k| gaps[k].moved.iter().map(|entry| entry.0));
            let bent = bending.even.iter().flat_map(|&(a, b, _)| [a, b]);
            let seen: BTreeSet<u32> = held.chain(bent).flat_map(|a| [2 * a, 2 * a + 1]).collect();
            let seen: Vec<u32> = seen.into_iter().collect();
            let place = |k: u32| seen.binary_search(&k).ok();
            let (n, m) = (seen.len(), active.len());
            let mut pushes = Mat::<f64>::zeros(n, m);
            for (j, &k) in active.iter().enumerate() {
                for (a, _, normal) in &gaps[k].moved {
                    for i in 0..2 {
                        pushes[(place(2 * a + i)?, j)] += normal[i as usize];
                    }
                }
            }
            let mut stiffness = Mat::<f64>::zeros(n, n);
            for (a, b, entry) in &bending.even {
                for i in 0..2 {
                    for j in 0..2 {
                        stiffness[(place(2 * a + i)?, place(2 * b + j)?)] += entry[i as usize][j as usize];
                    }
                }
            }
            let now = Mat::from_fn(m, 1, |j, _| pressure[active[j]]);
            let defect = self.defect(&state, depth_mm, &seen, &(&pushes * &now));
            let gap = active.iter().map(|&k| (gaps[k].gap / gaps[k].area).abs()).fold(0.0, f64::max);
            let off = defect.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
            if settled && gap <= TOLERANCE_MM && off <= TOLERANCE_MM {
                for (traction, &p) in state.traction.first_mut()?.iter_mut().zip(&pressure) {
                    traction.normal = p;
                }
                return self.is_inside(contact, problem, &pressure).then_some(Balanced { state, iterations });
            }
            // (1 + C K) du = defect + C B dp and B' du = -gap.
            let rows: Vec<usize> = seen.iter().map(|&k| self.row[k as usize] as usize).collect();
            let near = Mat::from_fn(n, n, |i, j| self.matrix[(rows[i], rows[j])]);
            let left = Mat::<f64>::identity(n, n) + &near * &stiffness;
            let own = Mat::from_fn(n, 1, |i, _| defect[rows[i]]);
            let lu = left.partial_piv_lu();
            let (free, answer) = (lu.solve(&own), lu.solve(&(&near * &pushes)));
            let right = Mat::from_fn(m, 1, |j, _| -gaps[active[j]].gap) - pushes.transpose() * &free;
            let rise = (pushes.transpose() * &answer).partial_piv_lu().solve(&right);
            let moved = &free + &answer * &rise;
            let more = &pushes * &rise - &stiffness * &moved;
            if !(0..m).all(|j| rise[(j, 0)].is_finite()) {
                return None;
            }
            active.iter().enumerate().for_each(|(j, &k)| pressure[k] += rise[(j, 0)]);
            self.advance(&mut state, &defect, &rows, &more);
        }
        None
    }

    /// What forces on some components add to the face beyond its present place, by row.
    fn defect(&self, state: &State, depth_mm: f64, seen: &[u32], force: &Mat<f64>) -> Vec<f64> {
        let mut defect = vec![0.0; self.matrix.nrows()];
        for (k, &row) in self.row.iter().enumerate().filter(|(_, row)| **row != NONE) {
            let free = if k % 2 == 1 { -depth_mm } else { 0.0 };
            defect[row as usize] = free - state.displacement[k / 2][k % 2];
        }
        for (j, &k) in seen.iter().enumerate() {
            let column = self.matrix.col(self.row[k as usize] as usize);
            defect.iter_mut().enumerate().for_each(|(i, d)| *d += column[i] * force[(j, 0)]);
        }
        defect
    }

    /// Moves the face by its defect and by more forces.
    fn advance(&self, state: &mut State, defect: &[f64], rows: &[usize], more: &Mat<f64>) {
        let mut change = defect.to_vec();
        for (j, &row) in rows.iter().enumerate() {
            let column = self.matrix.col(row);
            change.iter_mut().enumerate().for_each(|(i, d)| *d += column[i] * more[(j, 0)]);
        }
        for (k, &row) in self.row.iter().enumerate().filter(|(_, row)| **row != NONE) {
            state.displacement[k / 2][k % 2] += change[row as usize];
        }
    }

    /// Whether the outermost nodes are free: a contact that reaches them may go on beyond.
    fn is_inside(&self, contact: &Contact, problem: &Problem, pressure: &[f64]) -> bool {
        let x = |k: usize| problem.mesh.nodes[contact.nodes[k] as usize][0];
        let ends = (0..pressure.len()).fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], k| [l.min(x(k)), h.max(x(k))]);
        (0..pressure.len()).all(|k| pressure[k] == 0.0 || !ends.contains(&x(k)))
    }
}

/// The nodes in contact: those where pressure less gap, by a spring as stiff as the body, presses.
fn active(contact: &Contact, gaps: &[NodeGap], pressure: &[f64]) -> Vec<usize> {
    let presses = |&k: &usize| {
        let gap = &gaps[k];
        gap.area > 0.0 && pressure[k] - contact.spring[k] / SPRING * gap.gap / gap.area > 0.0
    };
    (0..gaps.len()).filter(presses).collect()
}

/// The tissue's stiffness, factorised with these nodes last.
fn assembled(setup: &ScanSetup, mesh: &Mesh, equation: &[u32], last: &[u32]) -> Result<SparseLdl, SparseError> {
    let groups: Vec<Vec<u32>> = (0..mesh.element_count()).map(|e| mesh.element(e).to_vec()).collect();
    let mut first = vec![0];
    for unknowns in equation.chunks(2) {
        let free = unknowns.iter().filter(|e| **e != NONE).count() as u32;
        first.push(first.last().map_or(0, |last| last + free));
    }
    let mut system = SparseLdl::ending_with(last, first, &mesh.nodes, &groups)?;
    let still = vec![[0.0; 3]; mesh.element_size()];
    let bulk = Some(tangent_bulk_kpa(&setup.materials));
    for e in 0..mesh.element_count() {
        let nodes = mesh.element_positions(e);
        let material = setup.materials.get(mesh.region[e] as usize).ok_or(SparseError::Indefinite)?;
        let element = element_system(Kinematics::PlaneStrain, &nodes, &still, &[0.0; 3], material, None, bulk);
        let stiffness = element.ok_or(SparseError::Indefinite)?.stiffness;
        let unknowns = |&a: &u32| [equation[2 * a as usize], equation[2 * a as usize + 1]];
        let numbers: Vec<u32> = mesh.element(e).iter().flat_map(unknowns).collect();
        system.add(mesh.element(e), &numbers, &stiffness);
    }
    system.factorize()?;
    Ok(system)
}
