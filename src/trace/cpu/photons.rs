//! Twin of `photons.wgsl`: photons from the LEDs, the ledger, the irradiance map and the splat.

use super::fresnel::fresnel;
use super::{End, Limits, Path, V3, book, units};
use crate::trace::constants::{ENTERED, EVENT_END, EVENT_TISSUE, MIRRORED, SPLAT_STEPS};
use crate::trace::model::{Model, Real};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::atomic::{AtomicU64, Ordering};

/// Where photons leave light: 64-bit fixed point with 32 fractional bits, so that the order does not matter.
#[derive(Debug)]
pub struct Deposits<'a> {
    /// Two cells per texel (true contact, gap), or one per pixel.
    pub cells: &'a [AtomicU64],
    /// Splat into pixels; otherwise the irradiance map.
    pub splatted: bool,
}

/// Part of a photon that waits while another is on its way.
#[derive(Debug, Clone, Copy)]
pub struct Part<T> {
    o: V3<T>,
    p: V3<T>,
    normal: V3<T>,
    layer: usize,
    weight: T,
    bounces: u32,
    turns: u32,
}

/// Units of one deposit.
pub const DEPOSIT_UNIT: f64 = 4_294_967_296.0;

/// Sends `samples` photons from each of `threads` threads, numbered as on the GPU; returns the ledger.
pub fn send<T: Real>(
    model: &Model<T>,
    deposits: Option<&Deposits>,
    seed: u32,
    threads: u32,
    [first_sample, samples]: [u32; 2],
    limits: Limits,
) -> [i64; book::SLOTS] {
    (0..threads)
        .into_par_iter()
        .map(|thread| {
            let mut path = Path::new(model, limits);
            path.deposits = deposits;
            for s in first_sample..first_sample + samples {
                path.photon(seed, thread, s);
            }
            path.tally
        })
        .reduce(|| [0; book::SLOTS], |a, b| std::array::from_fn(|k| a[k] + b[k]))
}

impl<T: Real> Path<'_, T> {
    /// Sends one photon and books its fate.
    pub fn photon(&mut self, seed: u32, thread: u32, sample: u32) {
        self.aimed = self.kernel.aimed && self.deposits.is_some();
        self.start_random(seed, thread, sample);
        let mut end = self.launch();
        self.tally[book::EMITTED] += units(T::one());
        if self.aimed && end == End::GoesOn && self.astray() {
            self.record(EVENT_END + End::Astray as u32, T::one());
            return;
        }
        loop {
            if end != End::GoesOn {
                self.close(end);
                if !self.go_on_mirrored() {
                    return;
                }
            }
            end = self.walk();
            if end == End::Touch {
                end = self.photon_touch();
            }
        }
    }

    /// The last booking of a photon, or of a part of it.
    fn close(&mut self, end: End) {
        self.record(EVENT_END + end as u32, T::one());
        let slot = match end {
            End::Sides => book::SIDES,
            End::Top => book::TOP,
            End::Bottom if self.enters_lens() => book::DETECTED,
            End::Bottom => book::BOTTOM,
            End::Cap => book::TERMINATED,
            End::Roulette => book::ROULETTE,
            End::Lost => {
                self.tally[book::LOST] += 1;
                return;
            }
            _ => book::ABSORBED,
        };
        self.tally[slot] += units(self.weight);
    }

    fn enters_lens(&self) -> bool {
        let camera = &self.model.camera;
        if !self.kernel.lens || self.p.z >= T::zero() {
            return false;
        }
        let t = (self.o.z + camera.distance) / self.p.z;
        let (x, y) = (self.o.x - self.p.x * t, self.o.y - self.p.y * t);
        x * x + y * y <= camera.lens_radius * camera.lens_radius
    }

    fn deposit(&self, at: usize, v: T) {
        if let Some(cell) = self.deposits.and_then(|d| d.cells.get(at)) {
            let light = (v.wide() * DEPOSIT_UNIT) as u64;
            let old = cell.fetch_add(light, Ordering::Relaxed);
            // Whoever wraps the sum fills it afterwards, so it is full in the end.
            if old.checked_add(light).is_none() {
                cell.fetch_max(u64::MAX, Ordering::Relaxed);
            }
        }
    }

    fn texel(&self, x: T, y: T) -> usize {
        let cell = |v: T, half: T, n: usize| {
            let g = (v / (T::of(2.0) * half) + T::of(0.5)) * T::of(n as f64);
            g.max(T::zero()).min(T::of(n as f64 - 1.0)).to_usize().unwrap_or(0)
        };
        let [columns, rows] = self.model.map_size;
        cell(y, self.model.half_size[1], rows) * columns + cell(x, self.model.half_size[0], columns)
    }

    /// Light of flux `w` that entered the tissue at the cosine `mu_i` and leaves it at (x, y), connected to the pinhole
    /// through the flat stack.
    fn splat(&mut self, x: T, y: T, w: T, mu_i: T) {
        let (zero, one) = (T::zero(), T::one());
        let model = self.model;
        let Some(tissue) = model.tissue.as_ref() else {
            return;
        };
        let (n_0, camera, top) = (model.surround_n, &model.camera, self.top());
        let r = (x * x + y * y).sqrt();
        let (mut low, mut high) = (zero, n_0);
        let mut s = r / (camera.distance / n_0 + model.faces[top].z / model.layers[1].n);
        if s >= high {
            s = T::of(0.5) * high;
        }
        let mut slope = zero;
        for _ in 0..SPLAT_STEPS {
            let c_0 = (n_0 * n_0 - s * s).sqrt();
            let mut reach = camera.distance * s / c_0;
            slope = camera.distance * n_0 * n_0 / (c_0 * c_0 * c_0);
            for k in 1..=top {
                let n_sq = model.layers[k].n_sq;
                let c = (n_sq - s * s).sqrt();
                let d = model.faces[k].z - model.faces[k - 1].z;
                reach = reach + d * s / c;
                slope = slope + d * n_sq / (c * c * c);
            }
            if reach > r {
                high = s;
            } else {
                low = s;
            }
            let next = s + (r - reach) / slope;
            let step = if next >= low && next < high { next } else { T::of(0.5) * (low + high) };
            if (step - s).abs() < T::of(1e-7) {
                break;
            }
            s = step;
        }
        let mut c = (model.layers[top].n_sq - s * s).max(zero).sqrt();
        let w = w * tissue.sent(mu_i, tissue.cosine(c));
        let mut through = one - self.boundary(x, y, c).mixed;
        for k in (1..=top).rev() {
            let layer = model.layers[k];
            if self.kernel.absorbing {
                let d = model.faces[k].z - model.faces[k - 1].z;
                through = through * (-layer.absorption * d * layer.n / c).exp();
            }
            let dn_sq = model.faces[k - 1].dn_sq;
            let below = (c * c - dn_sq).max(zero).sqrt();
            through = through * (one - fresnel(c, below, layer.n_sq, layer.n_sq - dn_sq));
            c = below;
        }
        let cos_c = c / n_0;
        let s_over_r = if r < T::of(1e-4) { one / slope } else { s / r };
        let toward = if r == zero { [zero, zero] } else { [x / r, y / r] };
        let [columns, rows] = camera.size;
        let half = |n: u32| T::of(0.5 * f64::from(n));
        let at_x = half(columns) + toward[0] * (s / c) / camera.pixel_tan;
        let at_y = half(rows) - toward[1] * (s / c) / camera.pixel_tan;
        let within = |v: T, n: u32| v >= zero && v < T::of(f64::from(n));
        if !within(at_x, columns) || !within(at_y, rows) {
            return;
        }
        let solid = camera.pixel_tan * camera.pixel_tan * cos_c * cos_c * cos_c;
        let light = w * through * s_over_r / (T::of(PI) * tissue.n * tissue.n * cos_c * slope * solid);
        let pixel = at_y.to_usize().unwrap_or(0) * columns as usize + at_x.to_usize().unwrap_or(0);
        self.deposit(pixel, light);
    }

    /// Splats what tissue sends back of flux `w` that entered it at (x, y).
    fn leave_tissue(&mut self, x: T, y: T, w: T, mu_i: T) {
        let (mut x, mut y) = (x, y);
        if self.kernel.spreading {
            (x, y) = self.displace(x, y);
            if !self.inside(x, y) {
                return;
            }
        }
        self.splat(x, y, w, mu_i);
    }

    pub(super) fn tissue_reentry(&mut self, mu: T) {
        if self.deposits.is_some_and(|d| d.splatted) {
            self.leave_tissue(self.o.x, self.o.y, self.weight, mu);
        }
    }

    /// Both parts go on with their shares of the weight: what enters at once and by roulette, what is mirrored later.
    fn split(&mut self, r: T, mu: T) -> End {
        let (before, least) = (self.weight, T::of(ENTERED));
        let entered = (T::one() - r) * before;
        let keep = entered / least;
        self.weight = r * before;
        let u = self.draw();
        self.record(EVENT_TISSUE + u32::from(u >= keep), (u - keep).abs());
        self.book(book::ROULETTE, before, self.weight);
        if u >= keep {
            self.touch_reflect();
            return End::GoesOn;
        }
        let Self { o, p, normal, layer, weight, bounces, turns, .. } = *self;
        self.mirrored = Some(Part { o, p, normal, layer, weight, bounces, turns });
        self.weight = entered.max(least);
        self.book(book::ROULETTE, T::zero(), self.weight);
        self.tissue_walk(mu)
    }

    /// Takes up the mirrored part, where one waits.
    fn go_on_mirrored(&mut self) -> bool {
        let Some(part) = self.mirrored.take() else {
            return false;
        };
        let Part { o, p, normal, layer, weight, bounces, turns } = part;
        (self.o, self.p, self.normal) = (o, p, normal);
        (self.layer, self.weight, self.bounces, self.turns) = (layer, weight, bounces, turns);
        self.touch_reflect();
        true
    }

    /// At tissue: leaves light behind, and says how the photon goes on.
    pub fn photon_touch(&mut self) -> End {
        let Some(tissue) = self.tissue() else {
            return End::Absorbed;
        };
        let one = T::one();
        let a = self.p.dot(self.normal).abs();
        let r = self.boundary(self.o.x, self.o.y, a);
        let mu = tissue.cosine(a);
        if let Some(deposits) = self.deposits {
            if deposits.splatted {
                if r.mixed < one {
                    self.leave_tissue(self.o.x, self.o.y, self.weight * (one - r.mixed), mu);
                }
            } else if self.turns >= self.kernel.unfolded {
                let at = 2 * self.texel(self.o.x, self.o.y);
                let shares = tissue.map_shares(&r, mu);
                self.deposit(at, self.weight * shares[0]);
                self.deposit(at + 1, self.weight * shares[1]);
            }
        }
        let heavy = self.weight > T::of(2.0 * ENTERED) && r.mixed > T::of(MIRRORED) && r.mixed < one;
        if self.limits.split && self.mirrored.is_none() && heavy {
            return self.split(r.mixed, mu);
        }
        let u = self.draw();
        self.record(EVENT_TISSUE + u32::from(u < r.mixed), (u - r.mixed).abs());
        if u < r.mixed {
            self.touch_reflect();
            return End::GoesOn;
        }
        self.tissue_walk(mu)
    }
}
