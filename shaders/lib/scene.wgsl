// What the host gives: a `Scene`, read from a buffer by `read_scene()`, and a `Run` as a uniform.
// Lengths are mm. Directions are optical momenta p = n * (unit direction), so that p.xy is invariant across a flat
// interface and n_t^2 - n_i^2, prepared in f64, decides refraction without cancellation.

struct Scene {
    half_size: vec2f,        // half the footprint
    layer_count: u32,
    led_count: u32,
    wall_reflectance: f32,
    surround_n: f32,
    tissue_n: f32,
    tissue_albedo: f32,      // of Lambertian tissue
    tissue_center: vec2f,
    tissue_radius_sq: f32,   // tissue exists inside this radius
    spread_d: f32,           // scale of the Christensen-Burley profile
    share_size: vec2u,       // columns and rows of the share grid; 0: constant
    share: f32,
    reentry_contact: f32,    // diffuse internal reflectance tissue -> guide through true contact
    map_size: vec2u,
    reentry_gap: f32,        // the same through the air gap
    ball_radius: f32,
    cap_center: vec2f,
    cap_rim_sq: f32,
    cap_depth: f32,
    field_size: vec2u,       // height samples along x and y, or cells along the distance to the axis
    field_scale: vec2f,      // of them per mm
    image_size: vec2u,
    pixel_tan: f32,          // tangent of the view angle per pixel
    camera_distance: f32,
    lens_radius: f32,
    focus_distance: f32,
    tissue_dn_sq: f32,       // n_tissue^2 - n_top^2
    gap_dn_sq: f32,          // n_surround^2 - n_top^2
    field_center: vec2f,     // middle or axis of height fields
    quarter_albedo: f32,     // of one scattering, in tissue as a half space
    h_floor: f32,            // sqrt(1 - w), the part of 1/H that is not in `h_terms`
    map_cosines: vec2f,      // directions that the map holds
    map_toward: vec2f,       // w/4 H at them
    map_between: vec2f,      // factors for what lies between them
}

struct Run {
    seed: u32,
    first: u32,       // first pixel (camera) or first thread (photons) of this submission
    count: u32,       // pixels or threads of this submission
    threads: u32,     // in a row: the threads of the next row take the `samples` photons of each after these
    samples: u32,     // paths per pixel, or photons per thread
    first_sample: u32,
    scramble_led: u32,   // of the launches' coordinates
    scramble_radius: u32,
    scramble_turn: u32,
    scramble_polar: u32,
    scramble_azimuth: u32,
    scramble_side: u32,
}

// Layers, interfaces and LEDs are read through functions such as `face_z(i)`, which the host writes into the text: a
// chain of selects over variables, on a CPU driver 1.4 times faster overall than a gather.
@group(0) @binding(1) var<uniform> run: Run;

override DEFORMED: bool = false;
override DEFORMED_PAIRS: bool = false;   // both faces of some layer are deformed
override ABSORBING: bool = false;
override CLEAR_WALLS: bool = false;
override MIRROR_WALLS: bool = false;
override ROUGH: bool = false;
override TOUCHED: bool = false;
override LENS: bool = false;
override SPREADING: bool = false;
override ROULETTE_START: u32;
override EVENT_CAP: u32;
override SEARCH_STEPS: u32;

// Constants come before this text: src/trace/constants.rs writes them.
const TAU: f32 = 6.283185307179586;

struct Path {
    o: vec3f,
    p: vec3f,
    layer: u32,
    weight: f32,
    key: vec2u,
    draws: u32,
    number: u32,       // of the launch
    bounces: u32,
    wall: u32,         // 0 +x, 1 -x, 2 +y, 3 -y: where the walk met a wall
    turns: u32,        // reflections at outer faces; with STRAY, others too
    normal: vec3f,     // of the touched face at END_TOUCH
}
var<private> path: Path;
