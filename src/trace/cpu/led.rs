//! Twin of `led.wgsl`: LEDs as seen by camera paths, and as sources of photons.

use super::fresnel::reflectance;
use super::{End, Path, V3};
use crate::scene::Wall;
use crate::trace::constants::{EVENT_LED, EVENT_WALL, TABLE_EDGE};
use crate::trace::cpu::vec3::v3;
use crate::trace::launch;
use crate::trace::leds::Led;
use crate::trace::model::Real;
use std::f64::consts::TAU;

/// Outward axis of a wall.
pub(in crate::trace) fn wall_axis<T: Real>(wall: Wall) -> V3<T> {
    let s = if wall.is_low() { -T::one() } else { T::one() };
    if wall.axis() == 0 { v3(s, T::zero(), T::zero()) } else { v3(T::zero(), s, T::zero()) }
}

fn along_of<T: Real>(wall: Wall, v: V3<T>) -> T {
    if wall.axis() == 0 { v.y } else { v.x }
}

impl<T: Real> Path<'_, T> {
    pub(super) fn wall_led(&self) -> Option<usize> {
        self.model.leds.iter().position(|l| {
            let (u, v) = (along_of(self.wall, self.o) - l.along, self.o.z - l.height);
            l.wall == self.wall && !l.air && u * u + v * v <= l.radius * l.radius
        })
    }

    fn table_cell(table: usize, sin_sq: T, phi: T) -> usize {
        let edge = TABLE_EDGE as f64;
        let turn = (phi / T::of(TAU) + T::one()).fract();
        let cell = |v: T| (v * T::of(edge)).to_usize().unwrap_or(0).min(TABLE_EDGE - 1);
        table + cell(sin_sq) * TABLE_EDGE + cell(turn)
    }

    pub(in crate::trace) fn led_radiance_along(&self, led: &Led<T>, c: T, v: V3<T>) -> T {
        if c <= led.cos_cutoff {
            return T::zero();
        }
        if let Some(table) = led.table {
            let phi = (-along_of(led.wall, v)).atan2(-v.z);
            let cell = Self::table_cell(table, T::one() - c * c, phi);
            return led.radiance * self.model.led_tables[cell][0];
        }
        if led.exponent == T::one() {
            return led.radiance;
        }
        led.radiance * c.powf(led.exponent - T::one())
    }

    /// Radiance over n^2 that a camera path finds at its end.
    pub fn light_at_end(&mut self, end: End) -> T {
        let axis = wall_axis(self.wall);
        match end {
            End::Wall => {
                let Some(k) = self.wall_led() else {
                    return T::zero();
                };
                self.record(EVENT_LED + k as u32, T::one());
                let n = self.model.layers[self.layer].n;
                let inv = T::one() / n;
                self.led_radiance_along(&self.model.leds[k], self.p.dot(axis) * inv, self.p * inv) / (n * n)
            }
            End::Sides => {
                let n = self.model.surround_n;
                for (k, led) in self.model.leds.iter().enumerate() {
                    if led.wall != self.wall || !led.air {
                        continue;
                    }
                    let q = self.p.dot(axis);
                    let at = self.o + self.p * (led.gap / q);
                    let (u, v) = (along_of(led.wall, at) - led.along, at.z - led.height);
                    if u * u + v * v <= led.radius * led.radius {
                        self.record(EVENT_LED + k as u32, T::one());
                        let inv = T::one() / n;
                        return self.led_radiance_along(led, q * inv, self.p * inv) / (n * n);
                    }
                }
                T::zero()
            }
            _ => T::zero(),
        }
    }

    /// Squared sine to the disc's normal, and azimuth.
    fn led_direction(&mut self, led: &Led<T>) -> (T, T) {
        let (u, v) = (self.even_draw(launch::POLAR), self.even_draw(launch::AZIMUTH));
        if let Some(table) = led.table {
            let cells = &self.model.led_tables[table..table + TABLE_EDGE * TABLE_EDGE];
            let cell = cells.partition_point(|c| c[1] <= u).min(cells.len() - 1);
            let edge = T::of(TABLE_EDGE as f64);
            let sin_sq = (T::of((cell / TABLE_EDGE) as f64) + v) / edge;
            let turn = (T::of((cell % TABLE_EDGE) as f64) + self.draw()) / edge;
            return (sin_sq, T::of(TAU) * turn);
        }
        let x = T::one() - u * led.launch;
        let m = led.exponent;
        let cos_sq = if m == T::one() { x } else { x.powf(T::of(2.0) / (m + T::one())) };
        (T::one() - cos_sq, T::of(TAU) * v)
    }

    /// Starts a photon at an LED.
    pub fn launch(&mut self) -> End {
        let (zero, one) = (T::zero(), T::one());
        let pick = self.even_draw(launch::LED);
        let leds = &self.model.leds;
        let share = |l: &Led<T>| if self.aimed { l.cumulative_aimed } else { l.cumulative };
        let k = leds.iter().position(|l| pick < share(l)).unwrap_or(leds.len() - 1);
        let led = &leds[k];
        let r = led.radius * self.even_draw(launch::RADIUS).sqrt();
        let turn = T::of(TAU) * self.even_draw(launch::TURN);
        let along = led.along + r * turn.cos();
        let z = led.height + r * turn.sin();
        let (sin_sq, azimuth) = self.led_direction(led);
        let out: V3<T> = wall_axis(led.wall);
        let x_wall = led.wall.axis() == 0;
        let tangent = if x_wall { v3(zero, one, zero) } else { v3(one, zero, zero) };
        let s = sin_sq.sqrt();
        let (mut aside, up) = (s * azimuth.sin(), s * azimuth.cos());
        let mut inward_sq = one - sin_sq;
        if self.aimed {
            let level_sq = (one - up * up).max(zero);
            let level = level_sq.sqrt();
            let [low, high] = led.aim;
            aside = low * level + T::of(0.5) * (high - low) * (aside + level);
            inward_sq = level_sq - aside * aside;
        }
        let d = tangent * aside + V3::up() * up - out * inward_sq.max(zero).sqrt();
        self.weight = one;
        self.bounces = 0;
        self.wall = led.wall;
        self.turns = 0;
        let [half_x, half_y] = self.model.half_size;
        let (face, width) = if x_wall { (half_x, half_y) } else { (half_y, half_x) };
        self.o = out * face + tangent * along + V3::up() * z;
        self.record(EVENT_LED + k as u32, one);
        if led.air {
            self.p = d * self.model.surround_n;
            self.o = self.o - d * (led.gap / d.dot(out));
            if x_wall {
                self.o.x = face * out.x;
            } else {
                self.o.y = face * out.y;
            }
            let top = self.model.faces[self.top()].z;
            if along_of(led.wall, self.o).abs() >= width || self.o.z <= zero || self.o.z >= top {
                return End::Sides;
            }
        }
        self.layer = self.layer_at(self.o);
        let layer = self.model.layers[self.layer];
        if !led.air {
            self.p = d * layer.n;
            return End::GoesOn;
        }
        let a = -self.p.dot(out);
        let dn_sq = -layer.side_dn_sq;
        let b_sq = dn_sq + a * a;
        let f = reflectance(a, dn_sq, self.model.surround_n * self.model.surround_n);
        let u = self.even_draw(launch::SIDE);
        self.record(EVENT_WALL + led.wall as u32 * 2 + u32::from(u >= f), (u - f).abs());
        if u < f {
            return End::Sides;
        }
        self.p = self.p - out * (b_sq.sqrt() - a);
        End::GoesOn
    }

    fn layer_at(&mut self, o: V3<T>) -> usize {
        let mut k = 1;
        for i in 1..self.top() {
            let face = self.model.faces[i];
            let z = if face.share != T::zero() { self.surface_height(i, o.x, o.y) } else { face.z };
            k += usize::from(o.z > z);
        }
        k
    }
}
