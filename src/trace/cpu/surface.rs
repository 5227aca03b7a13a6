//! Twin of `surface_*.wgsl`: crossings, normals and heights of deformed interfaces.
//!
//! Height fields are of two kinds: cubics over the distance to an axis (round dents, axisymmetric presses) and bicubic
//! splines over the plane (all others). One search serves both, by steps that a bound on the field's bending proves
//! safe, one bound for each field (docs/decisions/height-fields.md).

use super::Path;
use super::vec3::{V3, v3};
use crate::trace::constants::{FAR, SAFE_STEPS, STEPPED_OVER};
use crate::trace::model::{CapShape, Deformation, FieldShape, Heights, MeshShape, Real};

/// Further than anything.
pub fn far<T: Real>() -> T {
    T::of(FAR)
}

fn c<T: Real>(v: f64) -> T {
    T::of(v)
}

impl<T: Real> Path<'_, T> {
    /// First crossing of deformed interface `i` from below (side 1) or above (side -1), in units of the momentum.
    pub fn surface_cross(&mut self, i: usize, o: V3<T>, p: V3<T>, side: T, t_max: T) -> T {
        match &self.model.shape {
            Deformation::Plane => far(),
            Deformation::Cap(cap) => self.cap_cross(cap, i, o, p, side),
            Deformation::Field(field) => self.field_cross(field, i, o, p, side, t_max),
            Deformation::Mesh(mesh) => self.mesh_cross(mesh, o, p, side, t_max),
        }
    }

    /// Upward unit normal of deformed interface `i` where the path met it from below (side 1) or above (side -1), or at
    /// any point on it (side 0).
    pub fn surface_normal(&self, i: usize, o: V3<T>, side: T) -> V3<T> {
        match &self.model.shape {
            Deformation::Plane => V3::up(),
            Deformation::Cap(cap) => {
                let (x, y) = (o.x - cap.center[0], o.y - cap.center[1]);
                let share = self.model.faces[i].share;
                let zeta = (o.z - self.model.faces[i].z) / share - (cap.ball - cap.depth);
                let m = v3(-x, -y, -zeta / share).normalize();
                let beyond = x * x + y * y - cap.rim_sq;
                let at_rim = beyond.abs() <= c::<T>(1e-5) * cap.rim_sq;
                let on_cap = if at_rim { self.p.dot(m) * side > T::zero() } else { beyond < T::zero() };
                if on_cap { m } else { V3::up() }
            }
            // At the crossing just found.
            Deformation::Field(_) => v3(-self.field_slope[0], -self.field_slope[1], T::one()).normalize(),
            Deformation::Mesh(_) => {
                let [smooth, facet] = self.mesh_normals;
                let across = self.p.dot(facet);
                let along = self.p.dot(smooth);
                let reflected = across - c::<T>(2.0) * along * smooth.dot(facet);
                let keep = along * across > T::zero() && reflected * across < T::zero();
                if keep { smooth } else { facet }
            }
        }
    }

    /// Height of deformed interface `i`, mm.
    pub fn surface_height(&mut self, i: usize, x: T, y: T) -> T {
        let face = self.model.faces[i];
        match &self.model.shape {
            Deformation::Plane => face.z,
            Deformation::Cap(cap) => {
                let (dx, dy) = (x - cap.center[0], y - cap.center[1]);
                let r_sq = dx * dx + dy * dy;
                let h = cap.ball - cap.depth - (cap.ball * cap.ball - r_sq).max(T::zero()).sqrt();
                face.z + face.share * if r_sq < cap.rim_sq { h } else { T::zero() }
            }
            Deformation::Field(field) => {
                let h = self.field_at(field, i, x, y);
                self.field_slope = [h[1], h[2]];
                face.z + h[0]
            }
            Deformation::Mesh(mesh) => {
                let low = face.z + face.low - T::one();
                let t = self.mesh_cross(mesh, v3(x, y, low), V3::up(), T::one(), far());
                if t >= far() { face.z } else { low + t }
            }
        }
    }

    fn cap_cross(&self, cap: &CapShape<T>, i: usize, o: V3<T>, p: V3<T>, side: T) -> T {
        let zero = T::zero();
        let inv = T::one() / self.model.faces[i].share;
        let zeta = (o.z - self.model.faces[i].z) * inv;
        let d = v3(p.x, p.y, p.z * inv);
        let q = v3(o.x - cap.center[0], o.y - cap.center[1], zeta - (cap.ball - cap.depth));
        let a = d.dot(d);
        let b = q.dot(d);
        let k = q.dot(q) - cap.ball * cap.ball;
        let disc = b * b - a * k;
        let root = disc.max(zero).sqrt();
        let enter = k / (root - b);
        let leave = if b > zero { -k / (root + b) } else { (root - b) / a };
        let t = (if side > zero { enter } else { leave }).max(zero);
        if disc >= zero && (side < zero || b < zero) && zeta + t * d.z < zero {
            return t;
        }
        if d.z * side > zero { (-zeta / d.z).max(zero) } else { far() }
    }

    fn field_at(&self, field: &FieldShape<T>, i: usize, x: T, y: T) -> [T; 3] {
        let ([columns, rows], per_mm, control) = match &field.heights {
            Heights::Grid { size, per_mm, control } => (*size, *per_mm, &control[self.model.faces[i].field]),
            Heights::Profile { per_mm, cells } => {
                let d = [x - field.center[0], y - field.center[1]];
                return profile_at(&cells[self.model.faces[i].field], *per_mm, d);
            }
        };
        let gx = (x + self.model.half_size[0]) * per_mm[0];
        let gy = (y + self.model.half_size[1]) * per_mm[1];
        let clamp = |v: T, hi: T| v.max(T::zero()).min(hi);
        let cx = clamp(gx.floor(), c((columns - 2) as f64));
        let cy = clamp(gy.floor(), c((rows - 2) as f64));
        let ux = clamp(gx - cx, T::one());
        let uy = clamp(gy - cy, T::one());
        let (wx, dx, wy, dy) = (weights(ux), slopes(ux), weights(uy), slopes(uy));
        let (cx, cy) = (cx.to_usize().unwrap_or(0), cy.to_usize().unwrap_or(0));
        let dot = |a: &[T], b: [T; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
        let mut values = [T::zero(); 4];
        let mut along = [T::zero(); 4];
        for j in 0..4 {
            let at = (cy + j) * (columns + 2) + cx;
            let row = &control[at..at + 4];
            values[j] = dot(row, wx);
            along[j] = dot(row, dx);
        }
        [dot(&values, wy), dot(&along, wy) * per_mm[0], dot(&values, dy) * per_mm[1]]
    }

    fn field_cross(&mut self, field: &FieldShape<T>, i: usize, o: V3<T>, p: V3<T>, side: T, t_max: T) -> T {
        let zero = T::zero();
        let two = c::<T>(2.0);
        let face = self.model.faces[i];
        let zeta = o.z - face.z;
        let near = if side > zero { face.low } else { face.high };
        let outside = (near - zeta) * side > zero;
        if outside && p.z * side <= zero {
            return far();
        }
        let mut t = if outside { (near - zeta) / p.z } else { zero };
        let k = (face.curvature * (p.x * p.x + p.y * p.y)).max(c(1e-12));
        let [half_x, half_y] = self.model.half_size;
        let steps = c::<T>(f64::from(self.limits.search_steps));
        // Lengthened by so much each, half of the steps reach across.
        let longer = c::<T>(8.0) * t_max.min(two * (half_x + half_y)) / (steps * steps);
        let (mut taken, mut before, mut last) = (zero, zero, zero);
        for _ in 0..self.limits.search_steps {
            if t >= t_max {
                return far();
            }
            let h = self.field_at(field, i, o.x + t * p.x, o.y + t * p.y);
            let rise = side * (h[0] - (zeta + t * p.z));
            let over = taken > c(SAFE_STEPS) && rise < c(-STEPPED_OVER) && before >= c(-STEPPED_OVER);
            let g = rise.max(zero);
            let slope = side * (h[1] * p.x + h[2] * p.y - p.z);
            // Leaving or along the surface the gap counts as the rounding of a height at least, and for a ray that
            // still runs in the surface as more, up to 1e-4 mm, so that it gets on.
            let least = (c::<T>(1e-6) + c::<T>(4e-9) * taken * taken).min(c(1e-4));
            let gap = if slope < zero { g } else { g.max(least) };
            let root = (slope * slope + two * k * gap).sqrt();
            let step = if slope < zero { two * gap / (root - slope) } else { (root + slope) / k };
            // Newton converges quadratically: the last step leaves an error of k step^2, and the slope is good to k
            // step.
            let straight = k * step < c(1e-5) && k * step * step < c(1e-8);
            if slope < zero && !over && (step < c(1e-5) || straight) {
                self.field_slope = [h[1], h[2]];
                return t + step;
            }
            if over {
                (last, taken) = (-last, zero);
            } else {
                last = step.max(longer * (taken - c(SAFE_STEPS))).max(c(1e-7));
                (before, taken) = (rise, taken + T::one());
            }
            t = t + last;
            let z = zeta + t * p.z;
            if (near - z) * side > zero && p.z * side <= zero {
                return far();
            }
        }
        self.lost = true;
        far()
    }

    fn mesh_cross(&mut self, mesh: &MeshShape<T>, o: V3<T>, p: V3<T>, side: T, t_max: T) -> T {
        let zero = T::zero();
        let tiny = c::<T>(1e-20);
        let inv = |v: T| T::one() / if v.abs() < tiny { tiny } else { v };
        let inv = v3(inv(p.x), inv(p.y), inv(p.z));
        let mut best = t_max;
        let mut found = far();
        let mut stack = vec![0usize];
        while let Some(n) = stack.pop() {
            let node = &mesh.nodes[n];
            if box_distance(node.low, node.high, o, inv, best) >= far() {
                continue;
            }
            let first = node.first as usize;
            if node.count == 0 {
                let distance = |k: usize| box_distance(mesh.nodes[k].low, mesh.nodes[k].high, o, inv, best);
                let swap = distance(first) > distance(first + 1);
                stack.extend(if swap { [first, first + 1] } else { [first + 1, first] });
                continue;
            }
            for j in first..first + node.count as usize {
                let corner = mesh.corners[j].map(V3::from_array);
                let [a, b, d] = corner.map(|v| v - o);
                let facet = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
                let toward = facet.dot(p);
                let u = d.cross(b).dot(p);
                let v = a.cross(d).dot(p);
                let w = b.cross(a).dot(p);
                let inside = (u * side).max(v * side).max(w * side) <= zero;
                let t = (a.dot(facet) / toward).max(zero);
                if inside && toward * side > zero && t < best {
                    best = t;
                    found = t;
                    let normals = mesh.normals[j].map(V3::from_array);
                    let sum = u + v + w;
                    let smooth = normals[0] * (u / sum) + normals[1] * (v / sum) + normals[2] * (w / sum);
                    self.mesh_normals = [smooth.normalize(), facet.normalize()];
                }
            }
        }
        found
    }
}

/// Displacement and its gradient at `d` from the axis.
fn profile_at<T: Real>(cells: &[[T; 4]], per_mm: T, d: [T; 2]) -> [T; 3] {
    let r = (d[0] * d[0] + d[1] * d[1]).sqrt();
    let g = r * per_mm;
    let cell = g.floor().min(c((cells.len() - 1) as f64));
    let u = (g - cell).min(T::one());
    let [a, b, e, f] = cells[cell.to_usize().unwrap_or(0)];
    let height = a + u * (b + u * (e + u * f));
    let slope = (b + u * (c::<T>(2.0) * e + u * c(3.0) * f)) * per_mm / r.max(c(1e-30));
    [height, slope * d[0], slope * d[1]]
}

fn weights<T: Real>(u: T) -> [T; 4] {
    let v = T::one() - u;
    let (three, four, six) = (c::<T>(3.0), c::<T>(4.0), c::<T>(6.0));
    let inner = |u: T| (three * u - six) * u * u + four;
    [v * v * v, inner(u), inner(v), u * u * u].map(|w| w * c(1.0 / 6.0))
}

fn slopes<T: Real>(u: T) -> [T; 4] {
    let v = T::one() - u;
    let (three, four) = (c::<T>(3.0), c::<T>(4.0));
    [-v * v, (three * u - four) * u, (four - three * v) * v, u * u].map(|w| w * c(0.5))
}

fn box_distance<T: Real>(low: [f32; 3], high: [f32; 3], o: V3<T>, inv: V3<T>, t_max: T) -> T {
    let mut enter = T::zero();
    let mut leave = t_max;
    let axes = [(o.x, inv.x), (o.y, inv.y), (o.z, inv.z)];
    for (k, (o, inv)) in axes.into_iter().enumerate() {
        let t0 = (T::of(f64::from(low[k])) - o) * inv;
        let t1 = (T::of(f64::from(high[k])) - o) * inv;
        enter = enter.max(t0.min(t1));
        leave = leave.min(t0.max(t1));
    }
    // The boxes are f32: rounded up by two ulps per operation (Ize 2013).
    if enter <= leave * c(1.000_000_4) { enter } else { far() }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::Shape as Touch;
    use crate::surface::{HeightField, Mesh, Surface, surface};
    use crate::trace::Model;
    use crate::trace::cpu::Limits;

    /// How many of 4,000 rays that leave the touched face upwards meet it again, if they rise `share` times as fast as
    /// it does where it is steepest.
    fn returned(model: &Model<f64>, share: f64) -> usize {
        let top = model.faces.len() - 1;
        let mut path = Path::new(model, Limits::default());
        let even = |k: i32, step: f64| f64::from(k) * step % 1.0;
        let returns = |k: &i32| {
            let (r, turn) = (5.0 * even(*k, 0.754_877_67).sqrt(), std::f64::consts::TAU * even(*k, 0.569_840_29));
            let (x, y) = (r * turn.cos(), r * turn.sin());
            let away = std::f64::consts::TAU * even(*k, 0.618_033_99);
            let p = v3(away.cos(), away.sin(), share * model.faces[top].slope);
            // A micrometre above the face.
            let o = v3(x, y, path.surface_height(top, x, y) + 1e-3);
            let t = path.surface_cross(top, o, p, -1.0, 100.0);
            assert!(!path.lost);
            t < 100.0
        };
        (1..=4000).filter(returns).count()
    }

    #[test]
    fn a_ray_that_rises_faster_than_the_face_never_comes_back() {
        let mut loaded = crate::scene::preset("dent-cap").unwrap();
        let cap = surface(&loaded).unwrap();
        loaded.scene.touch.shape = Touch::GaussianDent { depth_mm: 1.0, sigma_mm: 2.0, center_mm: [0.0; 2] };
        let profile = surface(&loaded).unwrap();
        let field = HeightField::sample(129, [30.0; 2], |x, y| -(-(x * x + 2.0 * y * y) / 8.0).exp());
        let mut fields = vec![None; loaded.scene.stack.layer.len()];
        fields.push(field);
        let corner = |k: u32| f64::from(k) * 30.0 / 64.0 - 15.0;
        let height = |[x, y]: [f64; 2]| 12.0 - (-(x * x + 2.0 * y * y) / 8.0).exp();
        let at = |k: u32| [corner(k % 65), corner(k / 65)];
        let vertices: Vec<_> = (0..65 * 65).map(|k| [at(k)[0], at(k)[1], height(at(k))]).collect();
        let cells = (0..64 * 64).map(|k: u32| k / 64 * 65 + k % 64);
        let triangles: Vec<_> = cells.flat_map(|k| [[k, k + 1, k + 66], [k, k + 66, k + 65]]).collect();
        let mesh = Mesh::build(&vertices, &triangles, true).unwrap();
        for surface in [cap, profile, Surface::Fields(fields), Surface::Mesh(mesh)] {
            let model = Model::new(&loaded, &surface, None).unwrap();
            assert_eq!(returned(&model, 1.0), 0, "{}", surface.name());
            assert!(returned(&model, 0.5) > 100, "{}: {}", surface.name(), returned(&model, 0.5));
        }
    }
}
