//! From a validated scene to the tracer's model.

use super::constants::Finish;
use super::disc::Disc;
use super::model::{Camera, CapShape, Deformation, Face, FieldShape, Heights, Layer, MeshShape, Model, Tissue, Walls};
use super::scatter::Scatter;
use super::symmetry::Symmetry;
use super::{leds, unfold};
use crate::optics::{fresnel, tissue};
use crate::scene::{self, LoadedScene, Roughness};
use crate::surface::{ContactMap, Relief, Surface, SurfaceError};
use std::f64::consts::PI;

impl Model<f64> {
    /// Builds the model of a validated scene.
    ///
    /// # Errors
    /// `File` for an IES pattern that cannot be used, or is dark along its normal where its radiance there is given;
    /// `Shape` where the brightest LED is too dark or too bright for the images (1e-9 to 1e12 W/(m^2 sr)).
    pub fn new(loaded: &LoadedScene, surface: &Surface, contact: Option<ContactMap>) -> Result<Self, SurfaceError> {
        let scene = &loaded.scene;
        let n_0 = scene.stack.surround_n;
        let layers = layers(scene);
        let heights = scene.stack.interface_heights_mm();
        let (shape, shares) = shape(surface, heights.len());
        let faces = faces(scene, surface, &layers, &heights, &shares);
        let mut lit = leds::leds(loaded)?;
        let n_top = layers[layers.len() - 2].n;
        let tissue = match (&scene.touch.contact, contact) {
            (Some(c), Some(map)) => Some(tissue_of(&c.tissue, map, n_top, n_0)),
            _ => None,
        };
        let half_size = scene.stack.footprint_mm.map(|f| 0.5 * f);
        let aimed_share =
            tissue.as_ref().and_then(|t| t.disc).map_or(1.0, |disc| leds::aim(&mut lit.leds, half_size, disc));
        let texels = |extent: f64| ((extent / scene.render.map_texel_mm).round() as usize).max(2);
        let (walls, wall_reflectance) = match scene.stack.walls {
            scene::Walls::Black => (Walls::Black, 0.0),
            scene::Walls::Clear => (Walls::Clear, 0.0),
            scene::Walls::Mirror { reflectance } => (Walls::Mirror, reflectance),
        };
        let mut model = Self {
            half_size,
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
            map_smoothing: scene.render.map_smoothing,
            symmetry: Symmetry::none(),
            unit_radiance: lit.unit_radiance,
            power: lit.power,
            aimed_share,
            unfolded: 0,
            spare: Vec::new(),
        };
        model.unfolded = unfold::reflections(&model);
        if scene.render.symmetry {
            model.symmetry = Symmetry::of(&model);
        }
        Ok(model)
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

fn shape(surface: &Surface, interfaces: usize) -> (Deformation<f64>, Vec<f64>) {
    let mut shares: Vec<f64> = (0..interfaces).map(|i| f64::from(u8::from(surface.relief(i).is_some()))).collect();
    let shape = match surface {
        Surface::Flat => Deformation::Plane,
        Surface::Cap { cap, share } => {
            shares.clone_from(share);
            Deformation::Cap(CapShape {
                center: cap.center_mm,
                ball: cap.ball_radius_mm(),
                depth: cap.depth_mm,
                rim_sq: cap.rim_mm * cap.rim_mm,
            })
        }
        Surface::Fields(fields) => {
            let fields = || fields.iter().flatten();
            let (size, per_mm) = fields().next().map_or(([0; 2], [0.0; 2]), |f| ([f.columns, f.rows], f.per_mm));
            let control = fields().map(|f| f.control.clone()).collect();
            Deformation::Field(FieldShape { heights: Heights::Grid { size, per_mm, control }, center: [0.0; 2] })
        }
        Surface::Profiles(profiles) => {
            let profiles = || profiles.iter().flatten();
            let (per_mm, center) = profiles().next().map_or((0.0, [0.0; 2]), |p| (p.per_mm, p.center_mm));
            let cells = profiles().map(|p| p.cells.clone()).collect();
            Deformation::Field(FieldShape { heights: Heights::Profile { per_mm, cells }, center })
        }
        Surface::Mesh(mesh) => {
            if let Some(last) = shares.last_mut() {
                *last = 1.0;
            }
            Deformation::Mesh(MeshShape {
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
            let (finish, rough, alpha) = match *rough {
                Roughness::None => (Finish::Smooth, 0.0, 0.0),
                Roughness::Small { rms_nm, lobe_slope } => {
                    let k = 4.0 * PI * rms_nm / scene.light.wavelength_nm;
                    (Finish::Small, k * k, std::f64::consts::SQRT_2 * lobe_slope)
                }
                Roughness::Microfacet { alpha } => (Finish::Microfacet, 0.0, alpha),
            };
            let mut face = Face {
                z,
                share,
                dn_sq: (n_above - n_below) * (n_above + n_below),
                slope: 0.0,
                curvature: 0.0,
                low: 0.0,
                high: 0.0,
                field: 0,
                rough,
                alpha,
                finish,
            };
            if let Some(relief) = surface.relief(i) {
                face.follow(relief);
                face.field = field;
                field += 1;
            }
            match surface {
                Surface::Cap { cap, .. } => face.slope = (share * cap.steepest() * (1.0 + 1e-5)).min(UNBOUNDED),
                Surface::Mesh(mesh) if share != 0.0 => {
                    (face.low, face.high) = (mesh.low_mm - z, mesh.high_mm - z);
                    // No facet is met from above by a ray that rises faster than all of them, whatever the mesh.
                    face.slope = (mesh.steepest() * (1.0 + 1e-5)).min(UNBOUNDED);
                }
                _ => {}
            }
            face
        })
        .collect()
}

/// Slope of a face that may rise in any way: its square is finite in f32.
const UNBOUNDED: f64 = 1e15;

impl Face<f64> {
    /// Takes on a relief's bounds.
    pub(super) fn follow(&mut self, relief: &dyn Relief) {
        let [low, high] = relief.range_mm();
        // A thousandth beyond, so that the slab holds the surface in f32 too.
        (self.low, self.high) = (low - 1e-3, high + 1e-3);
        self.slope = relief.steepest() * (1.0 + 1e-5);
        self.curvature = relief.bend();
    }
}

fn tissue_of(t: &scene::Tissue, map: ContactMap, n_top: f64, n_0: f64) -> Tissue<f64> {
    let contact = |cos: f64| fresnel::reflectance(cos, t.n, n_top);
    let gap = |cos: f64| {
        let first = fresnel::reflectance(cos, t.n, n_0);
        let sin_sq = (1.0 - cos * cos) * t.n * t.n / (n_0 * n_0);
        if sin_sq >= 1.0 {
            return 1.0;
        }
        fresnel::incoherent_slab(first, fresnel::reflectance((1.0 - sin_sq).sqrt(), n_0, n_top))
    };
    let scatter = match (t.diffuse_reflectance, t.reduced_scattering_per_mm, t.absorption_per_mm) {
        (None, Some(s), Some(a)) => Scatter::half_space(&tissue::HalfSpace::new(s, a), contact, gap),
        (given, _, _) => Scatter::lambertian(given.unwrap_or(0.0), contact, gap),
    };
    Tissue {
        n: t.n,
        scatter,
        spread_d: t.spread_mm / 2.5,
        disc: map.disc.map(|disc| Disc { center: disc.center_mm, radius_sq: disc.radius_mm * disc.radius_mm }),
        share: map.uniform,
        grid_size: [map.columns, map.rows],
        grid: map.share,
        dn_sq: (t.n - n_top) * (t.n + n_top),
        gap_dn_sq: (n_0 - n_top) * (n_0 + n_top),
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
