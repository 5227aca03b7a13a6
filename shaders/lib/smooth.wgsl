// Every interface is smooth: mirror reflection and Snell refraction about the normal.

fn facet(normal: vec3f, side: f32, alpha: f32, layer: u32) -> vec3f { return normal; }

fn bounce(i: u32, normal: vec3f, m: vec3f, side: f32, a: f32) {
    if (DEFORMED) { mirror(m); } else { path.p.z = -path.p.z; }
}

fn refract_through(i: u32, normal: vec3f, m: vec3f, side: f32, a: f32, b: f32) {
    if (DEFORMED) { path.p += side * (b - a) * m; } else { path.p.z = side * b; }
}
