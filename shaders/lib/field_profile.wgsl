// Height fields about an axis: cubics over the distance to it, one vec4 of coefficients a cell.

// Displacement and its gradient.
fn field_at(i: u32, xy: vec2f) -> vec3f {
    let d = xy - scene.field_center;
    let r = sqrt(dot(d, d));
    let g = r * scene.field_scale.x;
    let cell = min(floor(g), f32(scene.field_size.x - 1u));
    let u = min(g - cell, 1.0);
    let c = field[face_field(i) + u32(cell)];
    let height = c.x + u * (c.y + u * (c.z + u * c.w));
    let slope = (c.y + u * (2.0 * c.z + u * 3.0 * c.w)) * scene.field_scale.x / max(r, 1e-30);
    return vec3f(height, slope * d);
}
