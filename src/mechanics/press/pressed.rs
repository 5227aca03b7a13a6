//! What a press finds.

use super::{Assembly, ContactPoint, Setup};
use crate::mechanics::newton::LinearSolver;
use crate::mechanics::problem::State;
use serde::{Deserialize, Serialize};

/// A press at one of the asked loads.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PressStep {
    /// Motion of the phantom's base, mm.
    pub depth_mm: f64,
    /// Its motion along x and y, mm.
    pub slide_mm: [f64; 2],
    /// Time for which it was held before it was read, s.
    pub hold_s: f64,
    /// Total force along z, N.
    pub force_n: f64,
    /// Largest pressure over 0.8 of the footprint's radius, kPa: the edge of a tied contact is singular. Under an
    /// indenter over all of the face. In two dimensions it may lie at the very end of that part, between two nodes.
    pub peak_pressure_kpa: f64,
    /// Where it is on the undeformed face: x and y, or r (x in plane strain) and 0, mm; none where nothing is borne.
    pub peak_at_mm: Option<[f64; 2]>,
    /// Nodes of the touched face, by x, then y.
    pub points: Vec<ContactPoint>,
    /// The whole state.
    pub state: State,
    /// Error of the pressure, where it was estimated.
    pub error: Option<PressureError>,
}

/// A press at all asked loads that it reached.
#[derive(Debug, Clone)]
pub struct Pressed {
    /// Description.
    pub setup: Setup,
    /// The problem.
    pub assembly: Assembly,
    /// Asked loads, ascending.
    pub steps: Vec<PressStep>,
    /// Displacement unknowns.
    pub unknowns: usize,
    /// Newton iterations.
    pub iterations: usize,
    /// Cycles of multigrid.
    pub cycles: usize,
    /// Seconds, without the error estimate.
    pub seconds: f64,
    /// Seconds of the error estimate.
    pub error_seconds: f64,
    /// Why there is no estimate at any load, though it was asked for.
    pub unestimated: Option<String>,
    /// How linear systems were solved.
    pub method: LinearSolver,
    /// Memory of the matrix's factor, or of multigrid's levels, MiB.
    pub factor_mib: f64,
}

/// Estimated error of a press at one load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PressureError {
    /// Root mean square of the pressure's error over 0.8 of the footprint's radius (all of the face under an indenter),
    /// as a share of the pressure's own: that of the mesh.
    pub rms: f64,
    /// Error of the peak pressure, as a share of it: that of the mesh. None under an indenter by points: pressure is
    /// singular where its profile bends, and so has no limit as the mesh is refined.
    pub peak: Option<f64>,
    /// Error of the force, as a share of it: that of the mesh.
    pub force: f64,
    /// What a sharp edge in place of a rigid sensor's rounded one would change, where the sensor slides.
    pub rounding: Option<Rounding>,
}

impl PressureError {
    /// Largest share that is an error: beyond it the elements do not resolve what it is of.
    const RESOLVED: f64 = 0.25;

    /// A share that is an error; none where the elements do not resolve what it is of.
    pub fn resolved(share: f64) -> Option<f64> {
        Some(share).filter(|share| *share <= Self::RESOLVED)
    }
}

/// What the rounding of a rigid sensor's edge does: the face in contact ends before the outline. The edge is rounded
/// twice as far for it. What that changes a sharp edge changes the other way if the change is as the radius (a face
/// pressed little), 1.7 times as much if it is as its power 2/3 (a face that the press bends around the arc). The
/// factor of safety covers both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rounding {
    /// Root mean square change of the pressure over 0.8 of the footprint's radius, as a share of it.
    pub rms: f64,
    /// Change of the force, as a share of it.
    pub force: f64,
}
