//! Twin of `touch.wgsl`: true contact, air gap and tissue.

use super::fresnel::{fresnel, reflectance};
use super::rough::tangents;
use super::{End, Path, STRAY, V3};
use crate::trace::constants::{EVENT_CONTACT, EVENT_REENTRY};
use crate::trace::model::{Real, Tissue};

/// Reflectance of the boundary: of the whole, of true contact, of the gap.
#[derive(Debug, Clone, Copy)]
pub struct Boundary<T> {
    /// Both in their shares.
    pub mixed: T,
    /// True contact.
    pub contact: T,
    /// Air gap.
    pub gap: T,
}

impl<'m, T: Real> Path<'m, T> {
    pub(super) fn tissue(&self) -> Option<&'m Tissue<T>> {
        self.model.tissue.as_ref()
    }

    /// Whether there is tissue above a point.
    pub fn tissue_here(&self, x: T, y: T) -> bool {
        self.tissue().is_some_and(|t| t.disc.is_none_or(|disc| disc.holds(x, y)))
    }

    /// Share of true contact at a point.
    pub fn contact_share(&self, x: T, y: T) -> T {
        let Some(t) = self.tissue() else {
            return T::zero();
        };
        if t.grid.is_empty() {
            return t.share;
        }
        let [columns, rows] = t.grid_size;
        let axis = |v: T, half: T, n: usize| {
            let g = (v / (T::of(2.0) * half) + T::of(0.5)) * T::of(n as f64) - T::of(0.5);
            let c = g.floor().max(T::zero()).min(T::of(n as f64 - 2.0));
            (c.to_usize().unwrap_or(0), (g - c).max(T::zero()).min(T::one()))
        };
        let (cx, ux) = axis(x, self.model.half_size[0], columns);
        let (cy, uy) = axis(y, self.model.half_size[1], rows);
        let at = cy * columns + cx;
        let mix = |a: T, b: T, u: T| a * (T::one() - u) + b * u;
        mix(mix(t.grid[at], t.grid[at + 1], ux), mix(t.grid[at + columns], t.grid[at + columns + 1], ux), uy)
    }

    /// Reflectance at a point of the touched face, from the guide; a = n_top cos.
    pub fn boundary(&self, x: T, y: T, a: T) -> Boundary<T> {
        let (zero, one) = (T::zero(), T::one());
        let Some(t) = self.tissue() else {
            return Boundary { mixed: one, contact: one, gap: one };
        };
        let n_sq = self.model.layers[self.top()].n_sq;
        let contact = reflectance(a, t.dn_sq, n_sq);
        let g_sq = t.gap_dn_sq + a * a;
        let b_sq = t.dn_sq + a * a;
        let gap = if g_sq <= zero || b_sq <= zero {
            one
        } else {
            let g = g_sq.sqrt();
            let gap_n_sq = n_sq + t.gap_dn_sq;
            let f1 = fresnel(a, g, n_sq, gap_n_sq);
            let f2 = fresnel(g, b_sq.sqrt(), gap_n_sq, n_sq + t.dn_sq);
            f1 + (one - f1) * (one - f1) * f2 / (one - f1 * f2)
        };
        let share = self.contact_share(x, y);
        Boundary { mixed: gap * (one - share) + contact * share, contact, gap }
    }

    /// Lateral step of the Christensen-Burley profile.
    pub(super) fn displace(&mut self, x: T, y: T) -> (T, T) {
        let which = self.draw();
        let d = self.tissue().map_or(T::zero(), |t| t.spread_d);
        let scale = T::of(if which < T::of(0.25) { 1.0 } else { 3.0 });
        let r = -(T::one() - self.draw()).ln() * scale * d;
        let phi = T::of(std::f64::consts::TAU) * self.draw();
        (x + r * phi.cos(), y + r * phi.sin())
    }

    pub(super) fn inside(&self, x: T, y: T) -> bool {
        x.abs() < self.model.half_size[0] && y.abs() < self.model.half_size[1] && self.tissue_here(x, y)
    }

    /// From entering the tissue at the cosine `cos_in` to leaving it into the guide, or to the path's end.
    pub fn tissue_walk(&mut self, cos_in: T) -> End {
        let Some(t) = self.tissue() else {
            return End::Absorbed;
        };
        let (zero, one) = (T::zero(), T::one());
        let top = self.top();
        let mut mu = cos_in;
        for _ in 0..4096 {
            let lives = self.draw();
            let share = t.returned(mu);
            self.record(EVENT_CONTACT + u32::from(lives < share), (lives - share).abs());
            if lives >= share {
                return End::Absorbed;
            }
            if self.kernel.spreading {
                let (x, y) = self.displace(self.o.x, self.o.y);
                if !self.inside(x, y) {
                    return End::Top;
                }
                let z = self.surface_height(top, x, y);
                self.o = V3 { x, y, z };
                self.leave_trail();
                self.normal = V3::up();
                if self.kernel.deformed() && self.model.faces[top].share != zero {
                    self.normal = self.surface_normal(top, self.o, zero);
                }
            }
            let sin_sq = self.draw();
            let phi = T::of(std::f64::consts::TAU) * self.draw();
            let mu_out = (one - sin_sq).sqrt();
            self.weigh(t, mu, mu_out);
            let b = t.n * mu_out;
            let a_sq = b * b - t.dn_sq;
            let a = a_sq.max(zero).sqrt();
            let r = if a_sq <= zero { one } else { self.boundary(self.o.x, self.o.y, a).mixed };
            let u = self.draw();
            self.record(EVENT_REENTRY + u32::from(u < r), (u - r).abs());
            if u < r {
                mu = mu_out;
                self.tissue_reentry(mu);
                continue;
            }
            let s = t.n * sin_sq.sqrt();
            let (t1, t2) = tangents(self.normal);
            self.p = (t1 * phi.cos() + t2 * phi.sin()) * s - self.normal * a;
            self.layer = top;
            self.turns |= STRAY;
            return End::GoesOn;
        }
        End::Cap
    }

    pub(super) fn touch_reflect(&mut self) {
        self.mirror(self.normal);
        self.turns += 1;
    }
}
