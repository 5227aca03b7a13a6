// Unpolarised Fresnel reflectance in terms of optical momenta along the normal.
// a = n_i cos(theta_i), b = n_t cos(theta_t) with b^2 = n_t^2 - n_i^2 + a^2. Source: Born and Wolf, 1.5.2.

fn fresnel(a: f32, b: f32, n_i_sq: f32, n_t_sq: f32) -> f32 {
    let s = (a - b) / (a + b);
    let x = n_t_sq * a;
    let y = n_i_sq * b;
    let p = (x - y) / (x + y);
    return 0.5 * (s * s + p * p);
}

// Total reflection included: dn_sq = n_t^2 - n_i^2.
fn reflectance(a: f32, dn_sq: f32, n_i_sq: f32) -> f32 {
    let b_sq = dn_sq + a * a;
    let r = fresnel(a, sqrt(max(b_sq, 0.0)), n_i_sq, n_i_sq + dn_sq);
    return select(r, 1.0, b_sq <= 0.0);
}
