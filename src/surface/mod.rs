//! Deformed interfaces and contact as the tracer sees them.
//!
//! Interface `i` lies between layer `i` and layer `i + 1`, counted from the camera side: 0 is the lower face of the
//! lowest layer, `N` the touched face of `N` layers. Flat interfaces are planes; a deformed one is a spherical cap in
//! closed form, a smooth height field over the plane or about an axis, or (the touched face only) a triangle mesh in a
//! bounding-volume tree.

pub mod build;
pub mod cap;
pub mod contact;
pub mod height_field;
pub mod mesh;
pub mod pressed;
pub mod profile;

pub use build::{SurfaceError, surface};
pub use cap::Cap;
pub use contact::{ContactMap, TissueDisc, contact_map};
pub use height_field::HeightField;
pub use mesh::Mesh;
pub use pressed::{pressed_contact, pressed_surface};
pub use profile::Profile;

/// Shape of all interfaces of a stack.
#[derive(Debug, Clone)]
pub enum Surface {
    /// Every interface is a plane.
    Flat,
    /// A spherical cap; interface `i` carries `share[i]` of its depth.
    Cap {
        /// The cap in the touched face.
        cap: Cap,
        /// Share of the displacement, one per interface, 1 at the touched face.
        share: Vec<f64>,
    },
    /// Height fields of one grid, one per interface; `None` where an interface is flat.
    Fields(Vec<Option<HeightField>>),
    /// Height fields about one axis, one per interface; `None` where an interface is flat.
    Profiles(Vec<Option<Profile>>),
    /// The touched face as a mesh; the others are flat.
    Mesh(Mesh),
}

impl Surface {
    /// Whether any interface is deformed.
    pub fn is_deformed(&self) -> bool {
        !matches!(self, Self::Flat)
    }

    /// Name of the representation, for reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Flat => "planes",
            Self::Cap { .. } => "spherical cap in closed form",
            Self::Fields(_) => "B-spline height field",
            Self::Profiles(_) => "height field about an axis",
            Self::Mesh(_) => "triangle mesh",
        }
    }
    /// The height field of interface `i`, where it has one.
    pub fn relief(&self, i: usize) -> Option<&dyn Relief> {
        match self {
            Self::Fields(fields) => fields.get(i)?.as_ref().map(|field| field as &dyn Relief),
            Self::Profiles(profiles) => profiles.get(i)?.as_ref().map(|profile| profile as &dyn Relief),
            Self::Flat | Self::Cap { .. } | Self::Mesh(_) => None,
        }
    }
}

/// A height field, over the plane or about an axis.
pub trait Relief {
    /// Lowest and highest displacement, or somewhat beyond, mm.
    fn range_mm(&self) -> [f64; 2];

    /// Proven bound on the norm of the gradient.
    fn steepest(&self) -> f64;

    /// Proven bound on the second derivative along any unit direction, per mm.
    fn bend(&self) -> f64;

    /// Displacement and its gradient at a point of the footprint (centre at the origin). mm and mm/mm.
    fn at(&self, x: f64, y: f64) -> [f64; 3];
}
