// LEDs: discs at the side walls. `along` runs with y on the x walls and with x on the y walls.

struct Led {
    wall: u32,
    air: u32,            // 1: in the surround before a clear wall; 0: bonded
    along: f32,
    height: f32,
    radius: f32,
    gap: f32,
    radiance: f32,       // on the axis, relative to the film's unit
    exponent: f32,       // intensity goes as cos^exponent
    cos_cutoff: f32,
    cumulative: f32,     // share of the power of this and all earlier LEDs
    table: u32,          // first entry of its intensity table, or NO_TABLE
    launch: f32,         // 1 - cos_cutoff^(exponent + 1)
}

const NO_TABLE: u32 = 0xffffffffu;
const TABLE_EDGE: u32 = 64u;   // cells in u = sin^2(theta) and in phi

override LED_TABLES: bool = false;
override COSINE_POWER: bool = false;

@group(0) @binding(4) var<uniform> leds: array<Led, 64>;
@group(0) @binding(5) var<storage, read> led_tables: array<vec2f>;   // relative radiance, cumulative share of the power

fn wall_axis(wall: u32) -> vec3f {
    let s = select(1.0, -1.0, (wall & 1u) == 1u);
    return select(vec3f(0.0, s, 0.0), vec3f(s, 0.0, 0.0), wall < 2u);
}

fn along_of(wall: u32, v: vec3f) -> f32 { return select(v.x, v.y, wall < 2u); }

// The bonded LED under the path's point on `path.wall`, or led_count.
fn wall_led() -> u32 {
    for (var k = 0u; k < scene.led_count; k += 1u) {
        let d = vec2f(along_of(path.wall, path.o) - leds[k].along, path.o.z - leds[k].height);
        if (leds[k].wall == path.wall && leds[k].air == 0u && dot(d, d) <= leds[k].radius * leds[k].radius) { return k; }
    }
    return scene.led_count;
}

// Cell of the intensity table for a direction: theta from the disc's normal, phi from z towards `along`.
fn table_cell(k: u32, sin_sq: f32, phi: f32) -> u32 {
    let turn = fract(phi / TAU + 1.0);
    let row = min(u32(sin_sq * f32(TABLE_EDGE)), TABLE_EDGE - 1u);
    return leds[k].table + row * TABLE_EDGE + min(u32(turn * f32(TABLE_EDGE)), TABLE_EDGE - 1u);
}

// Radiance of LED k against a path that meets its face with the outward cosine c.
fn led_radiance(k: u32, c: f32, v: vec3f) -> f32 {
    if (c <= leds[k].cos_cutoff) { return 0.0; }
    if (LED_TABLES && leds[k].table != NO_TABLE) {
        let phi = atan2(-along_of(leds[k].wall, v), -v.z);
        return leds[k].radiance * led_tables[table_cell(k, 1.0 - c * c, phi)].x;
    }
    if (COSINE_POWER && leds[k].exponent != 1.0) { return leds[k].radiance * pow(c, leds[k].exponent - 1.0); }
    return leds[k].radiance;
}

// Radiance over n^2 that a camera path ended with (at a wall or beyond it) finds.
fn light_at_end(end: u32) -> f32 {
    if (end == END_WALL) {
        let k = wall_led();
        if (k == scene.led_count) { return 0.0; }
        let n = layer_n(path.layer);
        record(600u + k, 1.0);
        return led_radiance(k, dot(path.p, wall_axis(path.wall)) / n, path.p / n) / (n * n);
    }
    if (end != END_SIDES) { return 0.0; }
    let n = scene.surround_n;
    for (var k = 0u; k < scene.led_count; k += 1u) {
        if (leds[k].wall != path.wall || leds[k].air == 0u) { continue; }
        let q = dot(path.p, wall_axis(path.wall));
        let at = path.o + path.p * (leds[k].gap / q);
        let d = vec2f(along_of(path.wall, at) - leds[k].along, at.z - leds[k].height);
        if (dot(d, d) <= leds[k].radius * leds[k].radius) {
            record(600u + k, 1.0);
            return led_radiance(k, q / n, path.p / n) / (n * n);
        }
    }
    return 0.0;
}

// A direction from LED k: x the squared sine to its normal, y the azimuth.
fn led_direction(k: u32) -> vec2f {
    let u = even_draw(498753u);
    let v = even_draw(110745u);
    if (LED_TABLES && leds[k].table != NO_TABLE) {
        var low = 0u;
        var high = TABLE_EDGE * TABLE_EDGE - 1u;
        loop {
            if (low >= high) { break; }
            let mid = (low + high) / 2u;
            if (led_tables[leds[k].table + mid].y > u) { high = mid; } else { low = mid + 1u; }
        }
        let e = f32(TABLE_EDGE);
        let sin_sq = (f32(low / TABLE_EDGE) + v) / e;
        return vec2f(sin_sq, TAU * (f32(low % TABLE_EDGE) + draw()) / e);
    }
    // cos^m: 1 - cos^(m+1) is uniform up to the cut-off.
    let x = 1.0 - u * leds[k].launch;
    let m = leds[k].exponent;
    var cos_sq = x;
    if (COSINE_POWER && m != 1.0) { cos_sq = pow(x, 2.0 / (m + 1.0)); }
    return vec2f(1.0 - cos_sq, TAU * v);
}

// Starts a photon at an LED. GOES_ON, or how it ended before it entered the stack.
fn launch() -> u32 {
    let pick = even_draw(1u);
    var k = 0u;
    loop {
        if (k + 1u >= scene.led_count || pick < leds[k].cumulative) { break; }
        k += 1u;
    }
    let r = leds[k].radius * sqrt(even_draw(182667u));
    let turn = TAU * even_draw(469891u);
    let along = leds[k].along + r * cos(turn);
    let z = leds[k].height + r * sin(turn);
    let direction = led_direction(k);
    let wall = leds[k].wall;
    let out = wall_axis(wall);
    let tangent = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), wall < 2u);
    let s = sqrt(direction.x);
    let d = s * (sin(direction.y) * tangent + cos(direction.y) * vec3f(0.0, 0.0, 1.0))
        - sqrt(max(1.0 - direction.x, 0.0)) * out;
    path.weight = 1.0;
    path.bounces = 0u;
    path.wall = wall;
    path.reflected = false;
    let face = select(scene.half_size.y, scene.half_size.x, wall < 2u);
    path.o = face * out + along * tangent + vec3f(0.0, 0.0, z);
    record(600u + k, 1.0);
    if (leds[k].air == 1u) {
        path.p = scene.surround_n * d;
        path.o -= d * (leds[k].gap / dot(d, out));
        // To the wall's plane; a ray that misses the wall is lost beside it.
        path.o = select(path.o, face * out, abs(out) > vec3f(0.5));
        let width = select(scene.half_size.x, scene.half_size.y, wall < 2u);
        if (abs(along_of(wall, path.o)) >= width || path.o.z <= 0.0 || path.o.z >= face_z(scene.layer_count)) { return END_SIDES; }
    }
    path.layer = layer_at(path.o);
    if (leds[k].air == 0u) {
        path.p = layer_n(path.layer) * d;
        return GOES_ON;
    }
    let a = -dot(path.p, out);
    let n_sq = scene.surround_n * scene.surround_n;
    let dn_sq = -layer_side_dn_sq(path.layer);
    let b_sq = dn_sq + a * a;
    let f = reflectance(a, dn_sq, n_sq);
    let u = even_draw(446247u);
    record(256u + wall * 2u + select(1u, 0u, u < f), abs(u - f));
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
