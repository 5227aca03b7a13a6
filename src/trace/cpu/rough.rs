//! Twin of `smooth.wgsl` and `rough.wgsl`: mirror and refracted directions, lobes, microfacets.

use super::fresnel::reflectance;
use super::vec3::{V3, v3};
use super::{Path, book};
use crate::trace::constants::Finish;
use crate::trace::model::Real;

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

    fn lobe(&mut self, q_in: T, q_out: T) {
        let before = self.weight;
        self.weight = before * (q_out / q_in).min(T::one());
        self.book(book::ABSORBED, before, self.weight);
    }

    pub(super) fn bounce(&mut self, i: usize, normal: V3<T>, m: V3<T>, side: T, a: T) {
        if !self.kernel.rough && !self.kernel.deformed() {
            self.p.z = -self.p.z;
            return;
        }
        let face = self.model.faces[i];
        let layer = self.model.layers[self.layer];
        let cos_in = self.p.dot(normal) / layer.n;
        if face.finish == Finish::Microfacet {
            self.mirror(m);
            self.shadow(i, normal, cos_in, layer.n, -side, true);
            return;
        }
        let share = scattered(face.rough, a);
        if face.finish != Finish::Small || self.draw() >= share {
            self.mirror(m);
            return;
        }
        let dn_sq = face.dn_sq * side;
        let f = self.facet(normal, side, face.alpha, self.layer);
        self.mirror(f);
        self.shadow(i, normal, cos_in, layer.n, -side, true);
        let a_out = self.p.dot(normal).abs();
        let q_out = reflectance(a_out, dn_sq, layer.n_sq) * scattered(face.rough, a_out);
        self.lobe(reflectance(a, dn_sq, layer.n_sq) * share, q_out);
    }

    pub(super) fn refract_through(&mut self, i: usize, normal: V3<T>, m: V3<T>, side: T, a: T, b: T) {
        if !self.kernel.rough && !self.kernel.deformed() {
            self.p.z = side * b;
            return;
        }
        let (zero, one) = (T::zero(), T::one());
        let face = self.model.faces[i];
        let layer = self.model.layers[self.layer];
        let next = if side > zero { self.layer + 1 } else { self.layer - 1 };
        let n_next = self.model.layers[next].n;
        let cos_in = self.p.dot(normal) / layer.n;
        let rough = T::of(0.25) * face.rough;
        let share = scattered(rough, a - b);
        if face.finish != Finish::Small || self.draw() >= share {
            self.p = self.p + m * (side * (b - a));
            if face.finish == Finish::Microfacet {
                self.shadow(i, normal, cos_in, n_next, side, false);
            }
            return;
        }
        let dn_sq = face.dn_sq * side;
        let f = self.facet(normal, side, face.alpha, self.layer);
        let along = self.p.dot(f).abs();
        let b_sq = dn_sq + along * along;
        self.p = self.p + f * (side * (b_sq.max(zero).sqrt() - along));
        self.shadow(i, normal, cos_in, n_next, if b_sq <= zero { zero } else { side }, false);
        let a_out = self.p.dot(normal).abs();
        let b_out = (a_out * a_out - dn_sq).max(zero).sqrt();
        let q_out = (one - reflectance(a_out, -dn_sq, layer.n_sq + dn_sq)) * scattered(rough, a_out - b_out);
        self.lobe((one - reflectance(a, dn_sq, layer.n_sq)) * share, q_out);
    }
}

/// Share of the light that leaves the mirror (or refracted) direction; a is n cos, or the step of n cos.
fn scattered<T: Real>(rough: T, a: T) -> T {
    T::one() - (-rough * a * a).exp()
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
