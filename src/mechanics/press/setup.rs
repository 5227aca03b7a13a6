//! What is pressed against what.

use crate::mechanics::contact::Grip;
use crate::mechanics::element::PressureOrder;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, PhantomMesh};

/// Description of a press.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Setting: axisymmetric or three-dimensional.
    pub kinematics: Kinematics,
    /// Order of the elements' pressure.
    pub pressure: PressureOrder,
    /// The phantom, its inclusions and its mesh; the footprint is the sensor's face.
    pub phantom: PhantomMesh,
    /// Material of the phantom, then of each inclusion.
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
    /// Turn of the phantom about x, then y, through the middle of the touched face, degrees; three dimensions only.
    pub tilt_deg: [f64; 2],
}

/// The sensor's body.
#[derive(Debug, Clone)]
pub enum SensorBody {
    /// Rigid and flat, with a rounded edge where it is not bonded.
    Rigid {
        /// Radius of the edge's rounding, mm.
        edge_radius_mm: f64,
    },
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
}

impl Setup {
    /// The same press on elements of twice the size.
    pub fn halved(&self) -> Self {
        Self { phantom: self.phantom.halved(), ..self.clone() }
    }

    /// The same press on the next coarser mesh, nested in this one where there is such a mesh.
    pub fn coarsened(&self) -> Self {
        let phantom = PhantomMesh { resolution: self.phantom.resolution.coarsened(), ..self.phantom.clone() };
        Self { phantom, ..self.clone() }
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

    /// The same phantom without its inclusions, on the same mesh.
    pub fn without_inclusions(&self) -> Self {
        let mut setup = self.clone();
        if let Some(body) = self.phantom_materials.first() {
            setup.phantom_materials.iter_mut().for_each(|material| *material = body.clone());
        }
        setup
    }

    /// Whether it is a press [without inclusions](Self::without_inclusions) of a phantom that has some.
    pub fn is_baseline(&self) -> bool {
        let inclusions = self.phantom_materials.iter().skip(1);
        inclusions.len() > 0 && inclusions.into_iter().all(|material| Some(material) == self.phantom_materials.first())
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
        }
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
