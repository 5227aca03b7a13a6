//! The guard of the stability table that looks at a path of the twin between any two steps of its walk, and its own
//! test.

pub use tirtouch::stability::watch::{Seen, direction};
use tirtouch::trace::cpu::{End, Limits, Path};

/// Panics unless every path kept its place.
pub fn assert_sound(seen: &Seen, name: &str) {
    assert!(seen.faults().is_empty(), "{name}: {:?} in {seen:?}", seen.faults());
}

#[test]
fn the_guard_sees_a_wrong_layer_a_wrong_momentum_a_wrong_place_and_a_nan() {
    let model = crate::scenes::Case::preset("dent-cap").model([4, 3]).cast::<f32>();
    let spoiled = |spoil: &dyn Fn(&mut Path<f32>)| {
        let mut path = Path::new(&model, Limits::default());
        path.start_random(1, 1, 0);
        assert_eq!(path.launch(), End::GoesOn);
        let mut seen = Seen::default();
        seen.look(&mut path);
        assert_sound(&seen, "untouched");
        spoil(&mut path);
        seen.look(&mut path);
        seen
    };
    assert!(spoiled(&|path| path.layer += 1).wrong_layer_mm > 0.1);
    assert!(spoiled(&|path| path.p.z *= 1.01).momentum > 1e-5);
    assert!(spoiled(&|path| path.o = path.o * 1.01).outside_mm > 0.1);
    assert_eq!(spoiled(&|path| path.o.y = f32::NAN).not_finite, 1);
}
