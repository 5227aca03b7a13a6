//! Geometry at its limits: grazing rays, rays through corners, ten thousand bounces.

use crate::scenes::{Case, variants};
use crate::watch::{Seen, assert_sound, direction};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use tirtouch::scene::{Scene, Shape, Walls};
use tirtouch::trace::Model;
use tirtouch::trace::cpu::vec3::v3;
use tirtouch::trace::cpu::{End, Limits, Path};

fn hard_cases() -> Vec<(String, Model<f32>)> {
    let presets = ["tsis-paper", "dent-cap", "tsis-dent", "contact-disc"].map(Case::preset);
    let cases = presets.into_iter().chain(variants());
    cases.map(|case| (case.name.clone(), case.model([4, 3]).cast())).collect()
}

/// A ray inside the stack at `at` with direction d (a unit vector).
fn inside(model: &Model<f32>, k: u32, at: [f64; 3], layer: usize, d: [f64; 3]) -> Seen {
    let mut path = Path::new(model, Limits::default());
    path.start_random(3, k, 0);
    path.o = v3(at[0] as f32, at[1] as f32, at[2] as f32);
    path.layer = layer;
    path.p = v3(d[0] as f32, d[1] as f32, d[2] as f32) * model.layers[layer].n;
    let mut seen = Seen::default();
    seen.follow(&mut path, End::GoesOn);
    seen
}

/// Height of an interface above a point.
fn height(model: &Model<f32>, i: usize, [x, y]: [f64; 2]) -> f64 {
    let mut path = Path::new(model, Limits::default());
    let face = model.faces[i];
    f64::from(if face.share == 0.0 { face.z } else { path.surface_height(i, x as f32, y as f32) })
}

#[test]
fn grazing_rays_keep_their_place() {
    let at = [-14.0, 9.0];
    for (name, model) in hard_cases() {
        let (mut within, mut along) = (Seen::default(), Seen::default());
        for layer in 1..model.faces.len() {
            let (low, high) = (height(&model, layer - 1, at), height(&model, layer, at));
            // By 0.1 degrees from the horizontal down to nothing: in the layer's middle, and from its lower face up.
            for step in 0..=40u32 {
                let off = if step == 40 { 0.0 } else { 0.1f64.to_radians() * 10f64.powf(-f64::from(step) / 4.0) };
                let turn = 0.1 + 0.37 * f64::from(step);
                let ray = |z: f64, angle: f64| inside(&model, step, [at[0], at[1], z], layer, direction(angle, turn));
                let middle = 0.5 * (low + high);
                within = within.merge(ray(middle, FRAC_PI_2 - off)).merge(ray(middle, FRAC_PI_2 + off));
                along = along.merge(ray(low, FRAC_PI_2 - off));
            }
        }
        println!("{name}: {within:?}, along a face {along:?}");
        let all = within.merge(along);
        assert_sound(&all, &name);
        assert_eq!(all.lost, 0, "{name}: {all:?}");
    }
}

#[test]
fn rays_along_height_fields_keep_their_place() {
    for name in ["gaussian-dent", "height-map", "dent-contact", "pressed"] {
        let seen = Seen::along(&Case::named(name).model([4, 3]));
        println!("{name}: {seen:?}");
        assert!(seen.paths > 1000, "{name}: {seen:?}");
        assert!(seen.wrong_layer_mm <= Seen::CREEPING_MM, "{name}: {seen:?}");
        assert_sound(&Seen { wrong_layer_mm: 0.0, ..seen }, name);
        assert_eq!(seen.lost, 0, "{name}: {seen:?}");
    }
}

#[test]
fn rays_through_edges_and_corners_keep_their_place() {
    for (name, model) in hard_cases() {
        let mut all = Seen::default();
        let [half_x, half_y] = model.half_size.map(f64::from);
        for step in 0..64u32 {
            // From the middle of a layer through its upper corner, through the edges of two walls, and up the axis.
            let turn = FRAC_PI_4 + f64::from(step % 4) * 0.25 * TAU;
            let layer = 1 + step as usize % (model.faces.len() - 1);
            let [middle, corner] =
                [[0.0, 0.0], [half_x, half_y]].map(|at| [layer - 1, layer].map(|i| height(&model, i, at)));
            let high = corner[1];
            let middle = 0.5 * (middle[0] + middle[1]);
            let to_corner = f64::atan2(half_x.hypot(half_y), high - middle);
            for angle in [to_corner, FRAC_PI_2, 0.0, std::f64::consts::PI] {
                all = all.merge(inside(&model, step, [0.0, 0.0, middle], layer, direction(angle, turn)));
            }
            // From a corner of the stack, inwards; and from below through every node of a coarse grid.
            let (x, y) = (half_x * turn.cos().signum(), half_y * turn.sin().signum());
            let inward = direction(1.2, turn + 0.5 * TAU);
            all = all.merge(inside(&model, step, [x, y, corner[0]], layer, inward));
            let node = [half_x * (f64::from(step % 8) / 4.0 - 1.0), half_y * (f64::from(step / 8) / 4.0 - 1.0)];
            let mut seen = Seen::default();
            seen.camera_ray(&model, step, node, direction(0.0, 0.0));
            seen.camera_ray(&model, step, node, direction(FRAC_PI_4, turn));
            all = all.merge(seen);
        }
        println!("{name}: {all:?}");
        assert_sound(&all, &name);
        assert_eq!(all.lost, 0, "{name}: {all:?}");
    }
}

/// A stack of mirrors all round, without LEDs.
fn cavity(change: impl FnOnce(&mut Scene)) -> Model<f32> {
    let mut case = Case::preset("flat-bonded");
    case.loaded.scene.stack.walls = Walls::Mirror { reflectance: 1.0 };
    change(&mut case.loaded.scene);
    let mut model = case.model([4, 3]);
    model.leds.clear();
    model.cast()
}

#[test]
fn ten_thousand_lossless_bounces_keep_the_weight_and_the_invariant() {
    let flat = cavity(|_| {});
    // The same planes as height fields, whose normals are looked up and whose reflections are those of any slope.
    let field =
        cavity(|s| s.touch.shape = Shape::GaussianDent { depth_mm: 1e-9, sigma_mm: 2.0, center_mm: [0.0, 0.0] });
    for model in [flat, field] {
        let mut path = Path::new(&model, Limits::ENDLESS);
        path.start_random(9, 9, 0);
        path.layer = 2;
        path.o = v3(0.3, -0.7, 4.0);
        // s = 1.39 sin 60 degrees: above the surround's index and below every layer's.
        path.p = v3(0.9f32, 0.8, 0.689_855) * (1.39 / (0.81f32 + 0.64 + 0.475_9).sqrt());
        let s = |path: &Path<f32>| path.p.x.hypot(path.p.y);
        let start = s(&path);
        let mut drift = 0.0f32;
        for _ in 0..10_000 {
            assert_eq!(path.step(), End::GoesOn);
            drift = drift.max((s(&path) / start - 1.0).abs());
        }
        println!("drift of s: {drift:.1e}");
        assert_eq!(path.weight, 1.0);
        assert!(drift < 1e-3, "{drift}");
    }
}
