//! A boundary value problem and its states.

use super::contact::{Contact, Grip};
use super::element::{PressureOrder, quadrature};
use super::kinematics::Kinematics;
use super::material::{History, Material};
use super::mesh::Mesh;
use serde::{Deserialize, Serialize};

/// A mesh with materials, supports, loads and contacts. All loads grow in proportion to one load factor.
#[derive(Debug, Clone)]
pub struct Problem {
    /// Setting.
    pub kinematics: Kinematics,
    /// Order of the elements' pressure.
    pub pressure: PressureOrder,
    /// The bodies, in one mesh.
    pub mesh: Mesh,
    /// Material of each region.
    pub materials: Vec<Material>,
    /// Prescribed displacements.
    pub supports: Vec<Support>,
    /// Dead forces on nodes at load factor 1, mN.
    pub forces: Vec<(u32, [f64; 3])>,
    /// Contacts.
    pub contacts: Vec<Contact>,
    /// Time in which the load factor grows by 1, s; `None`: so slow that all is relaxed. Matters to relaxing materials
    /// only.
    pub seconds_per_load: Option<f64>,
    /// Least number of steps to each load while materials relax, and what a hold's moments go by.
    pub time_steps: usize,
    /// How far the load factor may grow at once: a longer step may lead to another state in balance, such as a face in
    /// folds.
    pub stride: Stride,
}

/// Steps to a load in which stresses relax: of tissue that loses 0.6 with 0.5 s, pressed by 2 mm within 2 s, forces are
/// 0.02 % off, 0.16 % where it stiffens; by one step 1.3 and 10 %.
pub const TIME_STEPS: usize = 10;
/// Least number of steps where faces rub.
const RUBBING_STEPS: usize = 10;
/// First step of a hold, times the number of steps, in units of the shortest time of relaxation.
const FIRST_OF_HOLD: f64 = 2.5;
/// Most steps of a hold; each is twice the one before, so that these are longer than any.
const MOST_OF_HOLD: usize = 200;

/// How long steps of the load factor may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stride {
    /// Load factor up to which they may be of any length.
    pub any_to: f64,
    /// Longest step beyond it.
    pub longest: f64,
}

impl Stride {
    /// Of any length.
    pub const ANY: Self = Self { any_to: f64::INFINITY, longest: f64::INFINITY };

    /// Longest step from a load factor on.
    pub fn from(self, load: f64) -> f64 {
        self.longest.max(self.any_to - load)
    }
}

/// A prescribed displacement component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    /// The node.
    pub node: u32,
    /// The component.
    pub axis: usize,
    /// Displacement at load factor 1, mm.
    pub displacement_mm: f64,
}

/// A state of equilibrium (or a guess of one).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Load factor.
    pub load: f64,
    /// Displacement of each node, mm.
    pub displacement: Vec<[f64; 3]>,
    /// Pressure coefficients, [`Problem::pressures`] an element, kPa; tension positive.
    pub pressure: Vec<f64>,
    /// Traction at each touched node of each contact, kPa of the undeformed face: (normal pressure, 0, 0) and
    /// tangential traction; bonded faces hold the whole vector in the second.
    pub traction: Vec<Vec<Traction>>,
    /// Memory of the relaxing materials, by element and quadrature point; empty for elastic ones.
    pub history: Vec<Vec<History>>,
}

/// Traction at a touched node.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Traction {
    /// Pressure, kPa; 0 for bonded faces.
    pub normal: f64,
    /// Tangential traction, or all of it for bonded faces, on the touched body, kPa.
    pub vector: [f64; 3],
}

impl Problem {
    /// Bodies that nothing holds, loads or touches yet.
    pub fn free(kinematics: Kinematics, mesh: Mesh, materials: Vec<Material>) -> Self {
        let (supports, forces, contacts) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            kinematics,
            pressure: PressureOrder::default(),
            mesh,
            materials,
            supports,
            forces,
            contacts,
            seconds_per_load: None,
            time_steps: TIME_STEPS,
            stride: Stride::ANY,
        }
    }

    /// The undeformed state.
    pub fn start(&self) -> State {
        State {
            load: 0.0,
            displacement: vec![[0.0; 3]; self.mesh.nodes.len()],
            pressure: vec![0.0; self.mesh.element_count() * self.pressures()],
            traction: self.contacts.iter().map(|c| vec![Traction::default(); c.nodes.len()]).collect(),
            history: self.mesh.region.iter().map(|&region| self.rest(region)).collect(),
        }
    }

    fn rest(&self, region: u32) -> Vec<History> {
        match self.materials.get(region as usize) {
            Some(material) if !material.relaxation.is_empty() => {
                vec![History::rest(material); quadrature(self.kinematics.dim()).len()]
            }
            _ => Vec::new(),
        }
    }

    /// Pressure coefficients of an element.
    pub fn pressures(&self) -> usize {
        self.pressure.functions(self.kinematics.dim())
    }

    /// Number of displacement unknowns.
    pub fn unknowns(&self) -> usize {
        let dim = self.kinematics.dim();
        let mut held = vec![false; self.mesh.nodes.len() * dim];
        self.supports.iter().for_each(|s| held[s.node as usize * dim + s.axis] = true);
        held.iter().filter(|h| !**h).count()
    }

    /// Whether faces can slide on each other, and none are bonded.
    pub fn slides(&self) -> bool {
        let slides = |contact: &Contact| contact.grip != Grip::Bonded && !contact.is_rigid();
        self.contacts.iter().any(slides) && self.contacts.iter().all(|contact| contact.grip != Grip::Bonded)
    }

    /// Whether faces rub against each other.
    pub fn rubs(&self) -> bool {
        self.contacts.iter().any(|contact| matches!(contact.grip, Grip::Coulomb(_)))
    }

    /// Whether a state depends on the way to it.
    pub fn way_counts(&self) -> bool {
        self.rubs() || self.shortest_time_s().is_some()
    }

    /// Least number of steps to each load.
    pub fn steps_a_load(&self) -> usize {
        // What is as slow as can be is relaxed at any moment.
        let relaxing = self.seconds_per_load.and(self.shortest_time_s()).map_or(1, |_| self.time_steps);
        relaxing.max(if self.rubs() { RUBBING_STEPS } else { 1 })
    }

    /// Lengths of the steps of a hold, s: the first a part of the shortest time in which something relaxes, and each
    /// longer than those before it together.
    pub fn steps_of_hold_s(&self, seconds: f64) -> Vec<f64> {
        let Some(shortest_s) = self.shortest_time_s() else { return vec![seconds] };
        let steps = self.time_steps.max(1) as f64;
        let (first, growth) = (FIRST_OF_HOLD * shortest_s / steps, TIME_STEPS as f64 / steps);
        let (mut lengths, mut passed) = (Vec::new(), 0.0);
        while passed < seconds && lengths.len() < MOST_OF_HOLD {
            let length = first + growth * passed;
            // No short one at the end.
            let last = passed + 1.5 * length >= seconds || lengths.len() + 1 == MOST_OF_HOLD;
            lengths.push(if last { seconds - passed } else { length });
            passed = if last { seconds } else { passed + length };
        }
        lengths
    }

    /// Shortest time in which some of a material's stress relaxes, s; none where none does.
    fn shortest_time_s(&self) -> Option<f64> {
        let terms = self.materials.iter().flat_map(|material| &material.relaxation);
        terms.map(|term| term.time_s).min_by(f64::total_cmp)
    }

    /// Positions of the nodes in a state, mm.
    pub fn positions(&self, state: &State) -> Vec<[f64; 3]> {
        let sum = |x: &[f64; 3], u: &[f64; 3]| [x[0] + u[0], x[1] + u[1], x[2] + u[2]];
        self.mesh.nodes.iter().zip(&state.displacement).map(|(x, u)| sum(x, u)).collect()
    }
}
