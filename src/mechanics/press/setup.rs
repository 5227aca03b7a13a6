//! What is pressed against what.

use crate::mechanics::contact::{Grip, Profile};
use crate::mechanics::element::PressureOrder;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, PhantomMesh};
use crate::mechanics::problem::Stride;

/// Description of a press.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Setting: axisymmetric or three-dimensional.
    pub kinematics: Kinematics,
    /// Order of the elements' pressure.
    pub pressure: PressureOrder,
    /// The phantom, its inclusions and its mesh; the footprint is the sensor's face.
    pub phantom: PhantomMesh,
    /// Material of the phantom, then of each inclusion, then of each layer.
    pub phantom_materials: Vec<Material>,
    /// The sensor.
    pub sensor: SensorBody,
    /// How the faces hold each other.
    pub grip: Grip,
    /// What is asked.
    pub load: Load,
    /// Time that each mm of the press takes, s; absent: so slow that all is relaxed.
    pub seconds_per_mm: Option<f64>,
    /// Time for which each asked load is held before it is read, s.
    pub hold_s: f64,
    /// Least number of steps to each load while materials relax, and what holds are divided by: between two moments
    /// stresses are taken to change evenly.
    pub time_steps: usize,
    /// Turn of the phantom about x, then y, through the middle of the sensor's face, degrees; three dimensions only.
    pub tilt_deg: [f64; 2],
}

/// The sensor's body.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorBody {
    /// Rigid and flat, with a rounded edge where it is not bonded.
    Rigid {
        /// Radius of the edge's rounding, mm.
        edge_radius_mm: f64,
    },
    /// A rigid indenter in its place: a body of revolution about the axis, its tip in the plane of the phantom's face.
    /// The footprint is what it is expected to touch, and does not bound the contact.
    Indenter(Profile),
    /// Soft layers on rigid glass.
    Layers {
        /// Thickness, mm, and material of each, lowest first.
        layers: Vec<(f64, Material)>,
        /// Radius of the touched face's rim, mm; 0 where it is sharp.
        edge_radius_mm: f64,
    },
}

/// What is asked of a press.
#[derive(Debug, Clone, PartialEq)]
pub enum Load {
    /// Motions of the phantom's base, mm, ascending.
    Depths(Vec<f64>),
    /// Forces, N, ascending.
    Forces(Vec<f64>),
    /// A motion: press, hold, slide and lift, one after another.
    Path(Vec<Pose>),
}

/// Where the phantom's base is brought along a straight line, and how long it stays there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Motion towards the sensor from first touch, mm.
    pub depth_mm: f64,
    /// Motion along x and y, mm; three dimensions only.
    pub slide_mm: [f64; 2],
    /// Time for which it is held there before it is read, s.
    pub hold_s: f64,
}

impl Pose {
    /// Way from another pose along x and y and towards the sensor, mm.
    pub(super) fn way_from(&self, other: &Self) -> [f64; 3] {
        let slide = |axis: usize| self.slide_mm[axis] - other.slide_mm[axis];
        [slide(0), slide(1), self.depth_mm - other.depth_mm]
    }
}

/// Length of a way, mm.
pub(super) fn length_mm(way: [f64; 3]) -> f64 {
    way.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Longest step on an indenter, in radii of its footprint: half an element of a curved one's. A rounded flat one folded
/// the face where 0.3 of its footprint were one step, and so did a ball.
const LONGEST_STEP: f64 = 1.0 / 12.0;
/// Depth to which a tied phantom beside a soft sensor has one state, in radii of the footprint.
const ONE_STATE_TO: f64 = 0.14;
/// Longest step beyond it, in the same unit. By steps twice as long 11 phantoms of 100 folded otherwise.
const FOLDING_STEP: f64 = 1.0 / 30.0;

impl Setup {
    /// The same press on elements of twice the size, by half as many steps in time.
    pub fn halved(&self) -> Self {
        Self { phantom: self.phantom.halved(), ..self.in_half_the_steps() }
    }

    fn in_half_the_steps(&self) -> Self {
        Self { time_steps: self.time_steps.div_ceil(2), ..self.clone() }
    }

    /// The same press on the next coarser mesh, nested in this one where there is such a mesh, by half as many steps in
    /// time.
    pub fn coarsened(&self) -> Self {
        let phantom = PhantomMesh { resolution: self.phantom.resolution.coarsened(), ..self.phantom.clone() };
        Self { phantom, ..self.in_half_the_steps() }
    }

    /// The same press by a rigid sensor whose edge is rounded twice as far; nothing where the sensor has no rounded
    /// edge or the arc would take more than half of its face.
    pub fn twice_rounded(&self) -> Option<Self> {
        match self.sensor {
            SensorBody::Rigid { edge_radius_mm } if self.rim_mm() > 0.0 && 4.0 * edge_radius_mm <= self.reach_mm() => {
                Some(Self { sensor: SensorBody::Rigid { edge_radius_mm: 2.0 * edge_radius_mm }, ..self.clone() })
            }
            _ => None,
        }
    }

    /// The same phantom without its inclusions, on the same mesh: each is of the material around it.
    pub fn without_inclusions(&self) -> Self {
        Self { phantom_materials: self.phantom.plain(&self.phantom_materials), ..self.clone() }
    }

    /// Whether it is a press [without inclusions](Self::without_inclusions) of a phantom that has some.
    pub fn is_baseline(&self) -> bool {
        !self.phantom.inclusions.is_empty() && self.phantom.plain(&self.phantom_materials) == self.phantom_materials
    }

    /// The material of the phantom's touched face.
    pub fn touched_material(&self) -> Option<&Material> {
        let layer = self.phantom.layers_mm.first().and(Some(self.phantom.inclusions.len() + 1));
        self.phantom_materials.get(layer.unwrap_or(0))
    }

    /// The phantom, with elements at the contact's edge that resolve the rim.
    pub fn body(&self) -> PhantomMesh {
        PhantomMesh { resolution: self.phantom.resolution.with_rim(self.rim_mm()), ..self.phantom.clone() }
    }

    /// Radius of the rim that the mesh resolves, mm.
    fn rim_mm(&self) -> f64 {
        match self.sensor {
            SensorBody::Rigid { .. } if self.grip == Grip::Bonded => 0.0,
            SensorBody::Rigid { edge_radius_mm } | SensorBody::Layers { edge_radius_mm, .. } => edge_radius_mm,
            // That of a flat one, where the footprint ends with it.
            SensorBody::Indenter(Profile::RoundedFlat { flat_mm, edge_radius_mm })
                if (flat_mm + edge_radius_mm - self.reach_mm()).abs() < 1e-9 * self.reach_mm() =>
            {
                edge_radius_mm
            }
            SensorBody::Indenter(_) => 0.0,
        }
    }

    /// Depth beyond which several states are in balance and the way there decides between them, mm: beside a soft
    /// sensor to which it is tied the phantom folds up at the wall (docs/decisions/rim.md). In three dimensions
    /// elements there are too large for that.
    pub(super) fn one_state_to_mm(&self) -> f64 {
        match self.sensor {
            SensorBody::Layers { .. } if self.kinematics.dim() == 2 && self.grip == Grip::Bonded => {
                ONE_STATE_TO * self.reach_mm()
            }
            _ => f64::INFINITY,
        }
    }

    /// How long steps of the load may be, mm. A curved indenter that went deeper at once would fold the face at the
    /// contact's edge, and the folds stay.
    pub(super) fn stride_mm(&self) -> Stride {
        let reach = self.reach_mm();
        match self.sensor {
            SensorBody::Indenter(_) => {
                let longest = (LONGEST_STEP * reach).min(0.5 * self.phantom.resolution.contact_mm);
                Stride { any_to: 0.0, longest }
            }
            SensorBody::Rigid { .. } | SensorBody::Layers { .. } => {
                Stride { any_to: self.one_state_to_mm(), longest: FOLDING_STEP * reach }
            }
        }
    }

    /// Poses of the asked loads, as far as they are known beforehand.
    pub(super) fn poses(&self) -> Vec<Pose> {
        match &self.load {
            Load::Depths(depths) => {
                let pose = |&depth_mm: &f64| Pose { depth_mm, hold_s: self.hold_s, ..Pose::default() };
                depths.iter().map(pose).collect()
            }
            Load::Forces(_) => Vec::new(),
            Load::Path(poses) => poses.clone(),
        }
    }

    /// Longest way that the phantom slides, mm.
    pub(super) fn slide_mm(&self) -> f64 {
        self.poses().iter().map(|pose| pose.slide_mm[0].hypot(pose.slide_mm[1])).fold(0.0, f64::max)
    }

    /// Largest distance of the touched face's outline from the axis, mm; the half width along x of a rectangle.
    pub fn reach_mm(&self) -> f64 {
        match self.phantom.footprint {
            Footprint::Round { radius_mm } => radius_mm,
            Footprint::Rectangle { half_widths_mm } => half_widths_mm[0],
        }
    }

    /// How many times the meshed part makes up the whole.
    pub fn copies(&self) -> f64 {
        match self.kinematics {
            Kinematics::ThreeDimensional => self.phantom.symmetry.iter().map(|&s| if s { 2.0 } else { 1.0 }).product(),
            Kinematics::Axisymmetric | Kinematics::PlaneStrain => 1.0,
        }
    }
}
