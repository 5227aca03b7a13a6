//! How fine a mesh is.

use super::MeshError;
use super::error::positive;
use super::fillet::rim_length_mm;

/// Sizes of elements; `subdivision` divides all of them, so that 1, 2, 3, ... is a ladder of nested meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Size at the contact's edge and at the touched face, mm.
    pub edge_mm: f64,
    /// Width of elements along r, in units of `edge_mm`: in three dimensions at a round contact's edge, in two within
    /// that edge, where light sees the slope of what the singular edge has moved past.
    pub ring_share: f64,
    /// Largest size along the touched face within the contact, mm.
    pub contact_mm: f64,
    /// Largest size anywhere, mm.
    pub coarsest_mm: f64,
    /// Growth of the size per length away from where it is given.
    pub growth: f64,
    /// Radius of the rim of what presses, mm, whose arc the lines meet and resolve; 0 where it is sharp.
    pub rim_mm: f64,
    /// Elements along that arc.
    pub rim_divisions: f64,
    /// Elements along half a side of an inclusion's box.
    pub inclusion_divisions: f64,
    /// Each of the elements above, along each axis.
    pub subdivision: usize,
}

impl Resolution {
    /// For two dimensions: about 2,000 elements for a phantom of 30 x 25 mm.
    pub const PLANE: Self = Self {
        edge_mm: 0.3,
        ring_share: 1.0,
        contact_mm: 1.4,
        coarsest_mm: 3.0,
        growth: 0.3,
        rim_mm: 0.0,
        rim_divisions: 2.0,
        inclusion_divisions: 4.0,
        subdivision: 2,
    };

    /// For three dimensions: about 3,400 elements for a quarter of the same phantom with an inclusion. Force and
    /// pressure in the middle are within 0.4 % of the plane ones; three elements along the half side of the inclusion's
    /// box leave 2 %. Rings as wide as they are high leave 6 % of the image at the rim (docs/ERROR.md).
    pub const SOLID: Self = Self {
        edge_mm: 0.9,
        ring_share: 0.33,
        contact_mm: 2.2,
        coarsest_mm: 4.5,
        growth: 0.45,
        rim_mm: 0.0,
        rim_divisions: 1.0,
        inclusion_divisions: 4.0,
        subdivision: 1,
    };

    /// The same mesh with elements of twice the size (or as near as whole numbers come), for an estimate of the error.
    pub fn halved(self) -> Self {
        if self.subdivision.is_multiple_of(2) {
            return Self { subdivision: self.subdivision / 2, ..self };
        }
        Self {
            edge_mm: 2.0 * self.edge_mm,
            contact_mm: 2.0 * self.contact_mm,
            coarsest_mm: 2.0 * self.coarsest_mm,
            growth: 2.0 * self.growth,
            rim_divisions: 0.5 * self.rim_divisions,
            inclusion_divisions: 0.5 * self.inclusion_divisions,
            ..self
        }
    }

    /// The next coarser mesh that is nested in this one, of elements `s` times as large where `s` is the least divisor
    /// of the subdivision above 1. Nothing is nested in a mesh that is not subdivided: it has [`Self::halved`].
    pub fn coarsened(self) -> Self {
        match (2..=self.subdivision).find(|&divisor| self.subdivision.is_multiple_of(divisor)) {
            Some(divisor) => Self { subdivision: self.subdivision / divisor, ..self },
            None => self.halved(),
        }
    }

    /// The same mesh with elements of half the size.
    pub fn doubled(self) -> Self {
        Self { subdivision: self.subdivision.saturating_mul(2), ..self }
    }

    /// The same mesh with elements that resolve a rim of this radius.
    pub fn with_rim(self, rim_mm: f64) -> Self {
        let arc = if rim_mm > 0.0 { rim_length_mm(rim_mm) / self.rim_divisions } else { f64::INFINITY };
        Self { edge_mm: self.edge_mm.min(arc), rim_mm, ..self }
    }

    /// The same mesh with at least so many elements along a radius within which a contact ends where it likes.
    pub fn across(self, radius_mm: f64, divisions: f64) -> Self {
        let size = radius_mm / divisions;
        Self { edge_mm: self.edge_mm.min(size), contact_mm: self.contact_mm.min(size), ..self }
    }

    /// The same mesh with elements of 1 / `fineness` times the size, as near as whole numbers come.
    pub fn finer(self, fineness: f64) -> Self {
        Self {
            growth: self.growth / fineness,
            rim_divisions: self.rim_divisions * fineness,
            inclusion_divisions: self.inclusion_divisions * fineness,
            ..self.scaled(1.0 / fineness)
        }
    }

    /// The same mesh of a body `factor` times as large.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            edge_mm: factor * self.edge_mm,
            contact_mm: factor * self.contact_mm,
            coarsest_mm: factor * self.coarsest_mm,
            growth: self.growth,
            ..self
        }
    }

    pub(super) fn check(&self) -> Result<(), MeshError> {
        positive("the element size at the contact's edge", self.edge_mm)?;
        positive("the width of rings at the contact's edge", self.ring_share)?;
        positive("the element size in the contact", self.contact_mm)?;
        positive("the largest element size", self.coarsest_mm)?;
        positive("the growth of elements", self.growth)?;
        positive("the divisions of the rim", self.rim_divisions)?;
        positive("the divisions of an inclusion", self.inclusion_divisions)?;
        positive("the subdivision of elements", self.subdivision as f64)?;
        Ok(())
    }
}
