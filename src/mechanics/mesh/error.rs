//! What can be wrong with the description of a mesh.

use thiserror::Error;

/// A mesh that cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshError {
    /// A size that must be positive and finite is not.
    #[error("{what} must be positive and finite, is {value}")]
    NotPositive {
        /// The name of the size.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// More elements than a press can be solved with.
    #[error("the mesh would have {elements} elements, at most {limit} are allowed; choose a coarser resolution")]
    TooMany {
        /// Elements asked for.
        elements: usize,
        /// Elements allowed.
        limit: usize,
    },
    /// An inclusion crosses the boundary of the phantom, or all but touches it.
    #[error(
        "inclusion {inclusion} is {gap_mm} mm from the {face} (negative: it sticks out), at least {least_mm} mm are needed"
    )]
    SticksOut {
        /// Number of the inclusion, from 1.
        inclusion: usize,
        /// The face.
        face: &'static str,
        /// Free space between inclusion and face, mm.
        gap_mm: f64,
        /// Space needed, mm.
        least_mm: f64,
    },
    /// Two inclusions that no plane across an axis separates.
    #[error(
        "inclusions {first} and {second} overlap or cannot be boxed apart: their bounding boxes are {gap_mm} mm apart \
         (negative: they overlap), at least {least_mm} mm are needed"
    )]
    NotApart {
        /// Number of the first, from 1.
        first: usize,
        /// Number of the second, from 1.
        second: usize,
        /// Largest gap over the axes, mm.
        gap_mm: f64,
        /// Gap needed, mm.
        least_mm: f64,
    },
    /// Two inclusions that overlap, or all but touch.
    #[error(
        "inclusions {first} and {second} overlap or all but touch: their gap is {gap_mm} mm (negative: they overlap), at \
         least {least_mm} mm are needed"
    )]
    Overlap {
        /// Number of the first, from 1.
        first: usize,
        /// Number of the second, from 1.
        second: usize,
        /// Gap along a ray from the centre of one of them, mm.
        gap_mm: f64,
        /// Gap needed, mm.
        least_mm: f64,
    },
    /// An inclusion for which a mesh has no element.
    #[error("the mesh is too coarse for inclusion {inclusion}; choose a finer resolution")]
    TooCoarse {
        /// Number of the inclusion, from 1.
        inclusion: usize,
    },
    /// Inclusions too thin or too near something for elements between that do not fold.
    #[error("elements around an inclusion fold near {at_mm:?} mm; choose a finer resolution, or more room there")]
    NotFitted {
        /// The place, mm.
        at_mm: [f64; 3],
    },
    /// An inclusion that a plane of symmetry cuts elsewhere than through its centre.
    #[error(
        "inclusion {inclusion}, centred at {center_mm} mm along {axis}, is cut by the plane of symmetry {axis} = 0; \
         centre it there or give up the symmetry"
    )]
    CutBySymmetry {
        /// Number of the inclusion, from 1.
        inclusion: usize,
        /// The axis across the plane.
        axis: char,
        /// Its centre along that axis, mm.
        center_mm: f64,
    },
    /// A surface that a ray from its centre does not leave exactly once.
    #[error(
        "inclusion {inclusion} is not star-shaped about its centre: the ray along {direction:?} meets its surface {hits} times"
    )]
    NotStarShaped {
        /// Number of the inclusion, from 1.
        inclusion: usize,
        /// The ray.
        direction: [f64; 3],
        /// Crossings found.
        hits: usize,
    },
    /// In a round phantom, inclusions or a square footprint too far out for the mesh of squares in its middle.
    #[error("{what} reaches {reach_mm} mm from the axis along x or y; a round phantom is meshed up to {limit_mm} mm")]
    TooFarOut {
        /// What reaches too far.
        what: &'static str,
        /// How far, mm.
        reach_mm: f64,
        /// How far it may, mm.
        limit_mm: f64,
    },
    /// A sensor asked to share the contact's nodes with a phantom whose mesh does not carry the contact's edge.
    #[error(
        "the phantom's mesh has no element edges along the contact's edge at {edge_mm} mm to share with the sensor"
    )]
    NoSharedEdge {
        /// The edge of the contact, mm.
        edge_mm: f64,
    },
    /// An element turned inside out.
    #[error("element {element} at {at_mm:?} mm is folded: its Jacobian is {jacobian}")]
    Folded {
        /// The element.
        element: usize,
        /// Its middle.
        at_mm: [f64; 3],
        /// Smallest Jacobian determinant at its quadrature points.
        jacobian: f64,
    },
}

/// A size, if it is positive and finite.
pub(super) fn positive(what: &'static str, value: f64) -> Result<f64, MeshError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(MeshError::NotPositive { what, value }) }
}
