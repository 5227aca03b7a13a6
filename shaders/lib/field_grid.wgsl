// Height fields over the plane: bicubic B-splines over the footprint. Four control points of a row lie in one vec4.

fn spline(u: f32) -> vec4f {
    let v = 1.0 - u;
    return vec4f(v * v * v, (3.0 * u - 6.0) * u * u + 4.0, (3.0 * v - 6.0) * v * v + 4.0, u * u * u) * (1.0 / 6.0);
}

fn spline_slope(u: f32) -> vec4f {
    let v = 1.0 - u;
    return vec4f(-v * v, (3.0 * u - 4.0) * u, (4.0 - 3.0 * v) * v, u * u) * 0.5;
}

// Displacement and its gradient.
fn field_at(i: u32, xy: vec2f) -> vec3f {
    let last = vec2f(scene.field_size - 2u);
    let g = (xy + scene.half_size) * scene.field_scale;
    let cell = clamp(floor(g), vec2f(0.0), last);
    let u = clamp(g - cell, vec2f(0.0), vec2f(1.0));
    let width = scene.field_size.x - 1u;
    let at = face_field(i) + u32(cell.y) * width + u32(cell.x);
    let wx = spline(u.x);
    let dx = spline_slope(u.x);
    let wy = spline(u.y);
    let dy = spline_slope(u.y);
    let r0 = field[at];
    let r1 = field[at + width];
    let r2 = field[at + 2u * width];
    let r3 = field[at + 3u * width];
    let rows = vec4f(dot(r0, wx), dot(r1, wx), dot(r2, wx), dot(r3, wx));
    let slopes = vec4f(dot(r0, dx), dot(r1, dx), dot(r2, dx), dot(r3, dx));
    return vec3f(dot(rows, wy), dot(slopes, wy) * scene.field_scale.x, dot(rows, dy) * scene.field_scale.y);
}
