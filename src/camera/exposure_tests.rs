use super::*;
use crate::scene::{Lens, ViewAxis};

fn camera(pixels: [u32; 2], sensor: Sensor) -> Camera {
    Camera {
        pixels,
        pixel_pitch_um: 4.65,
        view_angle_deg: 60.0,
        view_axis: ViewAxis::Width,
        distance_mm: 17.32,
        lens: Lens::Pinhole,
        sensor,
    }
}

fn quiet() -> Sensor {
    Sensor { read_noise_e: 0.0, dark_current_e_per_s: 0.0, ..Sensor::default() }
}

fn uniform(pixels: [u32; 2], radiance: f32) -> Film {
    let mean = vec![radiance; (pixels[0] * pixels[1]) as usize];
    Film { width: pixels[0], height: pixels[1], mean, ..Default::default() }
}

#[test]
fn electrons_on_the_axis_are_those_of_the_hand_calculation() {
    // L 1, f/2.8, 4.65 um, 10 ms, QE 0.47, 530 nm: 27162.93657973426 electrons by a separate Python script.
    let pixels = [3, 3];
    let e = expected_electrons(&uniform(pixels, 1.0), &camera(pixels, quiet()), 530.0).unwrap();
    assert!((e[4] / 27_162.936_579_734_26 - 1.0).abs() < 1e-12, "{}", e[4]);
}

#[test]
fn corner_falls_by_the_fourth_power_of_the_cosine_and_by_vignetting() {
    let pixels = [301, 201];
    let at_corner = |loss: f64| {
        let sensor = Sensor { vignetting_corner_loss: loss, ..quiet() };
        let e = expected_electrons(&uniform(pixels, 1.0), &camera(pixels, sensor), 530.0).unwrap();
        e[0] / e[100 * 301 + 150]
    };
    // The first pixel's centre is (150, 100) pixels from the axis, the corner (150.5, 100.5).
    let focal = 150.5 / 30f64.to_radians().tan();
    let cosine = focal / (focal * focal + 150.0 * 150.0 + 100.0 * 100.0).sqrt();
    assert!((at_corner(0.0) / cosine.powi(4) - 1.0).abs() < 1e-12);
    let kept = 1.0 - 0.3 * (150.0f64.powi(2) + 100.0f64.powi(2)) / (150.5f64.powi(2) + 100.5f64.powi(2));
    assert!((at_corner(0.3) / at_corner(0.0) / kept - 1.0).abs() < 1e-12);
}

#[test]
fn ambient_light_and_dark_current_reach_every_pixel_alike() {
    let pixels = [64, 48];
    let sensor =
        Sensor { ambient_w_per_m2_sr: 0.5, dark_current_e_per_s: 300.0, vignetting_corner_loss: 0.5, ..quiet() };
    let e = expected_electrons(&uniform(pixels, 0.0), &camera(pixels, sensor), 530.0).unwrap();
    // Half the electrons of radiance 1 (hand calculation above) and 300 e/s for 10 ms.
    let expected = 0.5 * 27_162.936_579_734_26 + 3.0;
    assert!(e.iter().all(|v| (v / expected - 1.0).abs() < 1e-12));
}

#[test]
fn grey_values_have_the_mean_and_variance_of_theory() {
    // A 16-bit sensor of 6553.5 electrons full well: 10 grey levels per electron, quantisation negligible (1/12).
    let pixels = [200, 150];
    let sensor = Sensor { full_well_e: 6553.5, bit_depth: 16, read_noise_e: 9.0, dark_current_e_per_s: 0.0, ..quiet() };
    // A view of 0.1 degree: no cos^4 law to speak of (1 - 1e-6).
    let narrow = Camera { view_angle_deg: 0.1, ..camera(pixels, sensor) };
    let film = uniform(pixels, 0.05);
    let mean_e = expected_electrons(&film, &narrow, 530.0).unwrap()[0];
    let frame = expose(&film, &narrow, 530.0, 3).unwrap();
    let n = frame.grey.len() as f64;
    let electrons: Vec<f64> = frame.grey.iter().map(|&g| f64::from(g) / 10.0).collect();
    let mean = electrons.iter().sum::<f64>() / n;
    let variance = electrons.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let theory = mean_e + 81.0 + 0.01 / 12.0;
    // Nearly normal: var(s^2) = 2 sigma^4/n; 4 standard errors.
    assert!((mean - mean_e).abs() < 4.0 * (theory / n).sqrt(), "{mean} {mean_e}");
    assert!((variance / theory - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{variance} {theory}");
}

#[test]
fn same_seed_gives_the_same_bits_on_any_number_of_threads_and_another_seed_others() {
    let pixels = [64, 48];
    let film = uniform(pixels, 0.2);
    let camera = camera(pixels, Sensor::default());
    let on = |threads: usize, seed: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| expose(&film, &camera, 530.0, seed).unwrap())
    };
    assert_eq!(on(1, 5), on(3, 5));
    assert_ne!(on(1, 5), on(1, 6));
}

#[test]
fn bright_light_saturates_at_the_top_grey_level_and_darkness_reads_the_black_level() {
    let pixels = [8, 8];
    let read = |radiance: f32, bit_depth: u32| {
        let sensor = Sensor { bit_depth, black_level: 3.0, ..quiet() };
        expose(&uniform(pixels, radiance), &camera(pixels, sensor), 530.0, 1).unwrap()
    };
    for (bits, top) in [(8, 255), (12, 4095), (16, 65_535)] {
        let bright = read(1e20, bits);
        assert_eq!(bright.top_grey(), top);
        assert!(bright.grey.iter().all(|&g| g == top));
        assert!(read(0.0, bits).grey.iter().all(|&g| g == 3));
    }
}

#[test]
fn half_the_full_well_reads_half_of_the_top_grey_level() {
    let sensor = Sensor { full_well_e: 20_000.0, bit_depth: 8, ..quiet() };
    let sum: u32 = (0..400).map(|p| u32::from(read_out(10_000.0, &sensor, &mut PixelRandom::new(1, p)))).sum();
    // 127.5 with shot noise of 1.275 grey levels and rounding 0.29 over 400 pixels: 0.065; 4 of these.
    assert!((f64::from(sum) / 400.0 - 127.5).abs() < 0.26, "{sum}");
}

#[test]
fn bad_input_is_a_typed_error_that_names_it() {
    let pixels = [4, 4];
    let film = uniform(pixels, 1.0);
    let fails = |change: fn(&mut Camera)| {
        let mut c = camera(pixels, Sensor::default());
        change(&mut c);
        expose(&film, &c, 530.0, 1).unwrap_err().to_string()
    };
    assert!(fails(|c| c.pixels = [5, 4]).contains("5 x 4"));
    assert!(fails(|c| c.sensor.f_number = 0.0).contains("f_number"));
    assert!(fails(|c| c.sensor.quantum_efficiency = 1.5).contains("quantum_efficiency"));
    assert!(fails(|c| c.sensor.bit_depth = 17).contains("bit_depth"));
    assert!(fails(|c| c.sensor.full_well_e = f64::NAN).contains("full_well_e"));
    assert!(fails(|c| c.view_angle_deg = 0.0).contains("view angle"));
    let mut bad = film.clone();
    bad.mean[6] = f32::NAN;
    let error = expose(&bad, &camera(pixels, Sensor::default()), 530.0, 1).unwrap_err();
    assert!(matches!(error, ExposureError::Radiance { column: 2, row: 1, .. }), "{error}");
}
