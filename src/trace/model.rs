//! A scene as the tracers see it: plain numbers, in f64 for the host and cast to the precision of each tracer.
//!
//! Layers are numbered from the camera side: 0 is the surround below, 1 the lowest layer, N the touched one, N + 1 the
//! surround above. Interface i lies between layers i and i + 1.

use super::constants::Finish;
use super::disc::Disc;
use super::leds::Led;
pub use super::real::Real;
use super::scatter::Scatter;
use super::symmetry::Symmetry;

/// A piece that a kernel can carry without a use for it. The image is the same, the time is not (on a GPU; the twin in
/// Rust branches on few of them).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spare {
    /// A search on both faces of a layer.
    DeformedPairs,
    /// Exponentials.
    Absorption,
    /// Both models of roughness.
    Roughness,
    /// Tabulated patterns.
    LedTables,
    /// Cosine-power patterns.
    CosinePower,
    /// Points on a lens.
    Lens,
    /// Photons that can meet no tissue.
    Astray,
    /// Photons for light that unfolding finds.
    Direct,
}

/// Side walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walls {
    /// Absorb.
    Black,
    /// Fresnel against the surround.
    Clear,
    /// Specular mirrors.
    Mirror,
}

/// One layer (or the surround).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer<T> {
    /// Refractive index.
    pub n: T,
    /// Its square.
    pub n_sq: T,
    /// Absorption, per mm.
    pub absorption: T,
    /// Square of the surround's index minus that of this layer.
    pub side_dn_sq: T,
}

/// One interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face<T> {
    /// Height where undeformed, mm.
    pub z: T,
    /// Share of the touched face's displacement; 0: flat.
    pub share: T,
    /// Square of the index above minus that below.
    pub dn_sq: T,
    /// Bound on how steep it is.
    pub slope: T,
    /// Bound on the second derivative of its height field along any direction, per mm.
    pub curvature: T,
    /// Lowest displacement, mm.
    pub low: T,
    /// Highest displacement, mm.
    pub high: T,
    /// Which height field it has.
    pub field: usize,
    /// (4 pi sigma / lambda)^2 for small roughness.
    pub rough: T,
    /// GGX width of the lobe or of the microfacets.
    pub alpha: T,
    /// Whether it is rough.
    pub finish: Finish,
}

/// How interfaces are deformed.
#[derive(Debug, Clone)]
pub enum Deformation<T> {
    /// None is deformed.
    Plane,
    /// Spherical cap.
    Cap(CapShape<T>),
    /// Height fields.
    Field(FieldShape<T>),
    /// Triangles.
    Mesh(MeshShape<T>),
}

/// A spherical cap, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CapShape<T> {
    /// Centre.
    pub center: [T; 2],
    /// Radius of the ball.
    pub ball: T,
    /// Depth.
    pub depth: T,
    /// Square of the rim's radius.
    pub rim_sq: T,
}

/// Height fields of one grid, or about one axis.
#[derive(Debug, Clone)]
pub struct FieldShape<T> {
    /// Where the heights are.
    pub heights: Heights<T>,
    /// The axis, or the middle of the grid, mm.
    pub center: [T; 2],
}

/// Heights of the fields.
#[derive(Debug, Clone)]
pub enum Heights<T> {
    /// Over the plane.
    Grid {
        /// Samples along x and y.
        size: [usize; 2],
        /// Samples per mm.
        per_mm: [T; 2],
        /// Control points of each field, (rows + 2) x (columns + 2), mm.
        control: Vec<Vec<T>>,
    },
    /// Over the distance to the axis.
    Profile {
        /// Cells per mm.
        per_mm: T,
        /// Coefficients of each field's cells, lowest power first, mm.
        cells: Vec<Vec<[T; 4]>>,
    },
}

/// Triangles and their tree.
#[derive(Debug, Clone)]
pub struct MeshShape<T> {
    /// Corners.
    pub corners: Vec<[[T; 3]; 3]>,
    /// Normals at the corners.
    pub normals: Vec<[[T; 3]; 3]>,
    /// Nodes.
    pub nodes: Vec<crate::surface::mesh::Node>,
}

/// Tissue in optical contact.
#[derive(Debug, Clone)]
pub struct Tissue<T> {
    /// Refractive index.
    pub n: T,
    /// What it does with light that enters it.
    pub scatter: Scatter<T>,
    /// Scale of the lateral profile, mm (its mean distance is 2.5 times this).
    pub spread_d: T,
    /// Where it is; `None`: over the whole face.
    pub disc: Option<Disc<T>>,
    /// Share of true contact where there is no grid.
    pub share: T,
    /// Columns and rows of the share grid.
    pub grid_size: [usize; 2],
    /// Shares at cell centres; empty: `share` everywhere.
    pub grid: Vec<T>,
    /// n_tissue^2 - n_top^2.
    pub dn_sq: T,
    /// n_surround^2 - n_top^2.
    pub gap_dn_sq: T,
}

/// Camera geometry, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera<T> {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Tangent of the view angle per pixel.
    pub pixel_tan: T,
    /// Pinhole (lens) to the lowest face.
    pub distance: T,
    /// Radius of the pupil; 0: pinhole.
    pub lens_radius: T,
    /// Lens to the plane in focus.
    pub focus: T,
}

/// A scene as plain numbers.
#[derive(Debug, Clone)]
pub struct Model<T> {
    /// Half the footprint, mm.
    pub half_size: [T; 2],
    /// Index of the surround.
    pub surround_n: T,
    /// Side walls.
    pub walls: Walls,
    /// Reflectance of mirror walls.
    pub wall_reflectance: T,
    /// Surround, layers, surround.
    pub layers: Vec<Layer<T>>,
    /// Interfaces.
    pub faces: Vec<Face<T>>,
    /// How interfaces are deformed.
    pub shape: Deformation<T>,
    /// LEDs.
    pub leds: Vec<Led<T>>,
    /// Intensity tables of the LEDs: relative radiance and cumulative share of the power.
    pub led_tables: Vec<[T; 2]>,
    /// Tissue, where something touches.
    pub tissue: Option<Tissue<T>>,
    /// Camera.
    pub camera: Camera<T>,
    /// Texels of the irradiance map along x and y.
    pub map_size: [usize; 2],
    /// Whether it is smoothed.
    pub map_smoothing: bool,
    /// What it stays the same under.
    pub symmetry: Symmetry,
    /// Radiance that one unit of the film stands for, W/(m^2 sr).
    pub unit_radiance: f64,
    /// Power of all LEDs in units of `unit_radiance` times mm^2.
    pub power: f64,
    /// Share of that power that aimed photons stand for.
    pub aimed_share: f64,
    /// Number of reflections below which unfolding finds light, where the stack is straight; 0: none.
    pub unfolded: u32,
    /// Pieces that the kernels carry though the scene does not need them.
    pub spare: Vec<Spare>,
}

impl Model<f64> {
    /// Casts every number to the precision of a tracer.
    pub fn cast<T: Real>(&self) -> Model<T> {
        let pair = |v: [f64; 2]| v.map(T::of);
        let triple = |v: &[[f64; 3]; 3]| v.map(|p| p.map(T::of));
        let of = T::of;
        Model {
            half_size: pair(self.half_size),
            surround_n: of(self.surround_n),
            walls: self.walls,
            wall_reflectance: of(self.wall_reflectance),
            layers: self
                .layers
                .iter()
                .map(|l| Layer {
                    n: of(l.n),
                    n_sq: of(l.n_sq),
                    absorption: of(l.absorption),
                    side_dn_sq: of(l.side_dn_sq),
                })
                .collect(),
            faces: self
                .faces
                .iter()
                .map(|f| Face {
                    z: of(f.z),
                    share: of(f.share),
                    dn_sq: of(f.dn_sq),
                    slope: of(f.slope),
                    curvature: of(f.curvature),
                    low: of(f.low),
                    high: of(f.high),
                    field: f.field,
                    rough: of(f.rough),
                    alpha: of(f.alpha),
                    finish: f.finish,
                })
                .collect(),
            shape: match &self.shape {
                Deformation::Plane => Deformation::Plane,
                Deformation::Cap(c) => Deformation::Cap(CapShape {
                    center: pair(c.center),
                    ball: of(c.ball),
                    depth: of(c.depth),
                    rim_sq: of(c.rim_sq),
                }),
                Deformation::Field(f) => Deformation::Field(FieldShape {
                    heights: match &f.heights {
                        Heights::Grid { size, per_mm, control } => Heights::Grid {
                            size: *size,
                            per_mm: pair(*per_mm),
                            control: control.iter().map(|c| c.iter().map(|&v| of(v)).collect()).collect(),
                        },
                        Heights::Profile { per_mm, cells } => Heights::Profile {
                            per_mm: of(*per_mm),
                            cells: cells.iter().map(|c| c.iter().map(|cubic| cubic.map(T::of)).collect()).collect(),
                        },
                    },
                    center: pair(f.center),
                }),
                Deformation::Mesh(m) => Deformation::Mesh(MeshShape {
                    corners: m.corners.iter().map(triple).collect(),
                    normals: m.normals.iter().map(triple).collect(),
                    nodes: m.nodes.clone(),
                }),
            },
            leds: self.leds.iter().map(Led::cast).collect(),
            led_tables: self.led_tables.iter().map(|&t| pair(t)).collect(),
            tissue: self.tissue.as_ref().map(|t| Tissue {
                n: of(t.n),
                scatter: t.scatter.cast(),
                spread_d: of(t.spread_d),
                disc: t.disc.map(|disc| Disc { center: pair(disc.center), radius_sq: of(disc.radius_sq) }),
                share: of(t.share),
                grid_size: t.grid_size,
                grid: t.grid.iter().map(|&v| of(v)).collect(),
                dn_sq: of(t.dn_sq),
                gap_dn_sq: of(t.gap_dn_sq),
            }),
            camera: Camera {
                size: self.camera.size,
                pixel_tan: of(self.camera.pixel_tan),
                distance: of(self.camera.distance),
                lens_radius: of(self.camera.lens_radius),
                focus: of(self.camera.focus),
            },
            map_size: self.map_size,
            map_smoothing: self.map_smoothing,
            symmetry: self.symmetry.clone(),
            unit_radiance: self.unit_radiance,
            power: self.power,
            aimed_share: self.aimed_share,
            unfolded: self.unfolded,
            spare: self.spare.clone(),
        }
    }
}
