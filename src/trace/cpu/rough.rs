//! Twin of `smooth.wgsl` and `rough.wgsl`: mirror and refracted directions, lobes, microfacets.

use super::vec3::{V3, v3};
use super::{Path, book};
use crate::trace::model::Real;

const SMALL: u32 = 1;
const MICROFACET: u32 = 2;

impl<T: Real> Path<'_, T> {
    pub(super) fn facet(&mut self, normal: V3<T>, side: T, alpha: T, layer: usize) -> V3<T> {
        let (zero, one, half) = (T::zero(), T::one(), T::of(0.5));
        let up = normal * -side;
        let (t1, t2) = tangents(up);
        let w = -self.p * (one / self.model.layers[layer].n);
        let local = v3(w.dot(t1), w.dot(t2), w.dot(up).max(T::of(1e-6)));
        let v = v3(alpha * local.x, alpha * local.y, local.z).normalize();
        let flat_sq = v.x * v.x + v.y * v.y;
        let e1 = if flat_sq > zero { v3(-v.y, v.x, zero) * (one / flat_sq.sqrt()) } else { v3(one, zero, zero) };
        let e2 = v.cross(e1);
        let r = self.draw().sqrt();
        let phi = T::of(std::f64::consts::TAU) * self.draw();
        let x = r * phi.cos();
        let s = half * (one + v.z);
        let y = (one - s) * (one - x * x).max(zero).sqrt() + s * r * phi.sin();
        let n = e1 * x + e2 * y + v * (one - x * x - y * y).max(zero).sqrt();
        let h = v3(alpha * n.x, alpha * n.y, n.z.max(T::of(1e-6))).normalize();
        (t1 * h.x + t2 * h.y + up * h.z) * -side
    }

    fn shadow(&mut self, i: usize, normal: V3<T>, cos_in: T, n_out: T, out_side: T, correlated: bool) {
        let one = T::one();
        let before = self.weight;
        let cos_out = self.p.dot(normal) / n_out;
        let alpha = self.model.faces[i].alpha;
        let l_in = smith_lambda(cos_in * cos_in, alpha);
        let l_out = smith_lambda(cos_out * cos_out, alpha);
        let g = if correlated { (one + l_in) / (one + l_in + l_out) } else { one / (one + l_out) };
        self.weight = if cos_out * out_side > T::zero() { before * g } else { T::zero() };
        self.book(book::ABSORBED, before, self.weight);
    }

    pub(super) fn bounce(&mut self, i: usize, normal: V3<T>, m: V3<T>, side: T, a: T) {
        let face = self.model.faces[i];
        if face.kind == MICROFACET {
            let n = self.model.layers[self.layer].n;
            let cos_in = self.p.dot(normal) / n;
            self.mirror(m);
            self.shadow(i, normal, cos_in, n, -side, true);
            return;
        }
        if !self.kernel.rough && !self.kernel.deformed() {
            self.p.z = -self.p.z;
            return;
        }
        let incoming = self.p;
        let mut f = m;
        if face.kind == SMALL && self.draw() >= (-face.rough * a * a).exp() {
            f = self.facet(normal, side, face.alpha, self.layer);
        }
        self.mirror(f);
        if self.kernel.rough && self.p.dot(normal) * side >= T::zero() {
            self.p = incoming;
            self.mirror(normal);
        }
    }

    pub(super) fn refract_through(&mut self, i: usize, normal: V3<T>, m: V3<T>, side: T, a: T, b: T) {
        let face = self.model.faces[i];
        if !self.kernel.rough && !self.kernel.deformed() {
            self.p.z = side * b;
            return;
        }
        let cos_in = self.p.dot(normal) / self.model.layers[self.layer].n;
        let next = if side > T::zero() { self.layer + 1 } else { self.layer - 1 };
        if face.kind == SMALL && self.draw() >= (-T::of(0.25) * face.rough * (a - b) * (a - b)).exp() {
            let f = self.facet(normal, side, face.alpha, self.layer);
            let along = self.p.dot(f).abs();
            let b_sq = face.dn_sq * side + along * along;
            let q = self.p + f * (side * (b_sq.max(T::zero()).sqrt() - along));
            if b_sq > T::zero() && q.dot(normal) * side > T::zero() {
                self.p = q;
                return;
            }
        }
        self.p = self.p + m * (side * (b - a));
        if face.kind == MICROFACET {
            self.shadow(i, normal, cos_in, self.model.layers[next].n, side, false);
        }
    }
}

/// Two unit vectors that span the plane across `n`.
pub(super) fn tangents<T: Real>(n: V3<T>) -> (V3<T>, V3<T>) {
    let (zero, one) = (T::zero(), T::one());
    let axis = if n.x.abs() > T::of(0.7) { v3(zero, one, zero) } else { v3(one, zero, zero) };
    let t1 = axis.cross(n).normalize();
    (t1, n.cross(t1))
}

fn smith_lambda<T: Real>(cos_sq: T, alpha: T) -> T {
    let one = T::one();
    let tan_sq = (one - cos_sq).max(T::zero()) / cos_sq.max(T::of(1e-12));
    T::of(0.5) * ((one + alpha * alpha * tan_sq).sqrt() - one)
}
