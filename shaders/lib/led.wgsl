// LEDs: discs at the side walls, read through functions that the host writes, as for layers and interfaces:
//   led_wall         as `path.wall`
//   led_air          1: in the surround before a clear wall, at a distance of led_gap; 0: bonded
//   led_along        centre along y on the x walls and along x on the y walls; led_height, led_radius
//   led_radiance     on the axis, or the largest of its table, relative to the film's unit
//   led_exponent     intensity goes as its power of the cosine, up to led_cos_cutoff
//   led_launch       1 - cos_cutoff^(exponent + 1)
//   led_table        first entry of its intensity table, or NO_TABLE
//   led_picked       the LED for a number in [0, 1), by shares of the power; led_picked_aimed, by aimed photons' shares
//   led_aim_low, led_aim_high    sines between which aimed photons leave it, seen from above

override LED_TABLES: bool = false;
override COSINE_POWER: bool = false;

@group(0) @binding(5) var<storage, read> led_tables: array<vec2f>;   // relative radiance, cumulative share of the power

fn wall_axis(wall: u32) -> vec3f {
    let s = select(1.0, -1.0, (wall & 1u) == 1u);
    return select(vec3f(0.0, s, 0.0), vec3f(s, 0.0, 0.0), wall < 2u);
}

fn along_of(wall: u32, v: vec3f) -> f32 { return select(v.x, v.y, wall < 2u); }

// The bonded LED under the path's point on `path.wall`, or led_count.
fn wall_led() -> u32 {
    // Without a way out of the loop drivers unroll it.
    var found = scene.led_count;
    let at = vec2f(along_of(path.wall, path.o), path.o.z);
    for (var k = 0u; k < scene.led_count; k += 1u) {
        let d = at - vec2f(led_along(k), led_height(k));
        let here = led_wall(k) == path.wall && led_air(k) == 0u && dot(d, d) <= led_radius(k) * led_radius(k);
        found = select(found, k, here && found == scene.led_count);
    }
    return found;
}

// Cell of the intensity table for a direction: theta from the disc's normal, phi from z towards `along`.
fn table_cell(k: u32, sin_sq: f32, phi: f32) -> u32 {
    let turn = fract(phi / TAU + 1.0);
    let row = min(u32(sin_sq * f32(TABLE_EDGE)), TABLE_EDGE - 1u);
    return led_table(k) + row * TABLE_EDGE + min(u32(turn * f32(TABLE_EDGE)), TABLE_EDGE - 1u);
}

// Radiance of LED k against a path that meets its face with the outward cosine c.
fn led_radiance_along(k: u32, c: f32, v: vec3f) -> f32 {
    if (c <= led_cos_cutoff(k)) { return 0.0; }
    if (LED_TABLES && led_table(k) != NO_TABLE) {
        let phi = atan2(-along_of(led_wall(k), v), -v.z);
        return led_radiance(k) * led_tables[table_cell(k, 1.0 - c * c, phi)].x;
    }
    if (COSINE_POWER && led_exponent(k) != 1.0) { return led_radiance(k) * pow(c, led_exponent(k) - 1.0); }
    return led_radiance(k);
}

// Radiance over n^2 that a camera path ended with (at a wall or beyond it) finds.
fn light_at_end(end: u32) -> f32 {
    if (end == END_WALL) {
        let k = wall_led();
        if (k == scene.led_count) { return 0.0; }
        let n = layer_n(path.layer);
        record(EVENT_LED + k, 1.0);
        return led_radiance_along(k, dot(path.p, wall_axis(path.wall)) / n, path.p / n) / (n * n);
    }
    if (end != END_SIDES) { return 0.0; }
    let n = scene.surround_n;
    for (var k = 0u; k < scene.led_count; k += 1u) {
        if (led_wall(k) != path.wall || led_air(k) == 0u) { continue; }
        let q = dot(path.p, wall_axis(path.wall));
        let at = path.o + path.p * (led_gap(k) / q);
        let d = vec2f(along_of(path.wall, at) - led_along(k), at.z - led_height(k));
        if (dot(d, d) <= led_radius(k) * led_radius(k)) {
            record(EVENT_LED + k, 1.0);
            return led_radiance_along(k, q / n, path.p / n) / (n * n);
        }
    }
    return 0.0;
}

// A direction from LED k: x the squared sine to its normal, y the azimuth.
fn led_direction(k: u32) -> vec2f {
    let u = even_draw(sobol_polar(path.number), run.scramble_polar);
    let v = even_draw(sobol_azimuth(path.number), run.scramble_azimuth);
    if (LED_TABLES && led_table(k) != NO_TABLE) {
        var low = 0u;
        var high = TABLE_EDGE * TABLE_EDGE - 1u;
        loop {
            if (low >= high) { break; }
            let mid = (low + high) / 2u;
            if (led_tables[led_table(k) + mid].y > u) { high = mid; } else { low = mid + 1u; }
        }
        let e = f32(TABLE_EDGE);
        let sin_sq = (f32(low / TABLE_EDGE) + v) / e;
        return vec2f(sin_sq, TAU * (f32(low % TABLE_EDGE) + draw()) / e);
    }
    // cos^m: 1 - cos^(m+1) is uniform up to the cut-off.
    let x = 1.0 - u * led_launch(k);
    let m = led_exponent(k);
    var cos_sq = x;
    if (COSINE_POWER && m != 1.0) { cos_sq = pow(x, 2.0 / (m + 1.0)); }
    return vec2f(1.0 - cos_sq, TAU * v);
}

// Starts a photon at an LED. GOES_ON, or how it ended before it entered the stack.
fn launch() -> u32 {
    let pick = even_draw(path.number, run.scramble_led);
    var k = led_picked(pick);
    if (AIMED) { k = led_picked_aimed(pick); }
    let r = led_radius(k) * sqrt(even_draw(sobol_radius(path.number), run.scramble_radius));
    let turn = TAU * even_draw(sobol_turn(path.number), run.scramble_turn);
    let along = led_along(k) + r * cos(turn);
    let z = led_height(k) + r * sin(turn);
    let direction = led_direction(k);
    let wall = led_wall(k);
    let out = wall_axis(wall);
    let tangent = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), wall < 2u);
    let s = sqrt(direction.x);
    var aside = s * sin(direction.y);
    let up = s * cos(direction.y);
    var inward_sq = 1.0 - direction.x;
    if (AIMED) {
        // At a given height above the level the sine of the angle seen from above is uniform: stretched onto where
        // tissue is.
        let level_sq = max(1.0 - up * up, 0.0);
        let level = sqrt(level_sq);
        aside = led_aim_low(k) * level + 0.5 * (led_aim_high(k) - led_aim_low(k)) * (aside + level);
        inward_sq = level_sq - aside * aside;
    }
    let d = aside * tangent + vec3f(0.0, 0.0, up) - sqrt(max(inward_sq, 0.0)) * out;
    path.weight = 1.0;
    path.bounces = 0u;
    path.wall = wall;
    path.turns = 0u;
    let face = select(scene.half_size.y, scene.half_size.x, wall < 2u);
    path.o = face * out + along * tangent + vec3f(0.0, 0.0, z);
    record(EVENT_LED + k, 1.0);
    if (led_air(k) == 1u) {
        path.p = scene.surround_n * d;
        path.o -= d * (led_gap(k) / dot(d, out));
        // To the wall's plane; a ray that misses the wall is lost beside it.
        path.o = select(path.o, face * out, abs(out) > vec3f(0.5));
        let width = select(scene.half_size.x, scene.half_size.y, wall < 2u);
        let below_or_above = path.o.z <= 0.0 || path.o.z >= face_z(scene.layer_count);
        if (abs(along_of(wall, path.o)) >= width || below_or_above) { return END_SIDES; }
    }
    path.layer = layer_at(path.o);
    if (led_air(k) == 0u) {
        path.p = layer_n(path.layer) * d;
        return GOES_ON;
    }
    let a = -dot(path.p, out);
    let n_sq = scene.surround_n * scene.surround_n;
    let dn_sq = -layer_side_dn_sq(path.layer);
    let b_sq = dn_sq + a * a;
    let f = reflectance(a, dn_sq, n_sq);
    let u = even_draw(sobol_side(path.number), run.scramble_side);
    record(EVENT_WALL + wall * 2u + select(1u, 0u, u < f), abs(u - f));
    if (u < f) { return END_SIDES; }
    path.p -= (sqrt(b_sq) - a) * out;
    return GOES_ON;
}

// The layer that holds a point inside the stack.
fn layer_at(o: vec3f) -> u32 {
    var k = 1u;
    for (var i = 1u; i < scene.layer_count; i += 1u) {
        var z = face_z(i);
        if (DEFORMED && face_share(i) != 0.0) { z = surface_height(i, o.xy); }
        k += select(0u, 1u, o.z > z);
    }
    return k;
}
