//! A scene as the tracers see it: plain numbers, in f64 for the host and cast to the precision of each tracer.
//!
//! Layers are numbered from the camera side: 0 is the surround below, 1 the lowest layer, N the touched one, N + 1 the
//! surround above. Interface i lies between layers i and i + 1.

use super::leds::{self, Led};
use crate::optics::{fresnel, tissue};
use crate::scene::{self, LoadedScene, Roughness};
use crate::surface::{ContactMap, Surface, SurfaceError};
use num_traits::{Float, FromPrimitive};
use std::f64::consts::PI;

/// A floating-point type the CPU twin runs in.
pub trait Real: Float + FromPrimitive + Send + Sync + std::fmt::Debug + 'static {
    /// Rounds an f64 to this type.
    fn of(v: f64) -> Self;
    /// Widens to f64.
    fn wide(self) -> f64;
}

impl Real for f32 {
    fn of(v: f64) -> Self {
        v as f32
    }
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    fn of(v: f64) -> Self {
        v
    }
    fn wide(self) -> f64 {
        self
    }
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
    /// Bound on the second derivative of its height field, per mm.
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
    /// 0 smooth, 1 small roughness, 2 microfacets.
    pub kind: u32,
}

/// Shape of the deformed interfaces.
#[derive(Debug, Clone)]
pub enum Shape<T> {
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

/// Height fields of one grid.
#[derive(Debug, Clone)]
pub struct FieldShape<T> {
    /// Samples along x and y.
    pub size: [usize; 2],
    /// Samples per mm.
    pub per_mm: [T; 2],
    /// Control points of each field, (rows + 2) x (columns + 2), mm.
    pub control: Vec<Vec<T>>,
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
    /// Share returned diffusely.
    pub albedo: T,
    /// Scale of the lateral profile, mm (its mean distance is 2.5 times this).
    pub spread_d: T,
    /// Centre, mm.
    pub center: [T; 2],
    /// Square of its radius, mm^2.
    pub radius_sq: T,
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
    /// Diffuse internal reflectance, tissue to guide, through true contact.
    pub reentry_contact: T,
    /// The same through the air gap.
    pub reentry_gap: T,
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
    /// Shape of the deformed interfaces.
    pub shape: Shape<T>,
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
    /// Radiance that one unit of the film stands for, W/(m^2 sr).
    pub unit_radiance: f64,
    /// Power of all LEDs in units of `unit_radiance` times mm^2.
    pub power: f64,
}

impl Model<f64> {
    /// Builds the model of a validated scene.
    pub fn new(loaded: &LoadedScene, surface: &Surface, contact: Option<ContactMap>) -> Result<Self, SurfaceError> {
        let scene = &loaded.scene;
        let n_0 = scene.stack.surround_n;
        let layers = layers(scene);
        let heights = scene.stack.interface_heights_mm();
        let (shape, shares) = shape(surface, heights.len());
        let faces = faces(scene, surface, &layers, &heights, &shares);
        let lit = leds::leds(loaded)?;
        let n_top = layers[layers.len() - 2].n;
        let tissue = match (&scene.touch.contact, contact) {
            (Some(c), Some(map)) => Some(tissue_of(&c.tissue, map, n_top, n_0)),
            _ => None,
        };
        let texels = |extent: f64| ((extent / scene.render.map_texel_mm).round() as usize).max(2);
        let (walls, wall_reflectance) = match scene.stack.walls {
            scene::Walls::Black => (Walls::Black, 0.0),
            scene::Walls::Clear => (Walls::Clear, 0.0),
            scene::Walls::Mirror { reflectance } => (Walls::Mirror, reflectance),
        };
        Ok(Self {
            half_size: scene.stack.footprint_mm.map(|f| 0.5 * f),
            surround_n: n_0,
            walls,
            wall_reflectance,
            layers,
            faces,
            shape,
            leds: lit.leds,
            led_tables: lit.tables,
            tissue,
            camera: camera(&scene.camera),
            map_size: scene.stack.footprint_mm.map(texels),
            unit_radiance: lit.unit_radiance,
            power: lit.power,
        })
    }

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
                    curvature: of(f.curvature),
                    low: of(f.low),
                    high: of(f.high),
                    field: f.field,
                    rough: of(f.rough),
                    alpha: of(f.alpha),
                    kind: f.kind,
                })
                .collect(),
            shape: match &self.shape {
                Shape::Plane => Shape::Plane,
                Shape::Cap(c) => Shape::Cap(CapShape {
                    center: pair(c.center),
                    ball: of(c.ball),
                    depth: of(c.depth),
                    rim_sq: of(c.rim_sq),
                }),
                Shape::Field(f) => Shape::Field(FieldShape {
                    size: f.size,
                    per_mm: pair(f.per_mm),
                    control: f.control.iter().map(|c| c.iter().map(|&v| of(v)).collect()).collect(),
                }),
                Shape::Mesh(m) => Shape::Mesh(MeshShape {
                    corners: m.corners.iter().map(triple).collect(),
                    normals: m.normals.iter().map(triple).collect(),
                    nodes: m.nodes.clone(),
                }),
            },
            leds: self.leds.iter().map(Led::cast).collect(),
            led_tables: self.led_tables.iter().map(|&t| pair(t)).collect(),
            tissue: self.tissue.as_ref().map(|t| Tissue {
                n: of(t.n),
                albedo: of(t.albedo),
                spread_d: of(t.spread_d),
                center: pair(t.center),
                radius_sq: of(t.radius_sq),
                share: of(t.share),
                grid_size: t.grid_size,
                grid: t.grid.iter().map(|&v| of(v)).collect(),
                dn_sq: of(t.dn_sq),
                gap_dn_sq: of(t.gap_dn_sq),
                reentry_contact: of(t.reentry_contact),
                reentry_gap: of(t.reentry_gap),
            }),
            camera: Camera {
                size: self.camera.size,
                pixel_tan: of(self.camera.pixel_tan),
                distance: of(self.camera.distance),
                lens_radius: of(self.camera.lens_radius),
                focus: of(self.camera.focus),
            },
            map_size: self.map_size,
            unit_radiance: self.unit_radiance,
            power: self.power,
        }
    }
}

fn layers(scene: &scene::Scene) -> Vec<Layer<f64>> {
    let n_0 = scene.stack.surround_n;
    let layer = |n: f64, absorption: f64| Layer { n, n_sq: n * n, absorption, side_dn_sq: (n_0 - n) * (n_0 + n) };
    let inside = scene.stack.layer.iter().rev();
    std::iter::once(layer(n_0, 0.0))
        .chain(inside.map(|l| layer(l.index(scene.light.wavelength_nm), l.absorption_per_mm)))
        .chain(std::iter::once(layer(n_0, 0.0)))
        .collect()
}

fn shape(surface: &Surface, interfaces: usize) -> (Shape<f64>, Vec<f64>) {
    let mut shares = vec![0.0; interfaces];
    let shape = match surface {
        Surface::Flat => Shape::Plane,
        Surface::Cap { cap, share } => {
            shares.clone_from(share);
            Shape::Cap(CapShape {
                center: cap.center_mm,
                ball: cap.ball_radius_mm(),
                depth: cap.depth_mm,
                rim_sq: cap.rim_mm * cap.rim_mm,
            })
        }
        Surface::Fields(fields) => {
            let mut control = Vec::new();
            let (mut size, mut per_mm) = ([0, 0], [0.0; 2]);
            for (share, field) in shares.iter_mut().zip(fields) {
                if let Some(f) = field {
                    *share = 1.0;
                    (size, per_mm) = ([f.columns, f.rows], f.per_mm);
                    control.push(f.control.clone());
                }
            }
            Shape::Field(FieldShape { size, per_mm, control })
        }
        Surface::Mesh(mesh) => {
            if let Some(last) = shares.last_mut() {
                *last = 1.0;
            }
            Shape::Mesh(MeshShape {
                corners: mesh.corners.clone(),
                normals: mesh.normals.clone(),
                nodes: mesh.nodes.clone(),
            })
        }
    };
    (shape, shares)
}

fn faces(
    scene: &scene::Scene,
    surface: &Surface,
    layers: &[Layer<f64>],
    heights: &[f64],
    shares: &[f64],
) -> Vec<Face<f64>> {
    let roughness =
        std::iter::once(&scene.stack.lower_roughness).chain(scene.stack.layer.iter().rev().map(|l| &l.upper_roughness));
    let mut field = 0;
    heights
        .iter()
        .zip(shares)
        .zip(roughness)
        .enumerate()
        .map(|(i, ((&z, &share), rough))| {
            let (n_below, n_above) = (layers[i].n, layers[i + 1].n);
            let (kind, rough, alpha) = match *rough {
                Roughness::None => (0, 0.0, 0.0),
                Roughness::Small { rms_nm, lobe_slope } => {
                    let k = 4.0 * PI * rms_nm / scene.light.wavelength_nm;
                    (1, k * k, std::f64::consts::SQRT_2 * lobe_slope)
                }
                Roughness::Microfacet { alpha } => (2, 0.0, alpha),
            };
            let mut face = Face {
                z,
                share,
                dn_sq: (n_above - n_below) * (n_above + n_below),
                curvature: 0.0,
                low: 0.0,
                high: 0.0,
                field: 0,
                rough,
                alpha,
                kind,
            };
            match surface {
                Surface::Fields(fields) => {
                    if let Some(Some(f)) = fields.get(i) {
                        let [low, high] = f.range_mm();
                        // A thousandth beyond, so that the slab holds the surface in f32 too.
                        (face.low, face.high) = (low - 1e-3, high + 1e-3);
                        face.curvature = f.curvature_bound();
                        face.field = field;
                        field += 1;
                    }
                }
                Surface::Mesh(mesh) if share != 0.0 => (face.low, face.high) = (mesh.low_mm - z, mesh.high_mm - z),
                _ => {}
            }
            face
        })
        .collect()
}

fn tissue_of(t: &scene::Tissue, map: ContactMap, n_top: f64, n_0: f64) -> Tissue<f64> {
    let albedo = match (t.diffuse_reflectance, t.reduced_scattering_per_mm, t.absorption_per_mm) {
        (Some(r), _, _) => r,
        (None, Some(s), Some(a)) => tissue::diffuse_reflectance(s, a),
        _ => 0.0,
    };
    let contact = |cos: f64| fresnel::reflectance(cos, t.n, n_top);
    let gap = |cos: f64| {
        let first = fresnel::reflectance(cos, t.n, n_0);
        let sin_sq = (1.0 - cos * cos) * t.n * t.n / (n_0 * n_0);
        if sin_sq >= 1.0 {
            return 1.0;
        }
        fresnel::incoherent_slab(first, fresnel::reflectance((1.0 - sin_sq).sqrt(), n_0, n_top))
    };
    Tissue {
        n: t.n,
        albedo,
        spread_d: t.spread_mm / 2.5,
        center: map.center_mm,
        radius_sq: (map.radius_mm * map.radius_mm).min(1e30),
        share: map.uniform,
        grid_size: [map.columns, map.rows],
        grid: map.share,
        dn_sq: (t.n - n_top) * (t.n + n_top),
        gap_dn_sq: (n_0 - n_top) * (n_0 + n_top),
        reentry_contact: fresnel::lambertian_mean(contact),
        reentry_gap: fresnel::lambertian_mean(gap),
    }
}

fn camera(c: &scene::Camera) -> Camera<f64> {
    let [w, h] = c.pixels.map(f64::from);
    let span = match c.view_axis {
        scene::ViewAxis::Width => w,
        scene::ViewAxis::Height => h,
        scene::ViewAxis::Diagonal => w.hypot(h),
    };
    let pixel_tan = 2.0 * (0.5 * c.view_angle_deg).to_radians().tan() / span;
    let (lens_radius, focus) = match c.lens {
        scene::Lens::Pinhole => (0.0, 0.0),
        // Pupil radius f / 2N with the focal length from pitch and view angle.
        scene::Lens::ThinLens { focus_mm } => {
            (1e-3 * c.pixel_pitch_um / pixel_tan / (2.0 * c.sensor.f_number), focus_mm)
        }
    };
    Camera { size: c.pixels, pixel_tan, distance: c.distance_mm, lens_radius, focus }
}
