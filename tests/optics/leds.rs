//! LEDs: patterns, cut-off cones, power against radiance, tabulated lamps.

use crate::bench::{self, close};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use tirtouch::scene::{Input, LoadedScene, Pattern, Wall, read_ies};
use tirtouch::trace::cpu::{End, Path};
use tirtouch::trace::model::Real;

/// One LED at +x, bonded to a layer of air.
fn lamp(pattern: Pattern, cutoff_half_angle_deg: Option<f64>) -> LoadedScene {
    let mut loaded = bench::stack(&[[12.0, 1.0]]);
    loaded.scene.led.truncate(1);
    let led = &mut loaded.scene.led[0];
    (led.pattern, led.cutoff_half_angle_deg) = (pattern, cutoff_half_angle_deg);
    loaded
}

/// Intensity of the LED at +x, relative to its radiance, in a direction out of its disc: what a camera path against
/// that direction finds there, times the cosine.
fn intensity(path: &mut Path<f64>, theta: f64, phi: f64) -> f64 {
    // Out of the disc is -x; phi runs from z towards y.
    let d = [-theta.cos(), theta.sin() * phi.sin(), theta.sin() * phi.cos()];
    bench::put(path, 1, [15.0, 0.0, 6.0], d.map(|v| -v));
    path.wall = Wall::PlusX;
    path.light_at_end(End::Wall) * theta.cos()
}

/// Squared sine to the disc's normal and azimuth (turns, from z towards y) of launched light.
fn launched<T: Real>(path: &mut Path<T>) -> (f64, f64) {
    path.launch();
    let (y, z) = (path.p.y.wide(), path.p.z.wide());
    (y * y + z * z, (y.atan2(z) / TAU + 1.0).fract())
}

#[test]
fn intensity_at_the_half_power_angle_is_half_of_that_on_the_axis() {
    for (half_power_deg, m, photons, digits) in
        [(60.0, 1.0, 1 << 20, 2), (30.0, 4.82, 1 << 24, 3), (15.0, 20.0, 1 << 20, 2)]
    {
        let model = bench::model(&lamp(Pattern::CosinePower { half_power_deg }, None));
        let mut path = bench::path(&model, 1, [0.0; 3], [0.0; 3]);
        let axis = intensity(&mut path, 0.0, 0.0);
        let half = intensity(&mut path, half_power_deg.to_radians(), 0.7);
        // The twin takes the power of a cosine; its square root of rounding is nowhere in sight.
        close("half-power", half / axis, 0.5, 1e-12);
        close("exponent, listed", model.leds[0].exponent, m, 0.05);
        // Launched light follows it: the share within an angle is 1 - cos^(m + 1).
        let within = 1.0 - half_power_deg.to_radians().cos().powf(model.leds[0].exponent + 1.0);
        let limit = half_power_deg.to_radians().sin().powi(2);
        bench::count(&model.cast::<f32>(), 20, photons, |path| launched(path).0 < limit).is(
            "within it",
            within,
            digits,
        );
    }
}

#[test]
fn launched_light_follows_the_power_of_the_cosine_in_every_azimuth_up_to_the_cut_off() {
    let cutoff = 50f64.to_radians();
    let model = bench::model(&lamp(Pattern::CosinePower { half_power_deg: 30.0 }, Some(50.0)));
    let m = model.leds[0].exponent;
    let single = model.cast::<f32>();
    let mut path = bench::path(&single, 1, [0.0; 3], [0.0; 3]);
    let n = 1 << 19;
    let found: Vec<(f64, f64)> = (0..n)
        .map(|k| {
            path.start_random(21, k, 0);
            launched(&mut path)
        })
        .collect();
    let cone = 1.0 - cutoff.cos().powf(m + 1.0);
    let cosines: Vec<f64> = found.iter().map(|(sin_sq, _)| 1.0 - (1.0 - sin_sq).powf(0.5 * (m + 1.0))).collect();
    // sin^2 of 0.6 is rounded to 2^-24 a few times.
    let widest = found.iter().map(|f| f.0).fold(0.0, f64::max);
    assert!(widest < cutoff.sin().powi(2) + 1e-6 && widest > cutoff.sin().powi(2) - 1e-4, "{widest}");
    bench::kolmogorov("cosines", cosines, |v| v / cone);
    let mut turns = [0.0; 64];
    found.iter().for_each(|f| turns[(f.1 * 64.0) as usize % 64] += 1.0);
    bench::chi_square("azimuths", &turns, &[f64::from(n) / 64.0; 64]);
    let mut path = bench::path(&model, 1, [0.0; 3], [0.0; 3]);
    assert!(intensity(&mut path, cutoff - 1e-9, 0.1) > 0.0);
    assert_eq!(intensity(&mut path, cutoff + 1e-9, 0.1), 0.0);
}

/// Integral of what camera paths find over the disc's hemisphere, per unit of its area and radiance.
fn projected(path: &mut Path<f64>, steps: u32) -> f64 {
    let mid = |k: u32| (f64::from(k) + 0.5) / f64::from(steps);
    let ring = |theta: f64, path: &mut Path<f64>| -> f64 {
        (0..steps).map(|j| intensity(path, theta, TAU * mid(j))).sum::<f64>() * TAU / f64::from(steps)
    };
    (0..steps)
        .map(|k| {
            let theta = FRAC_PI_2 * mid(k);
            ring(theta, path) * theta.sin() * FRAC_PI_2 / f64::from(steps)
        })
        .sum()
}

#[test]
fn power_and_radiance_agree() {
    // P = L A 2 pi (1 - cos^(m + 1)) / (m + 1), which is pi L A sin^2 for a Lambertian disc.
    for (pattern, m, cutoff) in [
        (Pattern::Lambertian, 1.0, 90.0f64),
        (Pattern::Lambertian, 1.0, 71.989),
        (Pattern::CosinePower { half_power_deg: 30.0 }, -(2f64.ln()) / 30f64.to_radians().cos().ln(), 45.0),
    ] {
        let mut loaded = lamp(pattern, (cutoff < 90.0).then_some(cutoff));
        let area = PI * 1.5 * 1.5;
        let per_radiance = TAU * (1.0 - cutoff.to_radians().cos().powf(m + 1.0)) / (m + 1.0) * area;
        loaded.scene.led[0].radiance_w_per_m2_sr = Some(100.0);
        let by_radiance = bench::model(&loaded);
        // uW: 1 W/(m^2 sr) times 1 mm^2.
        let power = 100.0 * per_radiance;
        close("power", by_radiance.power * by_radiance.unit_radiance / power, 1.0, 1e-12);
        loaded.scene.led[0].radiance_w_per_m2_sr = None;
        loaded.scene.led[0].power_mw = Some(1e-3 * power);
        let by_power = bench::model(&loaded);
        close("radiance", by_power.unit_radiance / 100.0, 1.0, 1e-12);
        // What camera paths find adds up to it; the ring that the cut-off cuts through is 1/400 of the sum's range.
        let sum = projected(&mut bench::path(&by_power, 1, [0.0; 3], [0.0; 3]), 400) * area;
        close("found by camera paths", sum / per_radiance, 1.0, 4e-3);
    }
}

/// A lamp brighter towards one side, dark at 90 degrees: cos^2 (1 + 0.5 sin cos phi), every 2.5 and 7.5 degrees.
fn lamp_file() -> String {
    let vertical: Vec<f64> = (0..=36).map(|k| 2.5 * f64::from(k)).collect();
    let horizontal: Vec<f64> = (0..=48).map(|k| 7.5 * f64::from(k)).collect();
    let words = |values: &[f64]| values.iter().map(|v| format!("{v:.6}")).collect::<Vec<_>>().join("\n");
    let mut text = format!(
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {} {} 1 2 0 0 0\n1 1 0\n{}\n{}\n",
        vertical.len(),
        horizontal.len(),
        words(&vertical),
        words(&horizontal)
    );
    for phi in &horizontal {
        let value = |t: &f64| {
            let (sin, cos) = t.to_radians().sin_cos();
            100.0 * cos.max(0.0).powi(2) * (1.0 + 0.5 * sin * phi.to_radians().cos())
        };
        text += &words(&vertical.iter().map(value).collect::<Vec<_>>());
        text.push('\n');
    }
    text
}

#[test]
fn a_tabulated_lamp_launches_what_its_table_says_and_is_seen_as_bright() {
    let file = Input::new("lamp.ies", lamp_file().as_bytes());
    let table = read_ies(&file).unwrap();
    let mut loaded = lamp(Pattern::Ies { file: file.path.clone() }, None);
    loaded.files.insert(file.path, file.bytes);
    loaded.scene.led[0].radiance_w_per_m2_sr = None;
    loaded.scene.led[0].power_mw = Some(2.0);
    let model = bench::model(&loaded);

    // Flux into 8 x 8 cells of equal projected solid angle, straight from the file: I d(omega), with
    // d(omega) = d(sin^2) d(phi) / (2 cos), by 64 x 64 midpoints in each.
    let inner = 64;
    let fine = |k: u32, j: u32| (f64::from(k) + (f64::from(j) + 0.5) / f64::from(inner)) / 8.0;
    let mut expected = Vec::new();
    for row in 0..8 {
        for column in 0..8 {
            let cell: f64 = (0..inner * inner)
                .map(|k| {
                    let (sin_sq, turn) = (fine(row, k / inner), fine(column, k % inner));
                    table.intensity(sin_sq.sqrt().asin().to_degrees(), 360.0 * turn) / (1.0 - sin_sq).sqrt()
                })
                .sum();
            expected.push(cell);
        }
    }
    // Launched light has the table's shape. The tracer's table has 8 x 8 entries in each cell, taken at their middle:
    // that is off by some 1e-4, and the standard errors of 2^20 photons in 64 cells are 0.8 %.
    let n = 1u64 << 20;
    let single = model.cast::<f32>();
    let mut counts = vec![0.0; 64];
    let mut path = bench::path(&single, 1, [0.0; 3], [0.0; 3]);
    for k in 0..n {
        path.start_random(22, k as u32, 0);
        let (sin_sq, turn) = launched(&mut path);
        counts[(sin_sq * 8.0) as usize % 8 * 8 + (turn * 8.0) as usize % 8] += 1.0;
    }
    let total: f64 = expected.iter().sum();
    let expected: Vec<f64> = expected.iter().map(|e| e / total * n as f64).collect();
    bench::chi_square("table", &counts, &expected);

    // Seen by camera paths it has the same power, and the file's intensity to the width of a cell of the table.
    let mut path = bench::path(&model, 1, [0.0; 3], [0.0; 3]);
    let sum = projected(&mut path, 400) * PI * 1.5 * 1.5 * model.unit_radiance;
    close("power found by camera paths", sum / 2e3, 1.0, 2e-3);
    for (theta, phi) in [(20.0, 0.0), (40.0, 0.0), (40.0, 90.0), (40.0, 180.0), (60.0, 45.0)] {
        // All of the intensity, its integral over the directions, is 2 mW off the disc's area.
        let whole = PI * total / 512f64.powi(2) * PI * 1.5 * 1.5;
        let exact = table.intensity(theta, phi) * 2e3 / whole / model.unit_radiance;
        let found = intensity(&mut path, f64::to_radians(theta), f64::to_radians(phi));
        close(&format!("intensity at {theta}, {phi}"), found, exact, 0.03);
    }
}
