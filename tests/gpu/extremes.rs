//! Geometry at its limits, with a guard between any two steps: grazing rays, rays through corners, ten thousand
//! bounces. The rays are those of the stability table.

use crate::scenes::{Case, variants};
use crate::watch::{Seen, assert_sound, direction};
use std::f64::consts::{FRAC_PI_4, TAU};
use tirtouch::stability::{CHECKS, Context, Start, Tracer, corners, grazing, membrane};
use tirtouch::trace::Model;
use tirtouch::trace::cpu::{End, Limits, Path};

fn hard_cases() -> Vec<(String, Model<f32>)> {
    let presets = ["tsis-paper", "dent-cap", "tsis-dent", "contact-disc"].map(Case::preset);
    let cases = presets.into_iter().chain(variants());
    cases.map(|case| (case.name.clone(), case.model([4, 3]).cast())).collect()
}

/// Follows rays from where they start to their ends.
fn follow(model: &Model<f32>, starts: &[Start]) -> Seen {
    let mut seen = Seen::default();
    for (k, start) in starts.iter().enumerate() {
        let mut path = Path::new(model, Limits::default());
        path.start_random(3, k as u32, 0);
        start.put(&mut path);
        seen.follow(&mut path, End::GoesOn);
    }
    seen
}

#[test]
fn grazing_rays_keep_their_place() {
    for (name, model) in hard_cases() {
        let seen = follow(&model, &grazing(&model));
        println!("{name}: {seen:?}");
        assert!(seen.paths > 100, "{name}: {seen:?}");
        assert_sound(&seen, &name);
        assert_eq!(seen.lost, 0, "{name}: {seen:?}");
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
        let mut all = follow(&model, &corners(&model));
        // From below through every node of a coarse grid.
        let [half_x, half_y] = model.half_size.map(f64::from);
        for step in 0..64u32 {
            let turn = FRAC_PI_4 + f64::from(step % 4) * 0.25 * TAU;
            let node = [half_x * (f64::from(step % 8) / 4.0 - 1.0), half_y * (f64::from(step / 8) / 4.0 - 1.0)];
            all.camera_ray(&model, step, node, direction(0.0, 0.0));
            all.camera_ray(&model, step, node, direction(FRAC_PI_4, turn));
        }
        println!("{name}: {all:?}");
        assert!(all.paths > 300, "{name}: {all:?}");
        assert_sound(&all, &name);
        assert_eq!(all.lost, 0, "{name}: {all:?}");
    }
}

#[test]
fn ten_thousand_lossless_bounces_keep_the_weight_and_the_invariants() {
    let context = Context { tracers: vec![Tracer::twin()], membrane: membrane::deflection, quick: false };
    let bounces = CHECKS.iter().find(|check| check.name == "lossless bounces").unwrap();
    let rows = bounces.run(&context);
    assert!(rows.len() > 8 && rows.iter().all(|row| row.passed), "{rows:#?}");
}
