// Looks into the tracer for the stability table: rays that start where they are told and are followed for so many
// steps, and reflectances at given momenta. The numbers come in `led_tables`, which no LED of a probed scene uses, and
// go out in the event rows.

override MAPPED: bool = false;
override SPLATTED: bool = false;

const WORDS_IN: u32 = 8u;   // a row: position, momentum, layer, steps; or a, n_t^2 - n_i^2, n_i^2 and -1 in the last

fn units(w: f32) -> i32 { return 0; }
fn book(slot: u32, amount: i32) {}
fn book_segment() {}

fn input(row: u32, k: u32) -> f32 { return led_tables[(row * WORDS_IN + k) / 2u][k % 2u]; }
fn put(row: u32, k: u32, v: f32) { events[row * EVENTS + k] = bitcast<u32>(v); }

@compute @workgroup_size(WORKGROUP)
fn probe(@builtin(global_invocation_id) id: vec3u) {
    let row = id.x;
    if (row >= run.count) { return; }
    read_scene();
    let steps = input(row, 7u);
    if (steps < 0.0) {
        put(row, 0u, reflectance(input(row, 0u), input(row, 1u), input(row, 2u)));
        return;
    }
    start_random(row, 0u);
    record_start(row);
    path.o = vec3f(input(row, 0u), input(row, 1u), input(row, 2u));
    path.p = vec3f(input(row, 3u), input(row, 4u), input(row, 5u));
    path.layer = u32(input(row, 6u));
    path.weight = 1.0;
    path.bounces = 0u;
    path.turns = 0u;
    let start = length(path.p.xy);
    var drift = 0.0;
    var stretch = 0.0;   // of |p| over the index
    var taken = 0u;
    var end = GOES_ON;
    loop {
        if (end != GOES_ON || taken >= u32(steps)) { break; }
        end = step(DEFORMED && in_curved_layer());
        taken += 1u;
        if (TOUCHED && end == END_TOUCH) { end = photon_touch(); }
        drift = max(drift, abs(length(path.p.xy) - start));
        stretch = max(stretch, abs(length(path.p) / layer_n(path.layer) - 1.0));
    }
    put(row, 0u, path.o.x);
    put(row, 1u, path.o.y);
    put(row, 2u, path.o.z);
    put(row, 3u, path.p.x);
    put(row, 4u, path.p.y);
    put(row, 5u, path.p.z);
    put(row, 6u, path.weight);
    put(row, 7u, drift / start);
    events[row * EVENTS + 8u] = path.layer;
    events[row * EVENTS + 9u] = end;
    events[row * EVENTS + 10u] = taken;
    put(row, 11u, stretch);
}
