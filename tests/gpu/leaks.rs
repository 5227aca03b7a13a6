//! No ray gets stuck, leaves its layer or loses its numbers; lost rays are counted.
//!
//! `TIRTOUCH_LEAK_SEGMENTS=1e8` asks for that many segments on every preset (some minutes); 2e6 without it.

use crate::scenes::{Case, presets, variants};
use crate::watch::{Seen, assert_sound, direction};
use rayon::prelude::*;
use tirtouch::trace::cpu::{Limits, Path};
use tirtouch::trace::model::Real;

const SEGMENTS: &str = "TIRTOUCH_LEAK_SEGMENTS";
/// Photons of one round, shared among the threads.
const ROUND: u32 = 8192;
/// Largest share of photons that may get lost: what a render accepts.
const LOST_TOLERANCE: f64 = 1e-6;

fn watch(case: &Case, segments: u64) -> Seen {
    let model = case.model([4, 3]).cast::<f32>();
    let [half_x, half_y] = model.half_size.map(Real::wide);
    let mut all = Seen::default();
    for round in 0.. {
        let seen = (0..ROUND).into_par_iter().map(|k| {
            let mut seen = Seen::default();
            seen.photon(&model, round, k);
            // A camera path: any point of the lowest face, any direction up.
            let mut draws = Path::new(&model, Limits::default());
            draws.start_random(!round, k, 0);
            let [x, y, z, turn] = std::array::from_fn(|_| draws.draw().wide());
            let at = [(2.0 * x - 1.0) * half_x, (2.0 * y - 1.0) * half_y];
            let d = direction(z.acos(), std::f64::consts::TAU * turn);
            seen.camera_ray(&model, round.wrapping_mul(ROUND).wrapping_add(k), at, d);
            seen
        });
        all = all.merge(seen.reduce(Seen::default, Seen::merge));
        if all.segments >= segments {
            break;
        }
    }
    all
}

#[test]
fn no_ray_leaves_its_layer_or_gets_stuck() {
    let asked = std::env::var(SEGMENTS).ok().map(|text| text.parse::<f64>().expect("a number of segments"));
    let segments = asked.unwrap_or(2e6) as u64;
    for case in presets().iter().chain(&variants()) {
        let start = std::time::Instant::now();
        let seen = watch(case, segments);
        println!("{} ({:.1} s): {seen:?}", case.name, start.elapsed().as_secs_f64());
        assert_sound(&seen, &case.name);
        assert!(seen.lost as f64 <= LOST_TOLERANCE * seen.paths as f64, "{}: {seen:?}", case.name);
    }
}
