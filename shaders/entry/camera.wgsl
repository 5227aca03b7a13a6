// Camera paths: one thread a pixel, `run.samples` paths each; the sum goes to the film.
// PATH: until the path meets an LED. COMPLEMENT: what `splat` leaves out, paths whose first tissue is not reached
// straight.
// MAPPED: at tissue the exitance map is read in place of following the path into it.
// What the image lacks, paths that get lost and weight that the cap cuts off, is counted in `fates`.

override MAPPED: bool = false;
override COMPLEMENT: bool = false;
override FILM_SCALE: f32 = 65536.0;

@group(0) @binding(6) var<storage, read_write> film: array<u32>;
@group(0) @binding(12) var<storage, read_write> fates: array<atomic<u32>>;   // paths lost; weight cut off, two words

fn book(slot: u32, amount: i32) {}
fn book_segment() { segments += 1u; }
fn units(w: f32) -> i32 { return 0; }
var<private> segments: u32;
var<private> lost_paths: u32;
var<private> cut_off: u32;

fn start_camera_path(pixel: u32) {
    let size = scene.image_size;
    let at = vec2f(f32(pixel % size.x) + draw(), f32(pixel / size.x) + draw());
    var d = vec3f((at - 0.5 * vec2f(size)) * scene.pixel_tan * vec2f(1.0, -1.0), 1.0);
    path.o = vec3f(0.0, 0.0, -scene.camera_distance);
    if (LENS) {
        let r = scene.lens_radius * sqrt(draw());
        let phi = TAU * draw();
        let lens = vec2f(r * cos(phi), r * sin(phi));
        d = vec3f(d.xy * scene.focus_distance - lens, scene.focus_distance);
        path.o = vec3f(lens, path.o.z);
    }
    path.p = normalize(d) * scene.surround_n;
    path.o += path.p * (scene.camera_distance / path.p.z);
    path.o.z = 0.0;
    path.layer = 0u;
    path.weight = 1.0;
    path.bounces = 0u;
    path.turns = 0u;
}

// Through the lowest face. What it mirrors leaves for good: that share is taken off the weight, not met by chance.
fn enter() -> bool {
    if (ROUGH && face_kind(0u) != SMOOTH) { return meet(0u, vec3f(0.0, 0.0, 1.0), 1.0); }
    let a = path.p.z;
    let n_sq = layer_n_sq(0u);
    let dn_sq = face_dn_sq(0u);
    let b_sq = dn_sq + a * a;
    if (b_sq <= 0.0) { return false; }
    let b = sqrt(b_sq);
    path.weight = 1.0 - fresnel(a, b, n_sq, n_sq + dn_sq);
    path.p.z = b;
    return true;
}

fn close(end: u32) {
    lost_paths += select(0u, 1u, end == END_LOST || end == GOES_ON);   // on its way yet: a driver ended the loop
    cut_off += select(0u, u32(round(path.weight * UNIT)), end == END_CAP);
}

fn camera_path(pixel: u32) -> f32 {
    start_camera_path(pixel);
    if (any(abs(path.o.xy) >= scene.half_size)) { return 0.0; }
    if (!enter()) { return 0.0; }
    path.layer = 1u;
    var light = 0.0;
    var end = GOES_ON;
    loop {
        end = walk();
        if (TOUCHED && end == END_TOUCH) {
            end = camera_touch(&light);
            if (end == GOES_ON) { continue; }
        }
        break;
    }
    record_end(end);
    close(end);
    return light + path.weight * light_at_end(end);
}

@compute @workgroup_size(WORKGROUP)
fn camera(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= run.count) { return; }
    read_scene();
    let pixel = run.first + id.x;
    var sum = Fixed(film[4u * pixel], film[4u * pixel + 1u]);
    segments = 0u;
    lost_paths = 0u;
    cut_off = 0u;
    var finished = 0u;
    for (var s = 0u; s < run.samples; s += 1u) {
        start_random(pixel, run.first_sample + s);
        record_start(id.x * run.samples + s);
        sum = add_fixed(sum, to_fixed(camera_path(pixel) * FILM_SCALE));
        finished += 1u;
    }
    film[4u * pixel] = sum.low;
    film[4u * pixel + 1u] = sum.high;
    film[4u * pixel + 2u] += segments;
    film[4u * pixel + 3u] += finished;
    if ((lost_paths | cut_off) == 0u) { return; }
    atomicAdd(&fates[0], lost_paths);
    let old = atomicAdd(&fates[1], cut_off);
    atomicAdd(&fates[2], select(0u, 1u, old + cut_off < old));
}
