// Rough interfaces. Small roughness: a share 1 - exp(-g) of the light leaves the mirror (or refracted) direction for a
// lobe; g = (2 k n sigma cos)^2 in reflection and (k sigma (n_i cos_i - n_t cos_t))^2 in transmission (Rayleigh,
// Beckmann and Spizzichino). The lobe is that of GGX facets, made reciprocal; what it does not return is booked as
// absorbed. Microfacets: GGX with visible normals (Walter et al. 2007; Heitz 2018); the energy that single scattering
// loses to shadowing is booked as absorbed.

// A facet normal, on the upward side of `normal`, seen by the path; sampled by Heitz 2018.
fn facet(normal: vec3f, side: f32, alpha: f32, layer: u32) -> vec3f {
    let up = normal * -side;   // towards the incoming ray
    let axis = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(up.x) > 0.7);
    let t1 = normalize(cross(axis, up));
    let t2 = cross(up, t1);
    let w = -path.p / layer_n(layer);
    let local = vec3f(dot(w, t1), dot(w, t2), max(dot(w, up), 1e-6));
    let v = normalize(vec3f(alpha * local.xy, local.z));
    let flat_sq = dot(v.xy, v.xy);
    let e1 = select(vec3f(1.0, 0.0, 0.0), vec3f(-v.y, v.x, 0.0) / sqrt(flat_sq), flat_sq > 0.0);
    let e2 = cross(v, e1);
    let r = sqrt(draw());
    let phi = TAU * draw();
    let x = r * cos(phi);
    let s = 0.5 * (1.0 + v.z);
    let y = (1.0 - s) * sqrt(max(1.0 - x * x, 0.0)) + s * r * sin(phi);
    let n = x * e1 + y * e2 + sqrt(max(1.0 - x * x - y * y, 0.0)) * v;
    let h = normalize(vec3f(alpha * n.xy, max(n.z, 1e-6)));
    return (h.x * t1 + h.y * t2 + h.z * up) * -side;
}

// Smith's Lambda for GGX; cos_sq is the squared cosine to the mean normal.
fn smith_lambda(cos_sq: f32, alpha: f32) -> f32 {
    let tan_sq = max(1.0 - cos_sq, 0.0) / max(cos_sq, 1e-12);
    return 0.5 * (sqrt(1.0 + alpha * alpha * tan_sq) - 1.0);
}

// Weight G2/G1 of a microfacet event, and the loss where the new direction ends on the wrong side.
fn shadow(i: u32, normal: vec3f, cos_in: f32, n_out: f32, out_side: f32, correlated: bool) {
    let before = path.weight;
    let cos_out = dot(path.p, normal) / n_out;
    let alpha = face_alpha(i);
    let l_in = smith_lambda(cos_in * cos_in, alpha);
    let l_out = smith_lambda(cos_out * cos_out, alpha);
    // Reflection: height-correlated Smith; transmission: separable.
    let g = select(1.0 / (1.0 + l_out), (1.0 + l_in) / (1.0 + l_in + l_out), correlated);
    path.weight = select(0.0, before * g, cos_out * out_side > 0.0);
    book(BOOK_ABSORBED, units(before) - units(path.weight));
}

// Weight of a lobe of small roughness between a path's two sides, each with the flux that the mean plane sends into the
// lobe (its reflectance or transmittance times 1 - exp(-g)): the smaller of both, so that the lobe is the same in both
// directions and never gains.
fn lobe(q_in: f32, q_out: f32) {
    let before = path.weight;
    path.weight = before * min(1.0, q_out / q_in);
    book(BOOK_ABSORBED, units(before) - units(path.weight));
}

fn scattered(rough: f32, a: f32) -> f32 { return 1.0 - exp(-rough * a * a); }

fn bounce(i: u32, normal: vec3f, m: vec3f, side: f32, a: f32) {
    let n = layer_n(path.layer);
    let cos_in = dot(path.p, normal) / n;
    if (face_kind(i) == ROUGH_MICROFACET) {
        mirror(m);
        shadow(i, normal, cos_in, n, -side, true);
        return;
    }
    let share = scattered(face_rough(i), a);
    if (face_kind(i) != ROUGH_SMALL || draw() >= share) {
        mirror(m);
        return;
    }
    let n_sq = layer_n_sq(path.layer);
    let dn_sq = face_dn_sq(i) * side;
    mirror(facet(normal, side, face_alpha(i), path.layer));
    shadow(i, normal, cos_in, n, -side, true);
    let a_out = abs(dot(path.p, normal));
    lobe(reflectance(a, dn_sq, n_sq) * share, reflectance(a_out, dn_sq, n_sq) * scattered(face_rough(i), a_out));
}

fn refract_through(i: u32, normal: vec3f, m: vec3f, side: f32, a: f32, b: f32) {
    let next = u32(i32(path.layer) + i32(side));
    let cos_in = dot(path.p, normal) / layer_n(path.layer);
    let rough = 0.25 * face_rough(i);
    let share = scattered(rough, a - b);
    if (face_kind(i) != ROUGH_SMALL || draw() >= share) {
        path.p += side * (b - a) * m;
        if (face_kind(i) == ROUGH_MICROFACET) { shadow(i, normal, cos_in, layer_n(next), side, false); }
        return;
    }
    let n_sq = layer_n_sq(path.layer);
    let dn_sq = face_dn_sq(i) * side;
    let f = facet(normal, side, face_alpha(i), path.layer);
    let along = abs(dot(path.p, f));
    let b_sq = dn_sq + along * along;
    path.p += side * (sqrt(max(b_sq, 0.0)) - along) * f;
    shadow(i, normal, cos_in, layer_n(next), select(side, 0.0, b_sq <= 0.0), false);
    let a_out = abs(dot(path.p, normal));
    let b_out = sqrt(max(a_out * a_out - dn_sq, 0.0));
    let q_out = (1.0 - reflectance(a_out, -dn_sq, n_sq + dn_sq)) * scattered(rough, a_out - b_out);
    lobe((1.0 - reflectance(a, dn_sq, n_sq)) * share, q_out);
}
