// The walk: from event to event through the stack until the path meets a wall, leaves, or touches tissue.
// The layer is carried; a hit counts only when the ray crosses outward for its layer, so there is no epsilon.

// Whether this is a camera path that ends at tissue. (One that goes on into it gains nothing and takes longer.)
override EYE: bool = false;
// Whether this is a photon that counts at tissue only, where it can be told from above whether it may still meet any:
// between flat, smooth faces and black walls paths run straight when seen from there.
override AIMED: bool = false;

fn safe_divide(a: f32, b: f32) -> f32 { return select(a / b, FAR, b == 0.0); }

// First crossing of interface i from below (side 1) or above (side -1).
fn cross_face(i: u32, side: f32, t_max: f32) -> f32 {
    if (face_share(i) != 0.0) { return surface_cross(i, path.o, path.p, side, t_max); }
    return cross_plane(i, side);
}

fn cross_plane(i: u32, side: f32) -> f32 {
    let t = select(FAR, (face_z(i) - path.o.z) / path.p.z, path.p.z * side > 0.0);
    return max(t, 0.0);
}

struct Crossing { t: f32, up: bool }

// First crossing of the path's layer's two faces.
fn cross_layer(t_wall: f32) -> Crossing {
    let top = scene.layer_count;
    let above = min(path.layer, top);
    let below = path.layer - 1u;
    if (DEFORMED_PAIRS) {
        let t_up = select(FAR, cross_face(above, 1.0, t_wall), path.layer <= top);
        let t_down = cross_face(below, -1.0, min(t_wall, t_up));
        return Crossing(min(t_up, t_down), t_up < t_down);
    }
    // At most one of a layer's faces is deformed: one search serves whichever it is.
    let curved_up = path.layer <= top && face_share(above) != 0.0;
    let curved = select(below, above, curved_up);
    let side = select(-1.0, 1.0, curved_up);
    let flat_up = select(FAR, cross_plane(above, 1.0), path.layer <= top);
    let t_flat = select(flat_up, cross_plane(below, -1.0), curved_up);
    var t_curved = select(cross_plane(below, -1.0), FAR, curved_up);
    if (face_share(curved) != 0.0) { t_curved = surface_cross(curved, path.o, path.p, side, min(t_wall, t_flat)); }
    return Crossing(min(t_flat, t_curved), select(t_flat < t_curved, t_curved < t_flat, curved_up));
}

// Reflection or refraction at interface i with unit normal `normal` (upward), met from below (side 1) or above (-1).
// Returns true when the path was transmitted. Radiance over n^2 is invariant, so no weight changes here.
fn meet(i: u32, normal: vec3f, side: f32) -> bool {
    let n_sq = layer_n_sq(path.layer);
    let dn_sq = face_dn_sq(i) * side;
    var m = normal;
    if (ROUGH && face_kind(i) == ROUGH_MICROFACET) { m = facet(normal, side, face_alpha(i), path.layer); }
    let along = dot(path.p, m);
    let a = abs(along);
    let b_sq = dn_sq + a * a;
    if (b_sq <= 0.0) {
        record(i * 4u + 0u, -b_sq);
        turn(i);
        bounce(i, normal, m, side, a);
        return false;
    }
    let b = sqrt(b_sq);
    let r = fresnel(a, b, n_sq, n_sq + dn_sq);
    let u = draw();
    // Nothing shines below or above the stack: a path from the camera goes on with what the outer faces mirror. Only
    // where it may come back, half of the paths leave.
    var chance = r;
    if (EYE) {
        let top = i == scene.layer_count && side > 0.0;
        let even = !(ROUGH && face_kind(i) != SMOOTH);
        if (even && (top || i == 0u && side < 0.0)) {
            chance = select(1.0, max(r, 0.5), top && !leaves_for_good(path.p + (b - a) * m));
        }
    }
    if (u < chance) {
        if (EYE) { path.weight *= r / chance; }
        record(i * 4u + 1u, chance - u);
        turn(i);
        bounce(i, normal, m, side, a);
        return false;
    }
    if (EYE) { path.weight *= (1.0 - r) / (1.0 - chance); }
    record(i * 4u + 2u, u - chance);
    refract_through(i, normal, m, side, a, b);
    return true;
}

fn turn(i: u32) { path.turns = select(path.turns | STRAY, path.turns + 1u, i == 0u || i == scene.layer_count); }

// Whether a path above the touched face rises faster than that face does anywhere.
fn leaves_for_good(p: vec3f) -> bool {
    let slope = face_slope(scene.layer_count);
    return p.z > 0.0 && p.z * p.z >= slope * slope * dot(p.xy, p.xy);
}

fn mirror(m: vec3f) { path.p -= 2.0 * dot(path.p, m) * m; }

// Ends the path where it met something that takes a share of it; returns GOES_ON otherwise.
fn roulette() -> u32 {
    path.bounces += 1u;
    if (path.bounces >= EVENT_CAP) { return END_CAP; }
    let least = select(LEAST_PHOTON, select(LEAST_EYE, LEAST_EYE_TOUCHED, TOUCHED), EYE);
    if (path.weight < least || path.bounces > ROULETTE_START) {
        let keep = min(KEEP_AT_LEAST * path.weight / least, MOST_KEPT);
        if (draw() >= keep) { return END_ROULETTE; }
        let before = path.weight;
        path.weight = before / keep;
        book(BOOK_ROULETTE, units(before) - units(path.weight));
    }
    return GOES_ON;
}

// No tissue here, and none ahead.
fn astray() -> bool {
    let d = path.o.xy - scene.tissue_center;
    let along = dot(d, path.p.xy);
    let beyond = dot(d, d) - scene.tissue_radius_sq;
    return beyond > 0.0 && (along >= 0.0 || along * along < beyond * dot(path.p.xy, path.p.xy));
}

fn absorb(length: f32) {
    let before = path.weight;
    path.weight = before * exp(-layer_absorption(path.layer) * length);
    book(BOOK_ABSORBED, units(before) - units(path.weight));
}

// At the wall `path.wall`: reflected (GOES_ON) or ended.
fn meet_wall() -> u32 {
    if (CLEAR_WALLS) {
        let along_x = path.wall < 2u;
        let q = select(path.p.y, path.p.x, along_x);
        let a = abs(q);
        let b_sq = layer_side_dn_sq(path.layer) + a * a;
        var r = 1.0;
        var u = 0.0;
        if (b_sq > 0.0) {
            let n_sq = layer_n_sq(path.layer);
            r = fresnel(a, sqrt(b_sq), n_sq, n_sq + layer_side_dn_sq(path.layer));
            u = draw();
        }
        record(EVENT_WALL + path.wall * 2u + select(1u, 0u, u < r), select(abs(u - r), abs(b_sq), b_sq <= 0.0));
        let out = select(-q, sign(q) * sqrt(max(b_sq, 0.0)), u >= r);
        if (along_x) { path.p.x = out; } else { path.p.y = out; }
        if (u >= r) { return END_SIDES; }
        path.turns |= STRAY;
        return GOES_ON;
    }
    if (MIRROR_WALLS) {
        if (wall_led() < scene.led_count) { return END_WALL; }
        if (draw() >= scene.wall_reflectance) { return END_ABSORBED; }
        record(EVENT_WALL + path.wall * 2u, 1.0);
        if (path.wall < 2u) { path.p.x = -path.p.x; } else { path.p.y = -path.p.y; }
        path.turns |= STRAY;
        return GOES_ON;
    }
    record(EVENT_WALL + path.wall * 2u, 1.0);
    return END_WALL;
}

// One turn of the walk: a segment and what waits at its end. `curved`: a face of the layer may be deformed.
fn step(curved: bool) -> u32 {
    let top = scene.layer_count;
    let ended = roulette();
    if (ended != GOES_ON) { return ended; }
    if (AIMED && astray()) { return END_ASTRAY; }
    book_segment();
    let o = path.o;
    let p = path.p;
    let rim = select(-scene.half_size, scene.half_size, p.xy > vec2f(0.0));
    let tx = safe_divide(rim.x - o.x, p.x);
    let ty = safe_divide(rim.y - o.y, p.y);
    let t_wall = max(min(tx, ty), 0.0);
    var t_face: f32;
    var up = p.z > 0.0;
    if (curved) {
        let crossing = cross_layer(t_wall);
        t_face = crossing.t;
        up = crossing.up;
        if (lost_here()) { return END_LOST; }
    } else {
        t_face = max(safe_divide(face_z(select(path.layer - 1u, path.layer, up)) - o.z, p.z), 0.0);
    }
    let i = select(path.layer - 1u, path.layer, up);
    let side = select(-1.0, 1.0, up);
    let t = min(t_face, t_wall);
    path.o = o + t * p;
    if (ABSORBING) { absorb(t * layer_n(path.layer)); }
    if (t_wall < t_face) {
        let at_x = tx < ty;
        if (at_x) { path.o.x = rim.x; } else { path.o.y = rim.y; }
        path.wall = select(select(3u, 2u, p.y > 0.0), select(1u, 0u, p.x > 0.0), at_x);
        if (curved && path.layer > top) { return select(END_SIDES, END_TOP, p.z > 0.0); }
        return meet_wall();
    }
    if (t >= FAR) { return select(END_LOST, END_TOP, curved && path.layer > top); }
    var normal = vec3f(0.0, 0.0, 1.0);
    if (curved && face_share(i) != 0.0) {
        normal = surface_normal(i, path.o, side);
    } else {
        path.o.z = face_z(i);
    }
    if (TOUCHED && i == top && up && tissue_here(path.o.xy)) {
        path.normal = normal;
        return END_TOUCH;
    }
    if (meet(i, normal, side)) {
        path.layer = u32(i32(path.layer) + i32(side));
        if (path.layer == 0u) { return END_BOTTOM; }
        if (path.layer > top && leaves_for_good(path.p)) { return END_TOP; }
    } else if (ROUGH && path.weight == 0.0) {
        return END_ABSORBED;
    }
    return GOES_ON;
}

// To the next wall, exit or tissue. Layers between flat faces have a loop of their own: drivers that run a search for
// all lanes if one needs it then run it once a passage of a curved layer, not once a segment.
fn walk() -> u32 {
    var end = GOES_ON;
    loop {
        loop {
            if (DEFORMED && in_curved_layer()) { break; }
            end = step(false);
            if (end != GOES_ON) { break; }
        }
        if (end != GOES_ON || !DEFORMED) { break; }
        end = step(true);
        if (end != GOES_ON) { break; }
    }
    return end;
}

fn in_curved_layer() -> bool {
    let top = scene.layer_count;
    return path.layer > top || face_share(path.layer) != 0.0 || face_share(path.layer - 1u) != 0.0;
}
