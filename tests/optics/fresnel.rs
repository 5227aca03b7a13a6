//! Reflectance, as the tracer decides it.

use crate::bench::{self, close};
use tirtouch::optics;
use tirtouch::trace::Model;
use tirtouch::trace::cpu::{self, Path, vec3::V3};
use tirtouch::trace::model::Real;

/// The reflectance that `meet` compares its random number with: that number, and how far it was from going the other
/// way.
pub fn decided<T: Real>(path: &mut Path<T>, i: usize, side: f64) -> f64 {
    let before = path.draws;
    let u = path.draw().wide();
    path.draws = before;
    path.events = Some(Vec::new());
    let through = path.meet(i, V3::up(), T::of(side));
    let event = path.events.take().unwrap()[0];
    match event.code % 4 {
        0 => 1.0,
        _ if through => u - event.margin,
        _ => u + event.margin,
    }
}

/// A stack whose face 1 leads from index `n_i` up to `n_t`.
fn step(n_i: f64, n_t: f64) -> Model<f64> {
    let above = (n_t != 1.0).then_some([1.0, n_t]);
    let layers: Vec<[f64; 2]> = above.into_iter().chain([[1.0, n_i]]).collect();
    bench::model(&bench::stack(&layers))
}

fn incident(n_i: f64, angle_deg: f64) -> [f64; 3] {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    [n_i * sin, 0.0, n_i * cos]
}

/// Share of the paths that `meet` reflects, going up through face 1.
fn reflected(model: &Model<f32>, p: [f64; 3], n: u64) -> bench::Share {
    bench::count(model, 3, n, |path| {
        bench::put(path, 1, [0.0, 0.0, 1.0], p);
        !path.meet(1, V3::up(), 1.0)
    })
}

#[test]
fn normal_reflectance_is_the_listed_one() {
    for (n_i, n_t, listed, unit) in
        [(1.38, 1.0, 0.025_492_5, 1e-7), (1.41, 1.0, 0.028_942_3, 1e-7), (1.41, 1.40, 1.2664e-5, 1e-9)]
    {
        let what = format!("normal reflectance {n_i} to {n_t}");
        let model = step(n_i, n_t);
        let exact = ((n_i - n_t) / (n_i + n_t)) * ((n_i - n_t) / (n_i + n_t));
        let found = decided(&mut bench::path(&model, 1, [0.0, 0.0, 1.0], incident(n_i, 0.0)), 1, 1.0);
        // The event holds the distance from a number near 1, so 1e-15 is rounding.
        close(&what, found, exact, 1e-15);
        close(&format!("{what}, listed"), found, listed, 0.5 * unit);
        // f32: the momenta are rounded to 2^-24 of 1.4, their difference enters twice.
        let single = model.cast::<f32>();
        let found = decided(&mut bench::path(&single, 1, [0.0, 0.0, 1.0], incident(n_i, 0.0)), 1, 1.0);
        let ulps = 4.0 * 1.4 * 2f64.powi(-24) / (n_i + n_t) * 2.0 * exact.sqrt() + 2f64.powi(-24);
        close(&format!("{what}, f32"), found, exact, ulps);
        // Two digits of the reflectances against air; 200 hits at the inner step leave four times 7 %.
        let digits = if exact > 1e-3 { 2 } else { 0 };
        reflected(&single, incident(n_i, 0.0), 1 << 24).is(&format!("{what}, counted"), exact, digits);
    }
}

#[test]
fn reflectance_is_that_of_sines_and_tangents_to_1e_12() {
    for (n_i, n_t) in [(1.0, 1.41), (1.41, 1.0), (1.41, 1.40), (1.38, 1.41)] {
        let model = step(n_i, n_t);
        for k in 1..900 {
            let theta_i = (0.1 * f64::from(k)).to_radians();
            let sin_t = n_i * theta_i.sin() / n_t;
            if sin_t > 0.9999 {
                continue;
            }
            // Fresnel's own forms (Born and Wolf, 1.5.2, eq. 21a), free of the momenta that the tracer uses.
            let theta_t = sin_t.asin();
            let s = ((theta_i - theta_t).sin() / (theta_i + theta_t).sin()).powi(2);
            let p = ((theta_i - theta_t).tan() / (theta_i + theta_t).tan()).powi(2);
            let r = optics::fresnel(theta_i.cos(), n_i, n_t);
            assert!((r.s - s).abs() < 1e-12 && (r.p - p).abs() < 1e-12, "{n_i} to {n_t} at {k}: {r:?}");
            let mut path = bench::path(&model, 1, [0.0, 0.0, 1.0], incident(n_i, 0.1 * f64::from(k)));
            let found = decided(&mut path, 1, 1.0);
            assert!((found - 0.5 * (s + p)).abs() < 1e-12, "{n_i} to {n_t} at {k}: {found}");
        }
    }
}

#[test]
fn reflection_at_60_degrees_and_brewster_angle_are_the_listed_ones() {
    let model = step(1.0, 1.41);
    let at = |angle| decided(&mut bench::path(&model, 1, [0.0, 0.0, 1.0], incident(1.0, angle)), 1, 1.0);
    // Half a unit of the last digit of Rs; the tracer's light is unpolarised.
    close("reflectance at 60 degrees", at(60.0), 0.5 * (0.144_340 + 0.003_171_80), 2.6e-7);
    reflected(&model.cast(), incident(1.0, 60.0), 1 << 24).is("counted at 60 degrees", 0.073_755_9, 2);
    // At Brewster's angle tan(theta) = n, only s is reflected: Rs = ((n^2 - 1)/(n^2 + 1))^2.
    let n_sq = 1.41f64 * 1.41;
    let brewster = 1.41f64.atan().to_degrees();
    close("Brewster's angle", brewster, 54.6550, 5e-5);
    close("at Brewster's angle", at(brewster), 0.5 * ((n_sq - 1.0) / (n_sq + 1.0)).powi(2), 1e-12);
    // dRp/dtheta vanishes there too: the twin's p alone, from the momenta.
    let (a, b) = (brewster.to_radians().cos(), (n_sq - 1.0 + brewster.to_radians().cos().powi(2)).sqrt());
    let s = ((a - b) / (a + b)).powi(2);
    close("p at Brewster's angle", 2.0 * cpu::fresnel::fresnel(a, b, 1.0, n_sq) - s, 0.0, 1e-15);
}
