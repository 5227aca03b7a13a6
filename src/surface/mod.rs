//! Deformed interfaces and contact as the tracer sees them.
//!
//! Interface `i` lies between layer `i` and layer `i + 1`, counted from the camera side: 0 is the lower face of the
//! lowest layer, `N` the touched face of `N` layers. Flat interfaces are planes; a deformed one is a spherical cap in
//! closed form, a smooth B-spline height field, or (the touched face only) a triangle mesh in a bounding-volume tree.

pub mod build;
pub mod cap;
pub mod contact;
pub mod height_field;
pub mod mesh;
pub mod pressed;
pub mod zones;

pub use build::{SurfaceError, surface};
pub use cap::Cap;
pub use contact::{ContactMap, contact_map};
pub use height_field::HeightField;
pub use mesh::Mesh;
pub use pressed::{pressed_contact, pressed_surface};

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
    /// Height fields, one per interface; `None` where an interface is flat.
    Fields(Vec<Option<HeightField>>),
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
            Self::Mesh(_) => "triangle mesh",
        }
    }
}
