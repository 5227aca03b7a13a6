// Optical contact with tissue. A share of the touched face is in true contact: Fresnel between guide and tissue. The
// rest is an air gap, thin against the beam and thick against the coherence length: an incoherent slab between guide
// and tissue. Tissue (`tissue_lambertian` or `tissue_half_space`) returns a share of what enters just above the
// interface, displaced sideways where SPREADING; what the boundary reflects back into the tissue is scattered again.
// The walk is the same in both directions, for photons and for camera paths.

@group(0) @binding(10) var<storage, read> share_grid: array<f32>;

override SHARE_GRID: bool = false;
override TISSUE_DISC: bool = true;  // else tissue lies over the whole face

fn tissue_here(xy: vec2f) -> bool {
    if (!TISSUE_DISC) { return true; }
    let d = xy - scene.tissue_center;
    return dot(d, d) <= scene.tissue_radius_sq;
}

// Share of true contact.
fn contact_share(xy: vec2f) -> f32 {
    if (!SHARE_GRID) { return scene.share; }
    let size = scene.share_size;
    let g = (xy / (2.0 * scene.half_size) + 0.5) * vec2f(size) - 0.5;
    let c = clamp(floor(g), vec2f(0.0), vec2f(size) - 2.0);
    let u = clamp(g - c, vec2f(0.0), vec2f(1.0));
    let at = u32(c.y) * size.x + u32(c.x);
    let low = mix(share_grid[at], share_grid[at + 1u], u.x);
    let high = mix(share_grid[at + size.x], share_grid[at + size.x + 1u], u.x);
    return mix(low, high, u.y);
}

// Reflectance of true contact (x) and of the gap (y), from the guide; a = n_top cos.
fn touch_reflectance(a: f32) -> vec2f {
    let n_sq = layer_n_sq(scene.layer_count);
    let contact = reflectance(a, scene.tissue_dn_sq, n_sq);
    let g_sq = scene.gap_dn_sq + a * a;
    let b_sq = scene.tissue_dn_sq + a * a;
    if (g_sq <= 0.0 || b_sq <= 0.0) { return vec2f(contact, 1.0); }
    let g = sqrt(g_sq);
    let gap_n_sq = n_sq + scene.gap_dn_sq;
    let f1 = fresnel(a, g, n_sq, gap_n_sq);
    let f2 = fresnel(g, sqrt(b_sq), gap_n_sq, n_sq + scene.tissue_dn_sq);
    return vec2f(contact, f1 + (1.0 - f1) * (1.0 - f1) * f2 / (1.0 - f1 * f2));
}

// Reflectance of the whole boundary at a point: x from true contact and gap in their shares, y and z the two parts.
fn boundary(xy: vec2f, a: f32) -> vec3f {
    let r = touch_reflectance(a);
    return vec3f(mix(r.y, r.x, contact_share(xy)), r);
}

// Lateral step of the Christensen-Burley profile: r has density (exp(-r/d) + exp(-r/3d)) / 4d.
fn displace(xy: vec2f) -> vec2f {
    let which = draw();
    let r = -log(1.0 - draw()) * select(3.0, 1.0, which < 0.25) * scene.spread_d;
    let phi = TAU * draw();
    return xy + r * vec2f(cos(phi), sin(phi));
}

fn inside(xy: vec2f) -> bool { return all(abs(xy) < scene.half_size) && tissue_here(xy); }

// Cosine in the tissue of light that has a = n_top cos in the guide.
fn tissue_cosine(a: f32) -> f32 { return sqrt(max(scene.tissue_dn_sq + a * a, 0.0)) / scene.tissue_n; }

// From entering the tissue at the cosine `cos_in` to leaving it into the guide (GOES_ON), or to the path's end.
fn tissue_walk(cos_in: f32) -> u32 {
    var mu = cos_in;
    let top = scene.layer_count;
    let n_t = scene.tissue_n;
    for (var k = 0u; k < 4096u; k += 1u) {
        let lives = draw();
        let share = returned(mu);
        record(EVENT_CONTACT + select(0u, 1u, lives < share), abs(lives - share));
        if (lives >= share) { return END_ABSORBED; }
        if (SPREADING) {
            let xy = displace(path.o.xy);
            if (!inside(xy)) { return END_TOP; }
            path.o = vec3f(xy, surface_height(top, xy));
            path.normal = vec3f(0.0, 0.0, 1.0);
            if (DEFORMED && face_share(top) != 0.0) { path.normal = surface_normal(top, path.o, 0.0); }
        }
        let sin_sq = draw();
        let phi = TAU * draw();
        let mu_out = sqrt(1.0 - sin_sq);
        weigh(mu, mu_out);
        let b = n_t * mu_out;                             // n_t cos in the tissue
        let a_sq = b * b - scene.tissue_dn_sq;            // (n_top cos)^2 in the guide
        let a = sqrt(max(a_sq, 0.0));
        let r = select(boundary(path.o.xy, a).x, 1.0, a_sq <= 0.0);
        let u = draw();
        record(EVENT_REENTRY + select(0u, 1u, u < r), abs(u - r));
        if (u < r) {
            mu = mu_out;
            tissue_reentry(mu);
            continue;
        }
        let s = n_t * sqrt(sin_sq);
        let n = path.normal;
        let axis = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(n.x) > 0.7);
        let t1 = normalize(cross(axis, n));
        path.p = s * (cos(phi) * t1 + sin(phi) * cross(n, t1)) - a * n;
        path.layer = top;
        path.turns |= STRAY;
        return GOES_ON;
    }
    return END_CAP;
}

// Mirror reflection at the touched face.
fn touch_reflect() {
    path.p -= 2.0 * dot(path.p, path.normal) * path.normal;
    path.turns += 1u;
}
