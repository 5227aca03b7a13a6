//! What a scene needs of the kernels, and what it leaves out.

use super::constants::Finish;
use super::model::{Deformation, Heights, Model, Real, Spare, Walls};

/// Pieces of the kernels that a scene needs. The GPU assembles its WGSL from them, the twin branches on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kernel {
    /// Representation of deformed interfaces.
    pub shape: ShapePiece,
    /// Both faces of some layer are deformed.
    pub deformed_pairs: bool,
    /// Some layer absorbs.
    pub absorbing: bool,
    /// Side walls are clear.
    pub clear_walls: bool,
    /// Side walls are mirrors.
    pub mirror_walls: bool,
    /// Some interface is rough.
    pub rough: bool,
    /// Tissue touches the sensor.
    pub touched: bool,
    /// Tissue ends at the edge of a disc.
    pub tissue_disc: bool,
    /// Tissue is a half space of scatterers, not Lambertian.
    pub half_space: bool,
    /// Light spreads sideways in the tissue.
    pub spreading: bool,
    /// The share of true contact varies.
    pub share_grid: bool,
    /// Some LED has a tabulated pattern.
    pub led_tables: bool,
    /// Some LED's pattern is a power of the cosine other than 1.
    pub cosine_power: bool,
    /// The camera has a lens of finite size.
    pub lens: bool,
    /// Photons that can meet no tissue, or no more, are told from above and left out: between flat, smooth faces and
    /// black walls paths run straight when seen from there.
    pub aimed: bool,
    /// Number of reflections at outer faces below which light that inner interfaces only refract is found by unfolding,
    /// not by photons of the map; 0: none.
    pub unfolded: u32,
}

/// Representation of deformed interfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShapePiece {
    /// Planes only.
    Plane,
    /// Spherical cap.
    Cap,
    /// Height fields over the plane.
    Field,
    /// Height fields about an axis.
    Profile,
    /// Triangles.
    Mesh,
}

impl Kernel {
    /// The pieces a model needs, and those it is to carry.
    pub fn of<T: Real>(model: &Model<T>) -> Self {
        let zero = T::zero();
        let carries = |piece| model.spare.contains(&piece);
        let straight = matches!(model.shape, Deformation::Plane)
            && model.walls == Walls::Black
            && model.faces.iter().all(|f| f.finish == Finish::Smooth)
            && model.tissue.as_ref().is_some_and(|t| t.disc.is_some());
        Self {
            shape: match model.shape {
                Deformation::Plane => ShapePiece::Plane,
                Deformation::Cap(_) => ShapePiece::Cap,
                Deformation::Field(ref field) => match field.heights {
                    Heights::Grid { .. } => ShapePiece::Field,
                    Heights::Profile { .. } => ShapePiece::Profile,
                },
                Deformation::Mesh(_) => ShapePiece::Mesh,
            },
            deformed_pairs: carries(Spare::DeformedPairs)
                || model.faces.windows(2).any(|pair| pair.iter().all(|f| f.share != zero)),
            absorbing: carries(Spare::Absorption) || model.layers.iter().any(|l| l.absorption > zero),
            clear_walls: model.walls == Walls::Clear,
            mirror_walls: model.walls == Walls::Mirror,
            rough: carries(Spare::Roughness) || model.faces.iter().any(|f| f.finish != Finish::Smooth),
            touched: model.tissue.is_some(),
            half_space: model.tissue.as_ref().is_some_and(|t| t.scatter.is_half_space()),
            spreading: model.tissue.as_ref().is_some_and(|t| t.spread_d > zero),
            tissue_disc: model.tissue.as_ref().is_some_and(|t| t.disc.is_some()),
            share_grid: model.tissue.as_ref().is_some_and(|t| !t.grid.is_empty()),
            led_tables: carries(Spare::LedTables) || model.leds.iter().any(|l| l.table.is_some()),
            cosine_power: carries(Spare::CosinePower) || model.leds.iter().any(|l| l.exponent != T::one()),
            lens: carries(Spare::Lens) || model.camera.lens_radius > zero,
            aimed: straight && !carries(Spare::Astray),
            unfolded: if straight && !carries(Spare::Direct) { model.unfolded } else { 0 },
        }
    }

    /// Whether some interface is deformed.
    pub fn deformed(&self) -> bool {
        self.shape != ShapePiece::Plane
    }

    /// Whether some interface is a height field, of whichever kind.
    pub fn has_fields(&self) -> bool {
        matches!(self.shape, ShapePiece::Field | ShapePiece::Profile)
    }

    /// Names of the pieces, and whether each is in.
    pub fn pieces(&self) -> [(&'static str, bool); 19] {
        [
            ("spherical cap", self.shape == ShapePiece::Cap),
            ("height fields over the plane", self.shape == ShapePiece::Field),
            ("height fields about an axis", self.shape == ShapePiece::Profile),
            ("triangle mesh", self.shape == ShapePiece::Mesh),
            ("search on both faces of a layer", self.deformed_pairs),
            ("absorption", self.absorbing),
            ("clear walls", self.clear_walls),
            ("mirror walls", self.mirror_walls),
            ("roughness", self.rough),
            ("tissue contact", self.touched),
            ("edge of the tissue", self.tissue_disc),
            ("tissue as a half space of scatterers", self.half_space),
            ("sideways spread in tissue", self.spreading),
            ("contact share grid", self.share_grid),
            ("tabulated LED patterns", self.led_tables),
            ("cosine-power LED patterns", self.cosine_power),
            ("thin lens", self.lens),
            ("photons that can meet no tissue", self.touched && !self.aimed),
            ("photons for light that unfolding finds", self.touched && self.unfolded == 0),
        ]
    }
}
