//! The structs of the shaders, member for member as in `scene.wgsl`; a test holds them to naga's offsets.

use crate::trace::launch::{self, scramble};
use crate::trace::model::{Deformation, Heights, Model};
use crate::trace::scatter::Scatter;
use bytemuck::{Pod, Zeroable};

macro_rules! shader_struct {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $kind:ty),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
        #[allow(missing_docs)]
        pub struct $name { $(pub $field: $kind),* }

        impl Wgsl for $name {
            fn wgsl(&self, numbers: &mut Numbers) -> String {
                format!("{}({})", stringify!($name), [$(self.$field.wgsl(numbers)),*].join(", "))
            }
        }

        #[cfg(test)]
        impl $name {
            fn members() -> Vec<(&'static str, usize)> {
                vec![$((stringify!($field), std::mem::offset_of!($name, $field))),*]
            }
        }
    };
}

/// The numbers of a scene that its kernels read from a buffer.
///
/// A kernel's text holds none of them, so that scenes of the same make share it. 0 and 1 are of the make: they stand
/// for what is not there, and drivers fold them.
#[derive(Debug, Default)]
pub struct Numbers(Vec<f32>);

impl Numbers {
    /// A number as a WGSL expression. Equal ones are held once.
    pub(super) fn hold(&mut self, value: f32) -> String {
        // WGSL has no infinity.
        let value = value.clamp(f32::MIN, f32::MAX);
        if value == 0.0 || value == 1.0 {
            return format!("{:.1}", value.abs());
        }
        let place = self.0.iter().position(|held| *held == value).unwrap_or_else(|| {
            self.0.push(value);
            self.0.len() - 1
        });
        format!("number_{place}")
    }

    /// In the order in which the buffer holds them.
    pub fn values(&self) -> &[f32] {
        &self.0
    }

    /// WGSL that declares them, and reads them all. As variables of their own they stay in a CPU driver's registers and
    /// stack; read from the buffer where they are needed they made kernels three times slower.
    pub(super) fn wgsl(&self) -> String {
        let count = self.0.len();
        let each = |write: fn(usize) -> String| (0..count).map(write).collect::<String>();
        format!(
            "@group(0) @binding(0) var<storage, read> numbers: array<f32, {}>;\n{}fn read_numbers() {{{} }}\n",
            count.max(1),
            each(|k| format!("var<private> number_{k}: f32;\n")),
            each(|k| format!(" number_{k} = numbers[{k}];")),
        )
    }
}

/// A value as a WGSL expression.
pub(super) trait Wgsl {
    fn wgsl(&self, numbers: &mut Numbers) -> String;
}

impl Wgsl for f32 {
    fn wgsl(&self, numbers: &mut Numbers) -> String {
        numbers.hold(*self)
    }
}

impl Wgsl for u32 {
    fn wgsl(&self, _: &mut Numbers) -> String {
        format!("{self}u")
    }
}

impl<T: Wgsl> Wgsl for [T; 2] {
    fn wgsl(&self, numbers: &mut Numbers) -> String {
        format!("vec2({}, {})", self[0].wgsl(numbers), self[1].wgsl(numbers))
    }
}

shader_struct! {
    /// `Scene` of `scene.wgsl`.
    Scene {
        half_size: [f32; 2], layer_count: u32, led_count: u32,
        wall_reflectance: f32, surround_n: f32, tissue_n: f32, tissue_albedo: f32,
        tissue_center: [f32; 2], tissue_radius_sq: f32, spread_d: f32,
        share_size: [u32; 2], share: f32, reentry_contact: f32,
        map_size: [u32; 2], reentry_gap: f32, ball_radius: f32,
        cap_center: [f32; 2], cap_rim_sq: f32, cap_depth: f32,
        field_size: [u32; 2], field_scale: [f32; 2],
        image_size: [u32; 2], pixel_tan: f32, camera_distance: f32,
        lens_radius: f32, focus_distance: f32, tissue_dn_sq: f32, gap_dn_sq: f32,
        field_center: [f32; 2],
        quarter_albedo: f32, h_floor: f32, map_cosines: [f32; 2], map_toward: [f32; 2], map_between: [f32; 2],
    }
}

shader_struct! {
    /// `Run` of `scene.wgsl`.
    Run {
        seed: u32, first: u32, count: u32, threads: u32, samples: u32, first_sample: u32,
        scramble_led: u32, scramble_radius: u32, scramble_turn: u32, scramble_polar: u32, scramble_azimuth: u32, scramble_side: u32,
    }
}

impl Run {
    /// Numbers of a submission, with what scrambles its seed's launches.
    pub fn of(seed: u32, [first, count]: [u32; 2], [first_sample, samples]: [u32; 2]) -> Self {
        Self {
            seed,
            first,
            count,
            threads: count,
            samples,
            first_sample,
            scramble_led: scramble(seed, launch::LED),
            scramble_radius: scramble(seed, launch::RADIUS),
            scramble_turn: scramble(seed, launch::TURN),
            scramble_polar: scramble(seed, launch::POLAR),
            scramble_azimuth: scramble(seed, launch::AZIMUTH),
            scramble_side: scramble(seed, launch::SIDE),
        }
    }
}

/// The scene of a model.
pub fn scene(m: &Model<f32>) -> Scene {
    let size = |s: [usize; 2]| s.map(|v| v as u32);
    let mut out = Scene {
        half_size: m.half_size,
        layer_count: m.faces.len() as u32 - 1,
        led_count: m.leds.len() as u32,
        wall_reflectance: m.wall_reflectance,
        surround_n: m.surround_n,
        map_size: size(m.map_size),
        image_size: m.camera.size,
        pixel_tan: m.camera.pixel_tan,
        camera_distance: m.camera.distance,
        lens_radius: m.camera.lens_radius,
        focus_distance: m.camera.focus,
        ..Default::default()
    };
    if let Some(t) = &m.tissue {
        out.tissue_n = t.n;
        if let Some(disc) = t.disc {
            (out.tissue_center, out.tissue_radius_sq) = (disc.center, disc.radius_sq);
        }
        out.spread_d = t.spread_d;
        out.share_size = size(t.grid_size);
        out.share = t.share;
        out.tissue_dn_sq = t.dn_sq;
        out.gap_dn_sq = t.gap_dn_sq;
        match &t.scatter {
            Scatter::Lambertian(t) => {
                out.tissue_albedo = t.albedo;
                out.reentry_contact = t.reentry_contact;
                out.reentry_gap = t.reentry_gap;
            }
            Scatter::HalfSpace(t) => {
                (out.quarter_albedo, out.h_floor) = (t.quarter_albedo, t.floor);
                (out.map_cosines, out.map_toward, out.map_between) = (t.cosines, t.toward, t.between);
            }
        }
    }
    match &m.shape {
        Deformation::Cap(c) => {
            (out.ball_radius, out.cap_depth) = (c.ball, c.depth);
            (out.cap_center, out.cap_rim_sq) = (c.center, c.rim_sq);
        }
        Deformation::Field(f) => {
            out.field_center = f.center;
            (out.field_size, out.field_scale) = match &f.heights {
                Heights::Grid { size: points, per_mm, .. } => (size(*points), *per_mm),
                Heights::Profile { per_mm, cells } => (size([cells.first().map_or(0, Vec::len), 1]), [*per_mm; 2]),
            };
        }
        Deformation::Plane | Deformation::Mesh(_) => {}
    }
    out
}

/// The deformed shape: words of bindings 8 and 9 of the surface pieces.
pub fn shape(m: &Model<f32>) -> (Vec<f32>, Vec<f32>) {
    match &m.shape {
        Deformation::Plane | Deformation::Cap(_) => (Vec::new(), Vec::new()),
        Deformation::Field(f) => match &f.heights {
            Heights::Grid { size, control, .. } => {
                let rows = control.iter().flat_map(|c| c.chunks(size[0] + 2));
                (rows.flat_map(|row| row.windows(4).flatten().copied()).collect(), Vec::new())
            }
            Heights::Profile { cells, .. } => (cells.iter().flatten().flatten().copied().collect(), Vec::new()),
        },
        Deformation::Mesh(mesh) => {
            let word = f32::from_bits;
            let node = |n: &crate::surface::mesh::Node| {
                let ([a, b, c], [d, e, f]) = (n.low, n.high);
                [a, b, c, word(n.count), d, e, f, word(n.first)]
            };
            let triangles = mesh.corners.iter().zip(&mesh.normals);
            let points = triangles.flat_map(|(c, n)| c.iter().chain(n));
            (mesh.nodes.iter().flat_map(node).collect(), points.flat_map(|p| [p[0], p[1], p[2], 0.0]).collect())
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::trace::gpu::assemble::{Entry, source};
    use crate::trace::modes::CameraMode;

    #[test]
    fn uniforms_have_the_offsets_that_naga_sees() {
        let loaded = crate::scene::preset("contact-disc").unwrap();
        let surface = crate::surface::surface(&loaded).unwrap();
        let contact = crate::surface::contact_map(&loaded).unwrap();
        let model = Model::new(&loaded, &surface, contact).unwrap().cast();
        let text = source(&model, Entry::Camera(CameraMode::Path), false).0;
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        let check = |name: &str, members: Vec<(&str, usize)>, size: usize| {
            let (_, found) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).unwrap();
            let naga::TypeInner::Struct { members: theirs, span } = &found.inner else {
                panic!("{name} is not a struct");
            };
            let theirs: Vec<_> = theirs.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
            assert_eq!(theirs, members, "{name}");
            assert_eq!(*span as usize, size, "{name}");
        };
        check("Scene", Scene::members(), size_of::<Scene>());
        check("Run", Run::members(), size_of::<Run>());
    }
}
