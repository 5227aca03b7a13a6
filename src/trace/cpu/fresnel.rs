//! Twin of `fresnel.wgsl`: unpolarised reflectance from optical momenta along the normal.

use crate::trace::model::Real;

/// a = n_i cos(theta_i), b = n_t cos(theta_t).
pub fn fresnel<T: Real>(a: T, b: T, n_i_sq: T, n_t_sq: T) -> T {
    let s = (a - b) / (a + b);
    let x = n_t_sq * a;
    let y = n_i_sq * b;
    let p = (x - y) / (x + y);
    T::of(0.5) * (s * s + p * p)
}

/// Total reflection included; dn_sq = n_t^2 - n_i^2.
pub fn reflectance<T: Real>(a: T, dn_sq: T, n_i_sq: T) -> T {
    let b_sq = dn_sq + a * a;
    if b_sq <= T::zero() {
        return T::one();
    }
    fresnel(a, b_sq.sqrt(), n_i_sq, n_i_sq + dn_sq)
}
