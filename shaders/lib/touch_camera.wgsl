// A camera path at the touched face.

@group(0) @binding(7) var<storage, read> exitance: array<vec4f>;   // deposit, area; the same again

fn tissue_reentry(mu: f32) {}

// Exitance of the tissue at a point towards the cosine `mu_o`, as radiance times pi in the tissue's medium.
fn exitance_at(xy: vec2f, mu_o: f32) -> f32 {
    let size = vec2i(scene.map_size);
    let g = (xy / (2.0 * scene.half_size) + 0.5) * vec2f(size) - 0.5;
    let c = floor(g);
    let u = g - c;
    var sum = vec4f(0.0);
    for (var j = 0; j < 2; j += 1) {
        for (var i = 0; i < 2; i += 1) {
            let at = clamp(vec2i(c) + vec2i(i, j), vec2i(0), size - 1);
            let here = exitance[u32(at.y * size.x + at.x)];
            sum += here * select(1.0 - u.x, u.x, i == 1) * select(1.0 - u.y, u.y, j == 1);
        }
    }
    let one = select(sum.x / sum.y, 0.0, sum.y <= 0.0);
    let other = select(sum.z / sum.w, 0.0, sum.w <= 0.0);
    return exitance_toward(xy, vec2f(one, other), mu_o);
}

// At the touched face: adds light, and says how the path goes on.
fn camera_touch(light: ptr<function, f32>) -> u32 {
    let a = abs(dot(path.p, path.normal));
    let r = boundary(path.o.xy, a).x;
    if (MAPPED) {
        let leaving = exitance_at(path.o.xy, tissue_cosine(a));
        *light += path.weight * (1.0 - r) * leaving / (3.141592653589793 * scene.tissue_n * scene.tissue_n);
    }
    let chance = select(r, max(r, REFLECTED), MAPPED);
    let u = draw();
    record(EVENT_TISSUE + select(0u, 1u, u < chance), abs(u - chance));
    if (u < chance) {
        path.weight *= r / chance;
        touch_reflect();
        return GOES_ON;
    }
    if (MAPPED || (COMPLEMENT && path.turns == 0u)) { return END_ABSORBED; }
    return tissue_walk(tissue_cosine(a));
}
