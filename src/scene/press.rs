//! The press: phantom and sensor brought together.

use super::{Inclusion, Indenter, Phantom, PhantomBody, Stack};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the phantom is pressed against the sensor. The shape of the interfaces and the contact pressure follow from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Press {
    /// Displacements of the phantom's base towards the sensor from first touch, ascending, mm. Give these, `forces_n`
    /// or steps.
    pub depths_mm: Option<Vec<f64>>,
    /// Total forces, ascending, N. Give these, `depths_mm` or steps.
    pub forces_n: Option<Vec<f64>>,
    /// A motion in steps, one after another: press, hold, slide and lift. Each is read and traced. Give these,
    /// `depths_mm` or `forces_n`.
    pub step: Vec<PressStep>,
    /// Whether the sensor gives way. Default: `deformable`.
    pub sensor: PressedSensor,
    /// A rigid indenter in the sensor's place, a body of revolution about the axis, for `sensor = "rigid"` and faces
    /// that slide. It guides no light: `press` takes such a scene, `render` and `run` do not. Pressure is singular at a
    /// sharp tip and at each bend of a table, and grows there with the resolution. Absent: the sensor presses.
    pub indenter: Option<Indenter>,
    /// The face of the sensor that the phantom can touch, centred on the axis. Absent: the stack's footprint. Of an
    /// indenter, where elements are small: a disc. Absent: out to where the indenter lies as far below its tip as it is
    /// pressed in, and farther by the longest slide; the whole of a rounded flat one whose edge is at most half as wide
    /// as its flat.
    pub footprint: Option<FaceOutline>,
    /// What happens along the touching faces. Default: `frictionless`.
    pub interface: Interface,
    /// Radius of the rim of the sensor's touched face, mm; 0 is sharp. Absent: 0 where tied; where faces slide 0.5, or
    /// as far as a third of the face's half width and half of the topmost soft layer allow, because a sharp rim that
    /// slides is singular (and none that is moulded is sharp). A rigid sensor that is tied has none.
    pub edge_radius_mm: Option<f64>,
    /// Turn of the phantom about the axes x and y through the middle of the sensor's face, degrees. Sliding faces are
    /// tilted from the start, and depths count from where they first meet. Tied faces lie flat on each other at rest:
    /// there the base turns as it comes down, and has turned all the way at the last depth. Default: `[0, 0]`.
    pub tilt_deg: [f64; 2],
    /// Place of the phantom's axis against that of the touched face, mm. Inclusions move with the phantom. Default:
    /// `[0, 0]`.
    pub offset_mm: [f64; 2],
    /// Dimensions of the finite elements. Default: `auto`.
    pub dimensions: Dimensions,
    /// Fineness of the mesh: 2 halves the size of all elements. Default: 1.
    pub resolution: f64,
    /// Whether a second press on a coarser mesh estimates the error. Default: true.
    pub estimate_error: bool,
    /// Speed of the phantom's base, mm/s; matters to materials with relaxation. Absent: so slow that all is relaxed.
    pub rate_mm_per_s: Option<f64>,
    /// Time for which each depth is held before it is read, s. Default: 0.
    pub hold_s: f64,
}

/// Radius of the rim where faces slide and nothing is said, mm: an edge broken as moulds' are.
const SLIDING_EDGE_RADIUS_MM: f64 = 0.5;

/// Largest radius of the rim, as a share of the touched face's half width.
const LARGEST_EDGE: f64 = 1.0 / 3.0;

impl Default for Press {
    fn default() -> Self {
        Self {
            depths_mm: None,
            forces_n: None,
            step: Vec::new(),
            sensor: PressedSensor::default(),
            indenter: None,
            footprint: None,
            interface: Interface::default(),
            edge_radius_mm: None,
            tilt_deg: [0.0; 2],
            offset_mm: [0.0; 2],
            dimensions: Dimensions::default(),
            resolution: 1.0,
            estimate_error: true,
            rate_mm_per_s: None,
            hold_s: 0.0,
        }
    }
}

/// One step of a motion: the phantom's base goes straight to a place, and stays there for a time.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PressStep {
    /// Displacement of the base towards the sensor from first touch, mm. Absent: as before.
    pub depth_mm: Option<f64>,
    /// Displacement of the base along x and y, mm. Absent: as before.
    pub slide_mm: Option<[f64; 2]>,
    /// Time for which it then stays there, s; matters to materials with relaxation. Default: 0.
    pub hold_s: f64,
}

/// Whether the sensor gives way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PressedSensor {
    /// Its layers deform as their `elastic` says; layers without it are rigid.
    #[default]
    Deformable,
    /// It stays flat, or an indenter is in its place.
    Rigid,
}

/// Outline of the touched face, centred on the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum FaceOutline {
    /// A disc.
    Round {
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// A rectangle.
    Rectangle {
        /// Half its widths along x and y, mm.
        half_widths_mm: [f64; 2],
    },
}

/// What happens along touching faces.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields, tag = "kind")]
pub enum Interface {
    /// They stick from the start and cannot part: sticky tissue, silicone on silicone.
    Tied,
    /// They slide freely and can part: wet or oiled tissue. The mildest assumption, so the default.
    #[default]
    Frictionless,
    /// They slide against Coulomb friction and can part: dry tissue.
    Coulomb {
        /// Coefficient of friction, without unit.
        friction: f64,
    },
}

/// Dimensions of the finite elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Dimensions {
    /// Two where phantom, inclusions and touched face are bodies of revolution about the axis, three otherwise.
    #[default]
    Auto,
    /// Axisymmetric.
    Two,
    /// Three.
    Three,
}

impl Press {
    /// The face of the sensor that the phantom can touch.
    pub fn face(&self, stack: &Stack) -> FaceOutline {
        self.footprint
            .unwrap_or(FaceOutline::Rectangle { half_widths_mm: stack.footprint_mm.map(|extent| extent / 2.0) })
    }

    /// Radius of the rim of the sensor's touched face, mm.
    pub fn edge_radius_mm(&self, stack: &Stack) -> f64 {
        let rigid = self.sensor == PressedSensor::Rigid;
        let unsaid = || match stack.layer.iter().find(|layer| layer.elastic.is_some()) {
            _ if self.interface == Interface::Tied => 0.0,
            Some(top) if !rigid => SLIDING_EDGE_RADIUS_MM.min(0.5 * top.thickness_mm),
            _ => SLIDING_EDGE_RADIUS_MM,
        };
        self.edge_radius_mm.unwrap_or_else(|| unsaid().min(self.largest_edge_radius_mm(stack)))
    }

    /// Largest radius of the rim that the touched face has room for, mm.
    pub fn largest_edge_radius_mm(&self, stack: &Stack) -> f64 {
        let [x, y] = self.face(stack).half_widths_mm();
        x.min(y) * LARGEST_EDGE
    }

    /// The largest depth that is asked, mm; `None` where forces are.
    pub fn deepest_mm(&self) -> Option<f64> {
        let depths = self.depths_mm.iter().flatten().copied().chain(self.step.iter().filter_map(|step| step.depth_mm));
        self.forces_n.is_none().then(|| depths.fold(0.0, f64::max))
    }

    /// Where the steps slide the phantom, mm.
    pub fn slides(&self) -> impl Iterator<Item = [f64; 2]> {
        self.step.iter().filter_map(|step| step.slide_mm)
    }

    /// Why the press cannot be computed in two dimensions; `None` where phantom, inclusions and touched face are bodies
    /// of revolution about one axis.
    pub fn asymmetry(&self, phantom: &Phantom, stack: &Stack) -> Option<String> {
        let on_axis = |one: &Inclusion| {
            let round = one.shape.semi_axes_mm().is_some_and(|semi| semi[0] == semi[1]);
            round && one.center_mm == [0.0; 2]
        };
        if self.indenter.is_none() && matches!(self.face(stack), FaceOutline::Rectangle { .. }) {
            return Some("the touched face is a rectangle".to_owned());
        }
        if self.tilt_deg != [0.0; 2] {
            return Some("press.tilt_deg tilts the phantom".to_owned());
        }
        if self.offset_mm != [0.0; 2] {
            return Some("press.offset_mm moves the phantom off the axis".to_owned());
        }
        if self.slides().any(|slide| slide != [0.0; 2]) {
            return Some("press.step slides the phantom off the axis".to_owned());
        }
        if matches!(phantom.shape, PhantomBody::Block { .. }) {
            return Some("the phantom is a block".to_owned());
        }
        let odd = phantom.inclusion.iter().position(|one| !on_axis(one))?;
        Some(format!("phantom.inclusion[{odd}] is off the axis or not round about it"))
    }
}

impl FaceOutline {
    /// Half the widths along x and y, mm.
    pub fn half_widths_mm(&self) -> [f64; 2] {
        match self {
            Self::Round { radius_mm } => [*radius_mm; 2],
            Self::Rectangle { half_widths_mm } => *half_widths_mm,
        }
    }

    /// Farthest point from the axis, mm.
    pub fn reach_mm(&self) -> f64 {
        match self {
            Self::Round { radius_mm } => *radius_mm,
            Self::Rectangle { half_widths_mm: [x, y] } => x.hypot(*y),
        }
    }
}
