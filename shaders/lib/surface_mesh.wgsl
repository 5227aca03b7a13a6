// The touched face as triangles in a two-wide BVH (built by obvhs). Edge tests are scalar triple products relative to
// the ray's origin: two triangles that share an edge compute it with opposite sign, so no ray slips between them.
// A triangle counts only when the ray crosses it outward for its layer.

struct Node { low: vec3f, count: u32, high: vec3f, first: u32 }
struct Triangle { a: vec3f, pad_a: f32, b: vec3f, pad_b: f32, c: vec3f, pad_c: f32,
                  na: vec3f, pad_na: f32, nb: vec3f, pad_nb: f32, nc: vec3f, pad_nc: f32 }

@group(0) @binding(8) var<storage, read> nodes: array<Node>;
@group(0) @binding(9) var<storage, read> triangles: array<Triangle>;

const STACK: u32 = 48u;
var<private> stack: array<u32, 48>;
var<private> mesh_normal: vec3f;
var<private> mesh_facet: vec3f;

fn box_distance(n: u32, o: vec3f, inv: vec3f, t_max: f32) -> f32 {
    let t0 = (nodes[n].low - o) * inv;
    let t1 = (nodes[n].high - o) * inv;
    let lo = min(t0, t1);
    let hi = max(t0, t1);
    let enter = max(max(lo.x, lo.y), max(lo.z, 0.0));
    // The far side is rounded up by two ulps per operation (Ize 2013).
    let leave = min(min(hi.x, hi.y), min(hi.z, t_max)) * 1.0000004;
    return select(FAR, enter, enter <= leave);
}

fn surface_cross(i: u32, o: vec3f, p: vec3f, side: f32, t_max: f32) -> f32 {
    let inv = 1.0 / select(p, vec3f(1e-20), abs(p) < vec3f(1e-20));
    var best = t_max;
    var found = FAR;
    var depth = 1u;
    stack[0] = 0u;
    loop {
        if (depth == 0u) { break; }
        depth -= 1u;
        let n = stack[depth];
        if (box_distance(n, o, inv, best) >= FAR) { continue; }
        let count = nodes[n].count;
        if (count == 0u) {
            if (depth + 2u > STACK) { record_lost(); return FAR; }
            let first = nodes[n].first;
            let swap = box_distance(first, o, inv, best) > box_distance(first + 1u, o, inv, best);
            stack[depth] = select(first + 1u, first, swap);
            stack[depth + 1u] = select(first, first + 1u, swap);
            depth += 2u;
            continue;
        }
        for (var j = nodes[n].first; j < nodes[n].first + count; j += 1u) {
            let a = triangles[j].a - o;
            let b = triangles[j].b - o;
            let c = triangles[j].c - o;
            let facet = cross(triangles[j].b - triangles[j].a, triangles[j].c - triangles[j].a);
            let toward = dot(facet, p);
            let u = dot(cross(c, b), p);
            let v = dot(cross(a, c), p);
            let w = dot(cross(b, a), p);
            // Counter-clockwise from above: crossing upward all three are negative or zero.
            let inside = max(max(u * side, v * side), w * side) <= 0.0;
            let t = max(dot(a, facet) / toward, 0.0);
            if (inside && toward * side > 0.0 && t < best) {
                best = t;
                found = t;
                let bary = vec3f(u, v, w) / (u + v + w);
                mesh_facet = normalize(facet);
                mesh_normal = normalize(bary.x * triangles[j].na + bary.y * triangles[j].nb + bary.z * triangles[j].nc);
            }
        }
    }
    return found;
}

// The interpolated normal, or the facet's where the interpolated one would send a reflected ray through the surface.
fn surface_normal(i: u32, o: vec3f, side: f32) -> vec3f {
    let across = dot(path.p, mesh_facet);
    let along = dot(path.p, mesh_normal);
    let reflected = across - 2.0 * along * dot(mesh_normal, mesh_facet);
    return select(mesh_facet, mesh_normal, along * across > 0.0 && reflected * across < 0.0);
}

fn surface_height(i: u32, xy: vec2f) -> f32 {
    let low = face_z(i) + face_low(i) - 1.0;
    let t = surface_cross(i, vec3f(xy, low), vec3f(0.0, 0.0, 1.0), 1.0, FAR);
    return select(low + t, face_z(i), t >= FAR);
}
