//! Twin of `walk.wgsl`: from event to event through the stack.
//!
//! Nothing shines below or above the stack. So camera paths that end at tissue, or meet none, never leave it by chance:
//! they carry what the outer faces mirror as a weight and stop by roulette below 0.01 (0.003 before tissue). A path
//! that leaves a dent may come back in, unless it rises faster than the face does where it is steepest; where it may,
//! half of the paths leave, with the weight that this takes. Paths that go on into tissue draw at every face
//! (docs/decisions/camera-paths.md; docs/decisions/walk.md has what was tried and dropped).

use super::fresnel::fresnel;
use super::surface::far;
use super::vec3::V3;
use super::{End, Path, book};
use crate::scene::Wall;
use crate::trace::constants::{
    EVENT_WALL, Finish, KEEP_AT_LEAST, LEAST_EYE, LEAST_EYE_TOUCHED, LEAST_PHOTON, MOST_KEPT, STRAY,
};
use crate::trace::model::{Real, Walls};

fn safe_divide<T: Real>(a: T, b: T) -> T {
    if b == T::zero() { far() } else { a / b }
}

impl<T: Real> Path<'_, T> {
    fn cross_face(&mut self, i: usize, side: T, t_max: T) -> T {
        if self.model.faces[i].share != T::zero() {
            return self.surface_cross(i, self.o, self.p, side, t_max);
        }
        self.cross_plane(i, side)
    }

    fn cross_plane(&self, i: usize, side: T) -> T {
        if self.p.z * side > T::zero() { ((self.model.faces[i].z - self.o.z) / self.p.z).max(T::zero()) } else { far() }
    }

    /// First crossing of the layer's two faces, and whether it is the upper one.
    fn cross_layer(&mut self, t_wall: T) -> (T, bool) {
        let (top, one) = (self.top(), T::one());
        let (above, below) = (self.layer, self.layer - 1);
        let curved = |i: usize| i <= top && self.model.faces[i].share != T::zero();
        if !curved(above) && curved(below) {
            let t_up = if above <= top { self.cross_plane(above, one) } else { far() };
            let t_down = self.cross_face(below, -one, t_wall.min(t_up));
            return (t_up.min(t_down), t_up < t_down);
        }
        if curved(above) && !curved(below) {
            let t_down = self.cross_plane(below, -one);
            let t_up = self.cross_face(above, one, t_wall.min(t_down));
            return (t_up.min(t_down), t_up < t_down);
        }
        let t_up = if above <= top { self.cross_face(above, one, t_wall) } else { far() };
        let t_down = self.cross_face(below, -one, t_wall.min(t_up));
        (t_up.min(t_down), t_up < t_down)
    }

    /// Reflection or refraction at interface `i`; true when transmitted.
    pub fn meet(&mut self, i: usize, normal: V3<T>, side: T) -> bool {
        let n_sq = self.model.layers[self.layer].n_sq;
        let face = self.model.faces[i];
        let dn_sq = face.dn_sq * side;
        let m =
            if face.finish == Finish::Microfacet { self.facet(normal, side, face.alpha, self.layer) } else { normal };
        let a = self.p.dot(m).abs();
        let b_sq = dn_sq + a * a;
        let code = i as u32 * 4;
        if b_sq <= T::zero() {
            self.record(code, -b_sq);
            self.turn(i);
            self.bounce(i, normal, m, side, a);
            return false;
        }
        let b = b_sq.sqrt();
        let r = fresnel(a, b, n_sq, n_sq + dn_sq);
        let u = self.draw();
        // Nothing shines below or above the stack: a path from the camera goes on with what the outer faces mirror.
        // Only where it may come back, half of the paths leave.
        let upper = i == self.top() && side > T::zero();
        let outer = upper || i == 0 && side < T::zero();
        let one = T::one();
        let chance = match self.eye && outer && face.finish == Finish::Smooth {
            true if upper && !self.leaves_for_good(self.p + m * (b - a)) => r.max(T::of(0.5)),
            true => one,
            false => r,
        };
        if u < chance {
            self.weight = self.weight * (r / chance);
            self.record(code + 1, chance - u);
            self.turn(i);
            self.bounce(i, normal, m, side, a);
            return false;
        }
        self.weight = self.weight * ((one - r) / (one - chance));
        self.record(code + 2, u - chance);
        self.refract_through(i, normal, m, side, a, b);
        true
    }

    fn turn(&mut self, i: usize) {
        self.turns = if i == 0 || i == self.top() { self.turns + 1 } else { self.turns | STRAY };
    }

    /// Whether a path above the touched face rises faster than that face does anywhere.
    fn leaves_for_good(&self, p: V3<T>) -> bool {
        let slope = self.model.faces[self.top()].slope;
        p.z > T::zero() && p.z * p.z >= slope * slope * (p.x * p.x + p.y * p.y)
    }

    pub(super) fn mirror(&mut self, m: V3<T>) {
        self.p = self.p - m * (T::of(2.0) * self.p.dot(m));
    }

    fn roulette(&mut self) -> End {
        self.bounces += 1;
        if self.bounces >= self.limits.event_cap {
            return End::Cap;
        }
        let least = T::of(match (self.eye, self.kernel.touched) {
            (false, _) => LEAST_PHOTON,
            (true, false) => LEAST_EYE,
            (true, true) => LEAST_EYE_TOUCHED,
        });
        if self.weight < least || self.bounces > self.limits.roulette_start {
            let keep = (T::of(KEEP_AT_LEAST) * self.weight / least).min(T::of(MOST_KEPT));
            if self.draw() >= keep {
                return End::Roulette;
            }
            let before = self.weight;
            self.weight = before / keep;
            self.book(book::ROULETTE, before, self.weight);
        }
        End::GoesOn
    }

    /// No tissue here, and none ahead, seen from above.
    pub(in crate::trace) fn astray(&self) -> bool {
        let Some(disc) = self.model.tissue.as_ref().and_then(|tissue| tissue.disc) else {
            return false;
        };
        let (x, y) = (self.o.x - disc.center[0], self.o.y - disc.center[1]);
        let along = x * self.p.x + y * self.p.y;
        let beyond = x * x + y * y - disc.radius_sq;
        let far = along * along < beyond * (self.p.x * self.p.x + self.p.y * self.p.y);
        beyond > T::zero() && (along >= T::zero() || far)
    }

    fn absorb(&mut self, length: T) {
        let before = self.weight;
        self.weight = before * (-self.model.layers[self.layer].absorption * length).exp();
        self.book(book::ABSORBED, before, self.weight);
    }

    fn meet_wall(&mut self) -> End {
        let code = EVENT_WALL + self.wall as u32 * 2;
        let along_x = self.wall.axis() == 0;
        match self.model.walls {
            Walls::Clear => {
                let layer = self.model.layers[self.layer];
                let q = if along_x { self.p.x } else { self.p.y };
                let a = q.abs();
                let b_sq = layer.side_dn_sq + a * a;
                let (mut r, mut u) = (T::one(), T::zero());
                let mut margin = b_sq.abs();
                if b_sq > T::zero() {
                    r = fresnel(a, b_sq.sqrt(), layer.n_sq, layer.n_sq + layer.side_dn_sq);
                    u = self.draw();
                    margin = (u - r).abs();
                }
                let leaves = u >= r;
                self.record(code + u32::from(leaves), margin);
                let out = if leaves { q.signum() * b_sq.max(T::zero()).sqrt() } else { -q };
                if along_x {
                    self.p.x = out;
                } else {
                    self.p.y = out;
                }
                if leaves {
                    return End::Sides;
                }
            }
            Walls::Mirror => {
                if self.wall_led().is_some() {
                    return End::Wall;
                }
                if self.draw() >= self.model.wall_reflectance {
                    return End::Absorbed;
                }
                self.record(code, T::one());
                if along_x {
                    self.p.x = -self.p.x;
                } else {
                    self.p.y = -self.p.y;
                }
            }
            Walls::Black => {
                self.record(code, T::one());
                return End::Wall;
            }
        }
        self.turns |= STRAY;
        End::GoesOn
    }

    /// Walks to the next wall, exit or tissue.
    pub fn walk(&mut self) -> End {
        loop {
            match self.step() {
                End::GoesOn => {}
                end => return end,
            }
        }
    }

    /// One turn of the walk: a segment and what waits at its end.
    pub fn step(&mut self) -> End {
        let top = self.top();
        let (zero, one) = (T::zero(), T::one());
        let deformed = self.kernel.deformed();
        let ended = self.roulette();
        if ended != End::GoesOn {
            return ended;
        }
        if self.aimed && self.astray() {
            return End::Astray;
        }
        self.tally[book::SEGMENTS] += 1;
        let (o, p) = (self.o, self.p);
        let rim = |q: T, half: T| if q > zero { half } else { -half };
        let rim_x = rim(p.x, self.model.half_size[0]);
        let rim_y = rim(p.y, self.model.half_size[1]);
        let tx = safe_divide(rim_x - o.x, p.x);
        let ty = safe_divide(rim_y - o.y, p.y);
        let t_wall = tx.min(ty).max(zero);
        let (t_face, up);
        if deformed {
            (t_face, up) = self.cross_layer(t_wall);
            if std::mem::take(&mut self.lost) {
                return End::Lost;
            }
        } else {
            up = p.z > zero;
            let i = if up { self.layer } else { self.layer - 1 };
            t_face = safe_divide(self.model.faces[i].z - o.z, p.z).max(zero);
        }
        let (i, side) = if up { (self.layer, one) } else { (self.layer - 1, -one) };
        let t = t_face.min(t_wall);
        self.o = o + p * t;
        if self.kernel.absorbing {
            self.absorb(t * self.model.layers[self.layer].n);
        }
        if t_wall < t_face {
            let at_x = tx < ty;
            if at_x {
                self.o.x = rim_x;
            } else {
                self.o.y = rim_y;
            }
            self.wall = match at_x {
                true => Wall::across(0, p.x <= zero),
                false => Wall::across(1, p.y <= zero),
            };
            self.leave_trail();
            if deformed && self.layer > top {
                return if p.z > zero { End::Top } else { End::Sides };
            }
            return self.meet_wall();
        }
        if t >= far() {
            return if deformed && self.layer > top { End::Top } else { End::Lost };
        }
        let mut normal = V3::up();
        if deformed && self.model.faces[i].share != zero {
            normal = self.surface_normal(i, self.o, side);
        } else {
            self.o.z = self.model.faces[i].z;
        }
        self.leave_trail();
        if self.kernel.touched && i == top && up && self.tissue_here(self.o.x, self.o.y) {
            self.normal = normal;
            return End::Touch;
        }
        if self.meet(i, normal, side) {
            self.layer = if up { self.layer + 1 } else { self.layer - 1 };
            if self.layer == 0 {
                return End::Bottom;
            }
            if self.layer > top && self.leaves_for_good(self.p) {
                return End::Top;
            }
        } else if self.weight == zero {
            return End::Absorbed;
        }
        End::GoesOn
    }
}
