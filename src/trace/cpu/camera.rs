//! Twin of `camera.wgsl`: camera paths.
//!
//! Where a map is read a path's light is found, but what the face reflects may still show an LED. A fifth of the paths
//! go on as reflected, with the weight that takes (docs/decisions/camera-paths.md).

use super::fresnel::fresnel;
use super::vec3::v3;
use super::{End, Limits, Path, V3, book, units};
use crate::trace::constants::{EVENT_END, EVENT_TISSUE, Finish, REFLECTED};
use crate::trace::model::{Model, Real, Tissue};
use crate::trace::modes::Fates;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// What camera paths read and leave out.
#[derive(Debug, Clone, Copy)]
pub struct View<'a, T> {
    /// Deposit and area of each texel, for true contact and for the gap: read in place of following the path into
    /// tissue.
    pub exitance: Option<&'a [[T; 4]]>,
    /// Leave out what `splat` finds: paths that reach their first tissue straight.
    pub complement: bool,
}

/// Film units of one unit of radiance: sums are 64-bit fixed point with 48 fractional bits.
pub const FILM_UNIT: f64 = 281_474_976_710_656.0;

/// Adds `samples` paths per pixel, from `first_sample` on, to the fixed-point film; returns what became of them.
pub fn add<T: Real>(
    model: &Model<T>,
    view: View<T>,
    seed: u32,
    [first_sample, samples]: [u32; 2],
    first_pixel: usize,
    limits: Limits,
    film: &mut [u64],
) -> Fates {
    film.par_iter_mut()
        .enumerate()
        .map(|(k, sum)| {
            let mut path = Path::new(model, limits);
            for s in first_sample..first_sample + samples {
                let light = path.camera_path(view, seed, (first_pixel + k) as u32, s);
                *sum = sum.saturating_add((light.wide() * FILM_UNIT) as u64);
            }
            Fates::of(&path.tally)
        })
        .reduce(Fates::default, Fates::and)
}

impl<T: Real> Path<'_, T> {
    /// Radiance (over the square of the surround's index) along one camera path.
    pub fn camera_path(&mut self, view: View<T>, seed: u32, pixel: u32, sample: u32) -> T {
        self.start_random(seed, pixel, sample);
        self.eye = view.exitance.is_some() || !self.kernel.touched;
        self.start_camera_path(pixel);
        let [half_x, half_y] = self.model.half_size;
        if self.o.x.abs() >= half_x || self.o.y.abs() >= half_y {
            return T::zero();
        }
        if !self.enter() {
            return T::zero();
        }
        self.layer = 1;
        let mut light = T::zero();
        let end = loop {
            let mut end = self.walk();
            if end == End::Touch {
                end = self.camera_touch(view, &mut light);
                if end == End::GoesOn {
                    continue;
                }
            }
            break end;
        };
        self.record(EVENT_END + end as u32, T::one());
        match end {
            End::Lost => self.tally[book::LOST] += 1,
            End::Cap => self.tally[book::TERMINATED] += units(self.weight),
            _ => {}
        }
        light + self.weight * self.light_at_end(end)
    }

    /// Through the lowest face; what it mirrors is taken off the weight.
    fn enter(&mut self) -> bool {
        let face = self.model.faces[0];
        if face.finish != Finish::Smooth {
            return self.meet(0, V3::up(), T::one());
        }
        let a = self.p.z;
        let n_sq = self.model.layers[0].n_sq;
        let b_sq = face.dn_sq + a * a;
        if b_sq <= T::zero() {
            return false;
        }
        let b = b_sq.sqrt();
        self.weight = T::one() - fresnel(a, b, n_sq, n_sq + face.dn_sq);
        self.p.z = b;
        true
    }

    fn start_camera_path(&mut self, pixel: u32) {
        let camera = &self.model.camera;
        let [columns, rows] = camera.size;
        let at_x = T::of(f64::from(pixel % columns)) + self.draw();
        let at_y = T::of(f64::from(pixel / columns)) + self.draw();
        let half = T::of(0.5);
        let mut d = v3(
            (at_x - half * T::of(f64::from(columns))) * camera.pixel_tan,
            -(at_y - half * T::of(f64::from(rows))) * camera.pixel_tan,
            T::one(),
        );
        self.o = v3(T::zero(), T::zero(), -camera.distance);
        if self.kernel.lens {
            let r = camera.lens_radius * self.draw().sqrt();
            let phi = T::of(TAU) * self.draw();
            let (x, y) = (r * phi.cos(), r * phi.sin());
            d = v3(d.x * camera.focus - x, d.y * camera.focus - y, camera.focus);
            self.o = v3(x, y, -camera.distance);
        }
        self.p = d.normalize() * self.model.surround_n;
        self.o = self.o + self.p * (camera.distance / self.p.z);
        self.o.z = T::zero();
        self.layer = 0;
        self.weight = T::one();
        self.bounces = 0;
        self.turns = 0;
    }

    fn exitance_at(&self, tissue: &Tissue<T>, texels: &[[T; 4]], [x, y]: [T; 2], mu_o: T) -> T {
        let (zero, one) = (T::zero(), T::one());
        let [columns, rows] = self.model.map_size;
        let axis = |v: T, half: T, n: usize| {
            let g = (v / (T::of(2.0) * half) + T::of(0.5)) * T::of(n as f64) - T::of(0.5);
            let c = g.floor();
            let at = |k: i64| (c.to_i64().unwrap_or(0) + k).clamp(0, n as i64 - 1) as usize;
            (at(0), at(1), g - c)
        };
        let (x0, x1, ux) = axis(x, self.model.half_size[0], columns);
        let (y0, y1, uy) = axis(y, self.model.half_size[1], rows);
        let mut sum = [zero; 4];
        for (row, wy) in [(y0, one - uy), (y1, uy)] {
            for (column, wx) in [(x0, one - ux), (x1, ux)] {
                let texel = texels[row * columns + column];
                for (s, v) in sum.iter_mut().zip(texel) {
                    *s = *s + v * wx * wy;
                }
            }
        }
        let ratio = |deposit: T, area: T| if area > zero { deposit / area } else { zero };
        self.exitance_toward(tissue, x, y, [ratio(sum[0], sum[1]), ratio(sum[2], sum[3])], mu_o)
    }

    fn camera_touch(&mut self, view: View<T>, light: &mut T) -> End {
        let Some(tissue) = self.tissue() else {
            return End::Absorbed;
        };
        let a = self.p.dot(self.normal).abs();
        let mu = tissue.cosine(a);
        let r = self.boundary(self.o.x, self.o.y, a).mixed;
        if let Some(texels) = view.exitance {
            let out = self.exitance_at(tissue, texels, [self.o.x, self.o.y], mu);
            *light = *light + self.weight * (T::one() - r) * out / (T::of(PI) * tissue.n * tissue.n);
        }
        let chance = if view.exitance.is_some() { r.max(T::of(REFLECTED)) } else { r };
        let u = self.draw();
        self.record(EVENT_TISSUE + u32::from(u < chance), (u - chance).abs());
        if u < chance {
            self.weight = self.weight * (r / chance);
            self.touch_reflect();
            return End::GoesOn;
        }
        if view.exitance.is_some() || (view.complement && self.turns == 0) {
            return End::Absorbed;
        }
        self.tissue_walk(mu)
    }
}
