// A photon at the touched face: irradiance map or splat.

// Photons of fewer reflections that met outer faces alone leave nothing in the map: their light is found by unfolding.
override UNFOLDED: u32 = 0u;
override SPLIT: bool = false;

// The mirrored part of a photon that waits, as it met the face; of no weight where none does.
var<private> mirrored: Path;

@group(0) @binding(6) var<storage, read_write> deposits: array<atomic<u32>>;

fn deposit(at: u32, v: f32) {
    let f = to_fixed(v);
    let old = atomicAdd(&deposits[2u * at], f.low);
    let carry = select(0u, 1u, old + f.low < old);
    if (f.high == 0u && carry == 0u) { return; }
    // Whoever wraps the high word makes it FULL afterwards, so it is in the end.
    let more = f.high + select(carry, 0u, f.high == FULL);
    let high = atomicAdd(&deposits[2u * at + 1u], more);
    if (high + more < high || f.high == FULL) { atomicMax(&deposits[2u * at + 1u], FULL); }
}

fn texel(xy: vec2f) -> u32 {
    let g = (xy / (2.0 * scene.half_size) + 0.5) * vec2f(scene.map_size);
    let c = vec2u(clamp(g, vec2f(0.0), vec2f(scene.map_size) - 1.0));
    return c.y * scene.map_size.x + c.x;
}

// Light of flux `w` that entered the tissue at the cosine `mu_i` and leaves it at (x, y), connected to the pinhole
// through the flat stack: with s = n sin constant, sum d_i s / sqrt(n_i^2 - s^2) = r is solved for s by bracketed
// Newton.
fn splat(xy: vec2f, w: f32, mu_i: f32) {
    let r = length(xy);
    let n_0 = scene.surround_n;
    var low = 0.0;
    var high = n_0;
    var s = r / (scene.camera_distance / n_0 + face_z(scene.layer_count) / layer_n(1));
    if (s >= high) { s = 0.5 * high; }
    var slope = 0.0;
    for (var it = 0u; it < SPLAT_STEPS; it += 1u) {
        let c_0 = sqrt(n_0 * n_0 - s * s);
        var reach = scene.camera_distance * s / c_0;
        slope = scene.camera_distance * n_0 * n_0 / (c_0 * c_0 * c_0);
        for (var k = 1u; k <= scene.layer_count; k += 1u) {
            let c = sqrt(layer_n_sq(k) - s * s);
            let d = face_z(k) - face_z(k - 1u);
            reach += d * s / c;
            slope += d * layer_n_sq(k) / (c * c * c);
        }
        if (reach > r) { high = s; } else { low = s; }
        let next = s + (r - reach) / slope;
        let step = select(0.5 * (low + high), next, next >= low && next < high);
        if (abs(step - s) < 1e-7) { break; }
        s = step;
    }
    let a = sqrt(max(layer_n_sq(scene.layer_count) - s * s, 0.0));
    var through = 1.0 - boundary(xy, a).x;
    var c = a;
    for (var k = scene.layer_count; k > 0u; k -= 1u) {
        if (ABSORBING) { through *= exp(-layer_absorption(k) * (face_z(k) - face_z(k - 1u)) * layer_n(k) / c); }
        let below = sqrt(max(c * c - face_dn_sq(k - 1u), 0.0));
        through *= 1.0 - fresnel(c, below, layer_n_sq(k), layer_n_sq(k) - face_dn_sq(k - 1u));
        c = below;
    }
    let cos_c = c / n_0;
    let s_over_r = select(s / r, 1.0 / slope, r < 1e-4);
    let tan_c = s / c;
    let direction = select(xy / r, vec2f(0.0), r == 0.0);
    let at = 0.5 * vec2f(scene.image_size) + vec2f(1.0, -1.0) * direction * tan_c / scene.pixel_tan;
    if (any(at < vec2f(0.0)) || any(at >= vec2f(scene.image_size))) { return; }
    // Solid angle of the pixel: tan^2 cos^3.
    let solid = scene.pixel_tan * scene.pixel_tan * cos_c * cos_c * cos_c;
    let spread = 3.141592653589793 * scene.tissue_n * scene.tissue_n * cos_c * slope * solid;
    let light = w * sent(mu_i, tissue_cosine(a)) * through * s_over_r / spread;
    deposit(u32(at.y) * scene.image_size.x + u32(at.x), light);
}

// Splats what tissue sends back of flux `w` that entered it at (x, y).
fn leave_tissue(from_xy: vec2f, w: f32, mu_i: f32) {
    var xy = from_xy;
    if (SPREADING) {
        xy = displace(xy);
        if (!inside(xy)) { return; }
    }
    splat(xy, w, mu_i);
}

// What the boundary sends back into the tissue leaves it later; the map's reader sums this up by itself.
fn tissue_reentry(mu: f32) {
    if (SPLATTED) { leave_tissue(path.o.xy, path.weight, mu); }
}

// Both parts go on with their shares of the weight: what enters at once and by roulette, what is mirrored later.
fn split(r: f32, mu: f32) -> u32 {
    let before = path.weight;
    let entered = (1.0 - r) * before;
    let keep = entered / ENTERED;
    path.weight = r * before;
    let u = draw();
    record(EVENT_TISSUE + select(0u, 1u, u >= keep), abs(u - keep));
    if (u >= keep) {
        book(BOOK_ROULETTE, units(before) - units(path.weight));
        touch_reflect();
        return GOES_ON;
    }
    mirrored = path;
    path.weight = max(entered, ENTERED);
    book(BOOK_ROULETTE, units(before) - units(mirrored.weight) - units(path.weight));
    return tissue_walk(mu);
}

// Takes up the mirrored part, where one waits.
fn go_on_mirrored() -> bool {
    if (!SPLIT || mirrored.weight == 0.0) { return false; }
    let draws = path.draws;
    path = mirrored;
    path.draws = draws;
    mirrored.weight = 0.0;
    touch_reflect();
    return true;
}

fn photon_touch() -> u32 {
    let a = abs(dot(path.p, path.normal));
    let r = boundary(path.o.xy, a);
    let mu = tissue_cosine(a);
    if (SPLATTED) {
        if (r.x < 1.0) { leave_tissue(path.o.xy, path.weight * (1.0 - r.x), mu); }
    } else if (MAPPED && path.turns >= UNFOLDED) {
        let at = 2u * texel(path.o.xy);
        let shares = map_shares(r, mu);
        if (shares.x > 0.0) { deposit(at, path.weight * shares.x); }
        if (shares.y > 0.0) { deposit(at + 1u, path.weight * shares.y); }
    }
    if (SPLIT && mirrored.weight == 0.0 && path.weight > 2.0 * ENTERED && r.x > MIRRORED && r.x < 1.0) {
        return split(r.x, mu);
    }
    let u = draw();
    record(EVENT_TISSUE + select(0u, 1u, u < r.x), abs(u - r.x));
    if (u < r.x) {
        touch_reflect();
        return GOES_ON;
    }
    return tissue_walk(mu);
}
