// No interface is deformed: nothing to look up.
fn surface_cross(i: u32, o: vec3f, p: vec3f, side: f32, t_max: f32) -> f32 { return FAR; }
fn surface_normal(i: u32, o: vec3f, side: f32) -> vec3f { return vec3f(0.0, 0.0, 1.0); }
fn surface_height(i: u32, xy: vec2f) -> f32 { return face_z(i); }
