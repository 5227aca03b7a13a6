// A spherical cap pressed into a plane, scaled in height by the interface's share: an ellipsoid in closed form.
// In zeta = (z - z_i) / share the cap is part of a ball of radius R whose centre lies R - depth above the plane.

fn surface_cross(i: u32, o: vec3f, p: vec3f, side: f32, t_max: f32) -> f32 {
    let inv = 1.0 / face_share(i);
    let zeta = (o.z - face_z(i)) * inv;
    let d = vec3f(p.xy, p.z * inv);
    let q = vec3f(o.xy - scene.cap_center, zeta - (scene.ball_radius - scene.cap_depth));
    let a = dot(d, d);
    let b = dot(q, d);
    let c = dot(q, q) - scene.ball_radius * scene.ball_radius;
    let disc = b * b - a * c;
    let root = sqrt(max(disc, 0.0));
    // From below the ball is entered (only when approached); from above it is left.
    let enter = c / (root - b);
    let leave = select((root - b) / a, -c / (root + b), b > 0.0);
    var t = max(select(leave, enter, side > 0.0), 0.0);
    let on_cap = disc >= 0.0 && (side < 0.0 || b < 0.0) && zeta + t * d.z < 0.0;
    let plane = select(FAR, max(-zeta / d.z, 0.0), d.z * side > 0.0);
    return select(plane, t, on_cap);
}

// Within rounding of the rim either face may have been met: the one that the ray crosses outward.
fn surface_normal(i: u32, o: vec3f, side: f32) -> vec3f {
    let q = o.xy - scene.cap_center;
    let share = face_share(i);
    let zeta = (o.z - face_z(i)) / share - (scene.ball_radius - scene.cap_depth);
    let m = normalize(vec3f(-q, -zeta / share));
    let beyond = dot(q, q) - scene.cap_rim_sq;
    let at_rim = abs(beyond) <= 1e-5 * scene.cap_rim_sq;
    let on_cap = select(beyond < 0.0, (dot(path.p, m) * side > 0.0), at_rim);
    return select(vec3f(0.0, 0.0, 1.0), m, on_cap);
}

fn surface_height(i: u32, xy: vec2f) -> f32 {
    let q = xy - scene.cap_center;
    let r_sq = dot(q, q);
    let r = scene.ball_radius;
    let h = r - scene.cap_depth - sqrt(max(r * r - r_sq, 0.0));
    return face_z(i) + face_share(i) * select(0.0, h, r_sq < scene.cap_rim_sq);
}
