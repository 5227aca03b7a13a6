//! Error of the reflected direction, by the tracer's twin against the dent's closed form.

use super::candidates::{CAP, Dent};
use tirtouch::trace::Model;
use tirtouch::trace::cpu::vec3::{V3, v3};
use tirtouch::trace::cpu::{Limits, Path};
use tirtouch::trace::model::Real;

/// Root-mean-square angles between reflected rays and the exact ones, radians.
pub struct Errors {
    /// Over the dent.
    pub all: f64,
    /// Further than 0.5 mm from the cap's rim; a Gaussian has none.
    pub off_rim: f64,
    /// The same traced in f32.
    pub off_rim_f32: f64,
}

/// Rays compared.
const RAYS: u32 = 20_000;
const RIM_ZONE_MM: f64 = 0.5;

/// A ray below the touched face: origin, and momentum over its index.
type Ray = (V3<f64>, V3<f64>);

/// Errors of a model's touched face. The rays are the camera's (paraxial), spread evenly over the dent.
pub fn errors(dent: &Dent, model: &Model<f64>) -> Errors {
    let single: Model<f32> = model.cast();
    let (mut all, mut off_rim, mut off_rim_f32) = (Sum::default(), Sum::default(), Sum::default());
    for k in 0..RAYS {
        // Roberts' R2 sequence.
        let r = dent.reach_mm * (f64::from(k) * 0.754_877_666_246_693).fract().sqrt();
        let phi = std::f64::consts::TAU * (f64::from(k) * 0.569_840_290_998_053).fract();
        let ray = camera_ray(model, r * phi.cos(), r * phi.sin());
        let exact = reflect_exactly(dent, top_mm(model), ray);
        all.add(reflect(model, ray), exact);
        if dent.sigma_mm.is_some() || r < CAP.rim_mm - RIM_ZONE_MM {
            off_rim.add(reflect(model, ray), exact);
            off_rim_f32.add(reflect(&single, ray), exact);
        }
    }
    Errors { all: all.rms(), off_rim: off_rim.rms(), off_rim_f32: off_rim_f32.rms() }
}

#[derive(Default)]
struct Sum {
    squares: f64,
    count: f64,
}

impl Sum {
    fn add(&mut self, a: V3<f64>, b: V3<f64>) {
        let d = a - b;
        self.squares += d.dot(d);
        self.count += 1.0;
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

fn top_mm(model: &Model<f64>) -> f64 {
    model.faces[model.faces.len() - 1].z
}

/// The camera's ray that would meet the undeformed face at (x, y), from 2 mm below it.
fn camera_ray(model: &Model<f64>, x: f64, y: f64) -> Ray {
    let heights = model.faces.windows(2).zip(&model.layers[1..]);
    let apparent = model.camera.distance + heights.map(|(f, l)| (f[1].z - f[0].z) / l.n).sum::<f64>();
    let n = model.layers[model.layers.len() - 2].n;
    let (sx, sy) = (x / apparent / n, y / apparent / n);
    let p = v3(sx, sy, (1.0 - sx * sx - sy * sy).sqrt());
    (v3(x, y, top_mm(model)) - p * (2.0 / p.z), p)
}

fn mirrored(p: V3<f64>, normal: V3<f64>) -> V3<f64> {
    p - normal * (2.0 * p.dot(normal))
}

/// By bisection: the camera's rays are steeper than the dents, so each meets its dent once.
fn reflect_exactly(dent: &Dent, top: f64, (o, p): Ray) -> V3<f64> {
    let (mut low, mut high) = (0.0, 3.0 / p.z);
    for _ in 0..60 {
        let t = 0.5 * (low + high);
        let q = o + p * t;
        if q.z < top + dent.height(q.x, q.y)[0] { low = t } else { high = t }
    }
    let q = o + p * low;
    let [_, dx, dy] = dent.height(q.x, q.y);
    mirrored(p, v3(-dx, -dy, 1.0).normalize())
}

/// By the tracer, in its precision.
fn reflect<T: Real>(model: &Model<T>, (o, p): Ray) -> V3<f64> {
    let top = model.faces.len() - 1;
    let cast = |v: V3<f64>| v3(T::of(v.x), T::of(v.y), T::of(v.z));
    let mut path = Path::new(model, Limits::default());
    path.p = cast(p);
    path.layer = top;
    let o = cast(o);
    let t = path.surface_cross(top, o, path.p, T::one(), T::of(1e30));
    let normal = path.surface_normal(top, o + path.p * t, T::one());
    mirrored(p, v3(normal.x.wide(), normal.y.wide(), normal.z.wide()))
}
