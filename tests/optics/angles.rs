//! Critical angles and acceptance angles, found by bisection on the tracer's own decisions.

use crate::bench::{self, close};
use tirtouch::optics::{acceptance_deg, critical_deg};
use tirtouch::scene::{Mount, Walls};
use tirtouch::trace::cpu::{End, Path, book, vec3::V3};
use tirtouch::trace::model::Real;
use tirtouch::trace::modes::PhotonMode;

/// Index pairs and critical angles as listed, degrees.
const CRITICAL: [(f64, f64, f64); 7] = [
    (1.41, 1.0, 45.1715),
    (1.40, 1.0, 45.5847),
    (1.39, 1.0, 46.0070),
    (1.38, 1.0, 46.4387),
    (1.41, 1.40, 83.1721),
    (1.40, 1.39, 83.1478),
    (1.39, 1.38, 83.1231),
];

/// Indices and acceptance angles in air as listed, degrees.
const ACCEPTANCE: [(f64, f64); 4] = [(1.41, 83.737), (1.40, 78.463), (1.39, 74.896), (1.38, 71.989)];

/// Where `holds` begins, between 0 and 90 degrees.
fn bisect(mut holds: impl FnMut(f64) -> bool) -> f64 {
    let (mut no, mut yes) = (0.0, 90.0);
    for _ in 0..60 {
        let middle = 0.5 * (no + yes);
        *(if holds(middle) { &mut yes } else { &mut no }) = middle;
    }
    0.5 * (no + yes)
}

/// Total reflection takes no random number: any other reflection does.
fn totally<T: Real>(path: &mut Path<T>, i: usize) -> bool {
    let before = path.draws;
    !path.meet(i, V3::up(), T::one()) && path.draws == before
}

fn critical<T: Real>(n_i: f64, n_t: f64) -> f64 {
    let above = (n_t != 1.0).then_some([1.0, n_t]);
    let layers: Vec<[f64; 2]> = above.into_iter().chain([[1.0, n_i]]).collect();
    let model = bench::model(&bench::stack(&layers)).cast::<T>();
    bisect(|angle| {
        let (sin, cos) = angle.to_radians().sin_cos();
        totally(&mut bench::path(&model, 1, [0.0, 0.0, 1.0], [n_i * sin, 0.0, n_i * cos]), 1)
    })
}

#[test]
fn total_reflection_begins_at_the_critical_angle() {
    for (n_i, n_t, listed) in CRITICAL {
        let what = format!("critical angle {n_i} to {n_t}");
        let exact = critical_deg(n_i, n_t).unwrap();
        // The square of the momentum behind the interface is off by four roundings (dn_sq, the momentum twice in its
        // square, the square) of |dn_sq| each; its slope against the angle is 2 a n_t with a = sqrt(|dn_sq|).
        let rounded = |ulp: f64| (2.0 * ulp * ((n_i - n_t) * (n_i + n_t)).sqrt() / n_t).to_degrees();
        let f64s = critical::<f64>(n_i, n_t);
        close(&format!("{what} f64"), f64s, exact, 1e-10);
        close(&format!("{what} f32"), critical::<f32>(n_i, n_t), exact, rounded(2f64.powi(-24)));
        // Half a unit of the last digit listed.
        close(&format!("{what} listed"), f64s, listed, 5e-5);
    }
}

#[test]
fn light_trapped_up_to_the_critical_angle_leaves_the_edge_at_the_acceptance_angle() {
    for (n, listed) in ACCEPTANCE {
        let mut loaded = bench::stack(&[[12.0, n]]);
        loaded.scene.stack.walls = Walls::Clear;
        let model = bench::model(&loaded);
        // The flattest angle to the faces' normal that is reflected totally on every face it meets; and where it goes.
        let mut left = 0.0;
        bisect(|angle| {
            let (sin, cos) = angle.to_radians().sin_cos();
            let mut path = bench::path(&model, 1, [0.0, 0.0, 6.0], [n * sin, 0.0, n * cos]);
            path.events = Some(Vec::new());
            let end = path.walk();
            let trapped = path.events.iter().flatten().all(|e| e.code >= 256 || e.code % 4 == 0);
            if trapped {
                assert_eq!(end, End::Sides);
                left = path.p.z.hypot(path.p.y).atan2(path.p.x.abs()).to_degrees();
            }
            trapped
        });
        // The critical angle is good to an ulp or two; the exit angle magnifies that by its tangent, below 10.
        close(&format!("acceptance of {n}"), left, acceptance_deg(n, 1.0, 1.0).unwrap(), 1e-10);
        close(&format!("acceptance of {n}, listed"), left, listed, 5e-4);
    }
}

#[test]
fn an_edge_led_in_air_leaks_through_the_faces_from_the_acceptance_angle_on() {
    for (n, _) in ACCEPTANCE {
        let leak = |excess_deg: f64| {
            let mut loaded = bench::sensor("tsis-paper");
            loaded.scene.stack.layer = bench::stack(&[[12.0, n]]).scene.stack.layer;
            for led in &mut loaded.scene.led {
                led.mount = Mount::Air { gap_mm: 0.0 };
                led.cutoff_half_angle_deg = acceptance_deg(n, 1.0, 1.0).map(|a| a + excess_deg);
            }
            let model = bench::model(&loaded);
            bench::backends(&model)
                .into_iter()
                .map(|mut backend| {
                    backend.clear_photons(PhotonMode::Ledger).unwrap();
                    backend.photons(PhotonMode::Ledger, 1, 1 << 12, [0, 64]).unwrap();
                    let (tally, _) = backend.read_photons(PhotonMode::Ledger).unwrap();
                    tally[book::TOP] + tally[book::BOTTOM]
                })
                .collect::<Vec<_>>()
        };
        // A thousandth of a degree is far above the rounding of f32 and below the digits listed. Two degrees above,
        // some 1e-4 of the 2^18 photons start steeper than the guide traps.
        assert!(leak(-1e-3).iter().all(|&l| l == 0), "{n}");
        assert!(leak(2.0).iter().all(|&l| l > 0), "{n}");
    }
}
