//! The mean radiance of `contact-disc` over its disc, without tracing paths.
//!
//!     cargo run --release --example contact_exact [-- DISC_DROP_MM LED_INSET_MM POINTS]
//!
//! In a flat stack a ray runs at one fixed angle in each layer and splits in two at each interface. For a point of the
//! disc that a camera ray sees, and a direction into the guide, the whole tree of pieces is followed until less than
//! 1e-8 of the light is left; what ends on an LED or back on the disc is the light that arrives. Pixel, point and
//! direction are points of a five-dimensional lattice with 16 random shifts: the error is their spread. Shares no code
//! with the tracers.
//!
//! The two lengths are Mitsuba's stand-offs (benches/peers): its disc hangs below the touched face, its LEDs stand
//! before the walls. Takes about 2 minutes on 2 cores.

use anyhow::{Context as _, Result, ensure};
use rayon::prelude::*;
use std::f64::consts::TAU;
use tirtouch::scene::{LoadedScene, Pressure, Wall, preset};

const SMALLEST_SHARE: f64 = 1e-8;
const SHIFTS: u32 = 16;

/// The scene as numbers. Layers from the camera side, the surround first and last; face k lies above layer k.
struct Guide {
    n: Vec<f64>,
    faces: Vec<f64>,
    disc_face: usize,
    disc_radius: f64,
    albedo: f64,
    half: f64,
    led_plane: f64,
    led_height: f64,
    led_radius: f64,
    distance: f64,
    pixel_tangent: f64,
    size: [f64; 2],
}

/// One piece of the tree: where it starts, in which layer, upward or not, and its share of the light.
struct Piece {
    layer: usize,
    up: bool,
    x: f64,
    y: f64,
    share: f64,
}

fn main() -> Result<()> {
    let argument = |k: usize, default: f64| std::env::args().nth(k).map_or(Ok(default), |a| a.parse());
    let (drop, inset, points) = (argument(1, 0.0)?, argument(2, 0.0)?, argument(3, 1e7)? as u64);
    let guide = Guide::new(&preset("contact-disc")?, drop, inset)?;
    let pixels = guide.patch();
    let means: Vec<[f64; 2]> = (0..SHIFTS).into_par_iter().map(|shift| guide.mean(&pixels, shift, points)).collect();
    let estimate = |k: usize| {
        let n = f64::from(SHIFTS);
        let mean = means.iter().map(|m| m[k]).sum::<f64>() / n;
        let squares: f64 = means.iter().map(|m| (m[k] - mean).powi(2)).sum();
        (mean, (squares / n / (n - 1.0)).sqrt())
    };
    let ((total, error), (again, _)) = (estimate(0), estimate(1));
    println!("{} pixels, disc {drop} mm below the face, LEDs {inset} mm before the walls", pixels.len());
    println!("mean radiance {total:.6e} ± {error:.1e}, of it {again:.2e} from the disc to itself");
    Ok(())
}

impl Guide {
    fn new(loaded: &LoadedScene, drop: f64, inset: f64) -> Result<Self> {
        let scene = &loaded.scene;
        let contact = scene.touch.contact.as_ref().context("nothing touches")?;
        let Pressure::Disc { radius_mm, .. } = contact.pressure else { anyhow::bail!("not a disc") };
        let led = scene.led.first().context("no LED")?;
        let walls: Vec<Wall> = scene.led.iter().map(|l| l.wall).collect();
        ensure!(walls == [Wall::PlusX, Wall::MinusX, Wall::PlusY, Wall::MinusY], "not one LED on each wall");
        let surround = scene.stack.surround_n;
        let mut n = vec![surround];
        n.extend(scene.stack.layer.iter().rev().map(|l| l.index(scene.light.wavelength_nm)));
        let mut faces = scene.stack.interface_heights_mm();
        let disc_face = faces.len() - 1;
        if drop > 0.0 {
            // The disc lies between two layers of one index, which reflect nothing.
            n.push(n[disc_face]);
            faces.insert(disc_face, faces[disc_face] - drop);
        }
        n.push(surround);
        let camera = &scene.camera;
        let size = camera.pixels.map(f64::from);
        Ok(Self {
            n,
            faces,
            disc_face,
            disc_radius: radius_mm,
            albedo: contact.tissue.diffuse_reflectance.context("tissue given by coefficients")?,
            half: 0.5 * scene.stack.footprint_mm[0],
            led_plane: 0.5 * scene.stack.footprint_mm[0] - inset,
            led_height: led.height_mm,
            led_radius: 0.5 * led.diameter_mm,
            distance: camera.distance_mm,
            pixel_tangent: 2.0 * (0.5 * camera.view_angle_deg).to_radians().tan() / size[0],
            size,
        })
    }

    /// Pixels whose centres lie within 0.9 of the disc's apparent radius.
    fn patch(&self) -> Vec<[f64; 2]> {
        let depth: f64 = (1..self.n.len() - 1).map(|k| (self.faces[k] - self.faces[k - 1]) / self.n[k]).sum();
        let radius = self.disc_radius / (self.distance + depth) / self.pixel_tangent;
        let [columns, rows] = self.size.map(|s| s as u32);
        let corner =
            |k: u32| [f64::from(k % columns) - 0.5 * self.size[0], f64::from(k / columns) - 0.5 * self.size[1]];
        let near = |[x, y]: &[f64; 2]| (x + 0.5).hypot(y + 0.5) < 0.9 * radius;
        (0..columns * rows).map(corner).filter(near).collect()
    }

    /// Mean radiance over the pixels by one shift of the lattice: in all, and what went from the disc to itself.
    fn mean(&self, pixels: &[[f64; 2]], shift: u32, points: u64) -> [f64; 2] {
        // Steps of Roberts' R5 sequence: powers of the inverse root of x^6 = x + 1.
        let step = 0.881_271_461_633_569_5_f64;
        let steps: [f64; 6] = std::array::from_fn(|k| step.powi(k as i32));
        let offsets: [f64; 6] = std::array::from_fn(|k| uniform(u64::from(shift) * 6 + k as u64));
        let mut sum = [0.0; 2];
        for i in 0..points {
            let at = |k: usize| (offsets[k] + i as f64 * steps[k]).fract();
            let pixel = pixels[(at(1) * pixels.len() as f64) as usize % pixels.len()];
            let (x, y, seen) =
                self.seen((pixel[0] + at(2)) * self.pixel_tangent, (pixel[1] + at(3)) * self.pixel_tangent);
            let light = self.arriving(x, y, self.n[self.disc_face] * at(4).sqrt(), TAU * at(5));
            sum[0] += seen * (light[0] + light[1]);
            sum[1] += seen * light[1];
        }
        sum.map(|s| s / points as f64)
    }

    /// The point of the disc that a camera ray sees, and the radiance at the camera of one unit that arrives there.
    fn seen(&self, tangent_x: f64, tangent_y: f64) -> (f64, f64, f64) {
        let tangent = tangent_x.hypot(tangent_y);
        let s = self.n[0] * tangent / 1f64.hypot(tangent);
        let mut way = self.distance * tangent;
        let mut through = 1.0;
        for k in 1..=self.disc_face {
            through *= 1.0 - reflectance(self.n[k - 1], self.n[k], s);
            way += (self.faces[k] - self.faces[k - 1]) * slope(self.n[k], s);
        }
        let along = way / tangent.max(f64::MIN_POSITIVE);
        let n = self.n[self.disc_face] / self.n[0];
        (along * tangent_x, along * tangent_y, through * self.albedo / (n * n))
    }

    /// Radiance that arrives at a point of the disc from one direction: from LEDs, and from the disc itself.
    fn arriving(&self, x: f64, y: f64, s: f64, phi: f64) -> [f64; 2] {
        let (dx, dy) = (phi.cos(), phi.sin());
        let mut light = [0.0; 2];
        let mut pieces = vec![Piece { layer: self.disc_face, up: false, x, y, share: 1.0 }];
        while let Some(piece) = pieces.pop() {
            let Piece { layer, up, x, y, share } = piece;
            if share < SMALLEST_SHARE {
                continue;
            }
            let (face, beyond) = if up { (layer, layer + 1) } else { (layer - 1, layer - 1) };
            let n = self.n[layer];
            let length = (self.faces[layer] - self.faces[layer - 1]) * slope(n, s);
            let scale = (self.n[self.disc_face] / n).powi(2);
            light[0] += share * scale * self.led_hits(&piece, length, [dx, dy]);
            if wall_distance(self.half, x, dx).min(wall_distance(self.half, y, dy)) <= length {
                continue;
            }
            let (x, y) = (x + length * dx, y + length * dy);
            if face == self.disc_face && x.hypot(y) <= self.disc_radius {
                // Arriving light is taken as even over the disc: this part is 3e-4 of the whole.
                light[1] += if up { share * self.albedo * MEAN_ARRIVING } else { 0.0 };
                continue;
            }
            let reflected = reflectance(n, self.n[beyond], s);
            pieces.push(Piece { layer, up: !up, x, y, share: share * reflected });
            if beyond > 0 && beyond < self.n.len() - 1 {
                pieces.push(Piece { layer: beyond, up, x, y, share: share * (1.0 - reflected) });
            }
        }
        light
    }

    /// LEDs that a piece meets.
    fn led_hits(&self, piece: &Piece, length: f64, [dx, dy]: [f64; 2]) -> f64 {
        let (low, high) = (self.faces[piece.layer - 1], self.faces[piece.layer]);
        let hit = |[p, d]: [f64; 2], [q, e]: [f64; 2]| {
            let t = wall_distance(self.led_plane, p, d);
            let part = if piece.up { t / length } else { 1.0 - t / length };
            t <= length && (q + e * t).hypot(low + part * (high - low) - self.led_height) <= self.led_radius
        };
        let (x, y) = ([piece.x, dx], [piece.y, dy]);
        f64::from(u8::from(hit(x, y))) + f64::from(u8::from(hit(y, x)))
    }
}

/// Mean radiance that arrives at the disc, W/(m^2 sr), for the light from the disc to itself.
const MEAN_ARRIVING: f64 = 0.01404;

fn wall_distance(half: f64, p: f64, d: f64) -> f64 {
    if d == 0.0 { f64::INFINITY } else { (half.copysign(d) - p) / d }
}

/// Tangent of the angle to the axis in a medium of index n, for n sin(theta) = s.
fn slope(n: f64, s: f64) -> f64 {
    s / (n * n - s * s).max(0.0).sqrt()
}

/// Unpolarised Fresnel reflectance; 1 beyond the critical angle.
fn reflectance(n_i: f64, n_t: f64, s: f64) -> f64 {
    if s >= n_t {
        return 1.0;
    }
    let cos = |n: f64| (1.0 - (s / n).powi(2)).max(0.0).sqrt();
    let (c_i, c_t) = (cos(n_i), cos(n_t));
    let across = (n_i * c_i - n_t * c_t) / (n_i * c_i + n_t * c_t);
    let within = (n_t * c_i - n_i * c_t) / (n_t * c_i + n_i * c_t);
    0.5 * (across * across + within * within)
}

/// A random number in [0, 1) for each k: splitmix64.
fn uniform(k: u64) -> f64 {
    let mut z = (k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
