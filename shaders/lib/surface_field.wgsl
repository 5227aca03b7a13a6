// Smooth height fields, one per deformed interface; `field_at` gives their displacement and its gradient, relative to
// the undeformed plane. Intersection by safe Newton: with |G''| <= K along the ray the step below never passes the
// first root. A ray that runs along the surface gets on by steps of some micrometres then. After SAFE_STEPS they are
// lengthened, evenly more from step to step, so that it comes across within the steps it has; where that steps over the
// surface it goes back and on by safe steps.


@group(0) @binding(8) var<storage, read> field: array<vec4f>;

var<private> field_slope: vec2f;

fn surface_cross(i: u32, o: vec3f, p: vec3f, side: f32, t_max: f32) -> f32 {
    let zeta = o.z - face_z(i);
    // Enter the slab that holds the surface.
    let near = select(face_high(i), face_low(i), side > 0.0);
    let outside = (near - zeta) * side > 0.0;
    var t = select(0.0, (near - zeta) / p.z, outside);
    if (outside && p.z * side <= 0.0) { return FAR; }
    let k = max(face_curvature(i) * dot(p.xy, p.xy), 1e-12);
    // Lengthened by so much each, half of the steps reach across.
    let reach = min(t_max, 2.0 * (scene.half_size.x + scene.half_size.y));
    let longer = 8.0 * reach / (f32(SEARCH_STEPS) * f32(SEARCH_STEPS));
    var taken = 0.0;    // since it went back
    var before = 0.0;   // rise before the last step
    var last = 0.0;     // that step
    for (var n = 0u; n < SEARCH_STEPS; n += 1u) {
        if (t >= t_max) { return FAR; }
        let h = field_at(i, o.xy + t * p.xy);
        let rise = side * (h.x - (zeta + t * p.z));
        let over = taken > SAFE_STEPS && rise < -STEPPED_OVER && before >= -STEPPED_OVER;
        let g = max(rise, 0.0);
        let slope = side * (h.y * p.x + h.z * p.y - p.z);
        // Leaving or along the surface the gap counts as the rounding of a height at least, and for a ray that still
        // runs in the surface as more, up to 1e-4 mm, so that it gets on.
        let least = min(1e-6 + 4e-9 * taken * taken, 1e-4);
        let gap = select(max(g, least), g, slope < 0.0);
        let root = sqrt(slope * slope + 2.0 * k * gap);
        let step = select((root + slope) / k, 2.0 * gap / (root - slope), slope < 0.0);
        // Newton converges quadratically: the last step leaves an error of k step^2, and the slope is good to k step.
        let straight = k * step < 1e-5 && k * step * step < 1e-8;
        if (slope < 0.0 && !over && (step < 1e-5 || straight)) {
            field_slope = h.yz;
            return t + step;
        }
        last = select(max(step, max(longer * (taken - SAFE_STEPS), 1e-7)), -last, over);
        before = select(rise, before, over);
        taken = select(taken + 1.0, 0.0, over);
        t += last;
        let z = zeta + t * p.z;
        if ((near - z) * side > 0.0 && p.z * side <= 0.0) { return FAR; }
    }
    record_lost();
    return FAR;
}

// At the crossing just found.
fn surface_normal(i: u32, o: vec3f, side: f32) -> vec3f { return normalize(vec3f(-field_slope, 1.0)); }

fn surface_height(i: u32, xy: vec2f) -> f32 {
    let h = field_at(i, xy);
    field_slope = h.yz;
    return face_z(i) + h.x;
}
