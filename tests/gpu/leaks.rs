//! No ray gets stuck, leaves its layer or loses its numbers; lost rays are counted.
//!
//! `TIRTOUCH_LEAK_SEGMENTS=1e8` asks for that many segments on every preset (some minutes); 1e6 without it.

use crate::scenes::{Case, at_once, presets, variants};
use crate::watch::{Seen, assert_sound};

const SEGMENTS: &str = "TIRTOUCH_LEAK_SEGMENTS";
/// Largest share of photons that may get lost: what a render accepts.
const LOST_TOLERANCE: f64 = 1e-6;

#[test]
fn no_ray_leaves_its_layer_or_gets_stuck() {
    let asked = std::env::var(SEGMENTS).ok().map(|text| text.parse::<f64>().expect("a number of segments"));
    let segments = asked.unwrap_or(1e6) as u64;
    let cases: Vec<Case> = presets().into_iter().chain(variants()).collect();
    let seen = at_once(&cases, |case| Seen::of_scene(&case.model([4, 3]).cast(), segments));
    for (case, seen) in cases.iter().zip(seen) {
        println!("{}: {seen:?}", case.name);
        assert_sound(&seen, &case.name);
        assert!(seen.lost as f64 <= LOST_TOLERANCE * seen.paths as f64, "{}: {seen:?}", case.name);
    }
}
