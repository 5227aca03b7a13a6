// Photons from the LEDs: the flux ledger, and by need the irradiance map of the touched face (MAPPED) or the splat of
// each diffuse vertex into its pixel (SPLATTED). Each thread sends `run.samples` photons.

override MAPPED: bool = false;
override SPLATTED: bool = false;

@group(0) @binding(12) var<storage, read_write> ledger: array<atomic<u32>>;

var<private> tally: array<i32, BOOK_SLOTS>;

fn units(w: f32) -> i32 { return i32(round(w * UNIT)); }
fn book(slot: u32, amount: i32) { tally[slot] += amount; }
fn book_segment() { tally[BOOK_SEGMENTS] += 1; }

// The last booking of a photon, or of a part of it.
fn close(end: u32) {
    let w = units(path.weight);
    if (end == END_SIDES) { book(BOOK_SIDES, w); }
    else if (end == END_TOP) { book(BOOK_TOP, w); }
    else if (end == END_BOTTOM) { book(select(BOOK_BOTTOM, BOOK_DETECTED, enters_lens()), w); }
    else if (end == END_CAP) { book(BOOK_TERMINATED, w); }
    else if (end == END_ROULETTE) { book(BOOK_ROULETTE, w); }
    else if (end == END_LOST) { book(BOOK_LOST, 1); }
    else { book(BOOK_ABSORBED, w); }
}

fn enters_lens() -> bool {
    if (!LENS || path.p.z >= 0.0) { return false; }
    let at = path.o.xy - path.p.xy * ((path.o.z + scene.camera_distance) / path.p.z);
    return dot(at, at) <= scene.lens_radius * scene.lens_radius;
}

@compute @workgroup_size(WORKGROUP)
fn photons(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= run.count) { return; }
    read_scene();
    for (var b = 0u; b < BOOK_SLOTS; b += 1u) { tally[b] = 0; }
    let thread = run.first + id.x % run.threads;
    let first_sample = run.first_sample + id.x / run.threads * run.samples;
    var s = 0u;
    loop {
        // On to the next photon that is not astray from the start.
        var end = END_ASTRAY;
        loop {
            if (end != END_ASTRAY || s >= run.samples) { break; }
            start_random(thread, first_sample + s);
            record_start(id.x * run.samples + s);
            end = launch();
            book(BOOK_EMITTED, i32(UNIT));
            s += 1u;
            if (AIMED && end == GOES_ON && astray()) {
                end = END_ASTRAY;
                record_end(end);
            }
        }
        if (end == END_ASTRAY) { break; }
        loop {
            if (end != GOES_ON) {
                record_end(end);
                close(end);
                if (!go_on_mirrored()) { break; }
            }
            end = walk();
            if (TOUCHED && end == END_TOUCH) { end = photon_touch(); }
        }
    }
    for (var b = 0u; b < BOOK_SLOTS; b += 1u) {
        if (tally[b] == 0) { continue; }
        // Signed amounts in two's complement over 64 bits.
        let low = u32(tally[b]);
        let old = atomicAdd(&ledger[2u * b], low);
        let high = select(0u, 0xffffffffu, tally[b] < 0) + select(0u, 1u, old + low < old);
        atomicAdd(&ledger[2u * b + 1u], high);
    }
}
