//! Radiance over n^2 is the same everywhere in a lossless enclosure; and what a Lambertian disc sends along its axis.

use crate::beams::covered;
use crate::bench::{self, Share, close};
use std::f64::consts::PI;
use tirtouch::scene::{Mount, Walls};
use tirtouch::trace::cpu::{End, Path, vec3::V3};
use tirtouch::trace::model::Real;

/// Tissue of albedo 1 mixes all directions, so no light is trapped for ever.
fn walk_through<T: Real>(path: &mut Path<T>) -> End {
    loop {
        let mut end = path.walk();
        if end == End::Touch {
            let r = path.boundary(path.o.x, path.o.y, path.p.dot(path.normal).abs()).mixed;
            end = if path.draw() < r {
                path.p.z = -path.p.z;
                End::GoesOn
            } else {
                path.tissue_walk(path.model.tissue.as_ref().unwrap().cosine(path.p.dot(path.normal).abs()))
            };
        }
        if end != End::GoesOn {
            return end;
        }
    }
}

/// Share of the directions in a box of index n that all its sides reflect totally: its upper one against `above`, the
/// others against air. None that comes from outside gets there, nor leaves. Of directions that lean by z to the plane
/// those are left whose parts along both other axes, cos and sin times s = sqrt(1 - z^2), stay below
/// a = sqrt(1 - 1/n^2).
fn held(n: f64, above: f64) -> f64 {
    const STEPS: usize = 10_000;
    let [most, flattest] = [1.0, above].map(|other| (1.0 - (other / n).powi(2)).max(0.0).sqrt());
    let at = |k: usize| {
        let z = flattest * (k as f64 + 0.5) / STEPS as f64;
        let beyond = (most / (1.0 - z * z).sqrt()).min(1.0).acos();
        (1.0 - 4.0 / PI * beyond).max(0.0)
    };
    flattest * (0..STEPS).map(at).sum::<f64>() / STEPS as f64
}

/// A lossless body of volume V_k in layers of index n_k, in the uniform radiance L of air outside, holds n_k^2 L in
/// each layer. So the light that goes in, pi L times the surface, runs 4 pi n_k^2 L V_k mm in layer k: the mean length
/// of a path there is 4 n_k^2 V_k over the surface, whatever scatters it (Blanco and Fournier 2003 for n = 1). This is
/// Fresnel, refraction, total reflection, walls and tissue in one number; a face that reflects 1 % more from one side
/// than from the other moves it by 1 %. The lowest layer holds 1.8 % less, in directions that nothing mixes.
#[test]
fn uniform_light_from_outside_fills_each_layer_with_n_squared_times_its_radiance() {
    let [width, depth] = [5.0, 4.0];
    let layers = [[1.0, 1.41], [1.5, 1.2], [1.0, 1.38]];
    let height: f64 = layers.iter().map(|l| l[0]).sum();
    for measured in 0..layers.len() {
        let mut loaded = bench::stack(&layers);
        loaded.scene.stack.footprint_mm = [width, depth];
        loaded.scene.stack.walls = Walls::Clear;
        // Too little to bring on Russian roulette; the length is read back from the weight.
        let mu = 1e-4;
        loaded.scene.stack.layer[measured].absorption_per_mm = mu;
        covered(&mut loaded, 1.45, 1.0);
        let mut diameter = 0.0;
        for led in &mut loaded.scene.led {
            // A disc in air that covers the wall.
            diameter = width.max(depth).hypot(height);
            (led.mount, led.height_mm, led.diameter_mm) = (Mount::Air { gap_mm: 0.0 }, 0.5 * height, diameter);
        }
        let model = bench::model(&loaded);
        // Each trial sends one path in through the bottom and one from an LED through a wall; those of its disc that
        // lie beside the wall do not count. Each is weighted by the area it stands for.
        let discs = 4.0 * PI * 0.25 * diameter * diameter;
        let n = 1u64 << 19;
        let [sum, squares] = bench::sums(&model, 11, n, |path| {
            let length = |path: &Path<f64>| -path.weight.ln() / mu;
            let (u, v) = (path.draw(), path.draw());
            let (sin_sq, turn) = (path.draw(), 2.0 * PI * path.draw());
            let p = [sin_sq.sqrt() * turn.cos(), sin_sq.sqrt() * turn.sin(), (1.0 - sin_sq).sqrt()];
            bench::put(path, 0, [width * (u - 0.5), depth * (v - 0.5), 0.0], p);
            let mut total = 0.0;
            if path.meet(0, V3::up(), 1.0) {
                path.layer = 1;
                assert!(matches!(walk_through(path), End::Bottom | End::Sides));
                total += width * depth * length(path);
            }
            if path.launch() == End::GoesOn {
                assert!(matches!(walk_through(path), End::Bottom | End::Sides));
                total += discs * length(path);
            }
            [total, total * total]
        });
        let mean = sum / n as f64;
        let four = 4.0 * ((squares / n as f64 - mean * mean) / n as f64).sqrt();
        let [thickness, index] = layers[measured];
        // Tissue mixes all directions of the first layer; the second is optically thinner than its neighbours.
        let held = if measured == 2 { held(index, layers[1][1]) } else { 0.0 };
        let exact = 4.0 * index * index * width * depth * thickness * (1.0 - held);
        // 4 standard errors are to stay below 1 %.
        assert!(four < 0.01 * exact, "{four} of {exact}");
        close(&format!("mean length in layer {measured}"), mean, exact, four);
    }
}

#[test]
fn a_lossless_path_keeps_its_weight_over_ten_thousand_bounces() {
    let model = bench::model(&bench::stack(&[[2.0, 1.41], [3.0, 1.40], [5.0, 1.39], [2.0, 1.38]])).cast::<f32>();
    let mut model = model;
    (model.walls, model.wall_reflectance) = (tirtouch::trace::model::Walls::Mirror, 1.0);
    model.leds.clear();
    let mut path = bench::path(&model, 4, [0.1, 0.2, 11.0], [1.0, 0.3, 0.9475]);
    let s = |path: &Path<f32>| f64::from(path.p.x).hypot(f64::from(path.p.y));
    let before = s(&path);
    path.limits.event_cap = 10_000;
    assert_eq!(path.walk(), End::Cap);
    assert_eq!(path.weight, 1.0);
    // Flat faces leave the momentum along the stack alone: the invariant does not drift at all.
    assert_eq!(s(&path), before);
}

/// Light launched by an LED in air, as a share, within a disc of radius `target` on its axis at distance `z`.
fn on_axis(radius: f64, target: f64, z: f64, n: u64) -> Share {
    let mut loaded = bench::stack(&[[30.0, 1.0]]);
    loaded.scene.led.truncate(1);
    (loaded.scene.led[0].diameter_mm, loaded.scene.led[0].height_mm) = (2.0 * radius, 15.0);
    let model = bench::model(&loaded).cast::<f32>();
    bench::count(&model, 12, n, |path| {
        path.launch();
        // At +x: light goes towards -x.
        let t = -z as f32 / path.p.x;
        let (y, height) = (path.o.y + path.p.y * t, path.o.z + path.p.z * t - 15.0);
        f64::from(y).hypot(f64::from(height)) < target
    })
}

#[test]
fn a_lambertian_disc_irradiates_its_axis_by_pi_l_r_squared_over_r_squared_plus_z_squared() {
    let (radius, z) = (1.5f64, 2.0f64);
    let share = radius * radius / (radius * radius + z * z);
    // The irradiance over pi L on the axis is the share that a small disc there would send to the large one, and that
    // share is found to three digits.
    on_axis(1e-3, radius, z, 1 << 24).is("small disc to large", share, 3);
    // The other way round, onto a target of a quarter of the distance: E times its area over the power pi L pi R^2,
    // which the exact form for coaxial discs falls short of by 3 %.
    let target = 0.25 * z;
    let [r1, r2] = [radius / z, target / z];
    let x = 1.0 + (1.0 + r2 * r2) / (r1 * r1);
    let exact = 0.5 * (x - (x * x - 4.0 * (r2 / r1).powi(2)).sqrt());
    close("small target", share * (target / radius).powi(2) / exact, 1.0, 0.03);
    on_axis(radius, target, z, 1 << 24).is("large disc to small", exact, 2);
}
