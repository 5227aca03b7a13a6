use super::*;
use crate::camera::noise::PixelRandom;

const W: usize = 160;
const H: usize = 120;

fn image(f: impl Fn(f64, f64) -> f64) -> GreyImage {
    let grey: Vec<f64> = (0..W * H).map(|i| f((i % W) as f64 + 0.5, (i / W) as f64 + 0.5)).collect();
    GreyImage::new(W, H, &grey, Some(255.0)).unwrap()
}

fn gaussian(peak: f64, sigma: f64, cx: f64, cy: f64) -> GreyImage {
    image(|x, y| peak * (-((x - cx).powi(2) + (y - cy).powi(2)) / (2.0 * sigma * sigma)).exp())
}

fn known(value: &Value) -> [f64; 3] {
    match value {
        Value::Known { value, low, high } => [*value, *low, *high],
        Value::Undefined { reason } => panic!("undefined: {reason}"),
    }
}

fn reason(value: &Value) -> &str {
    match value {
        Value::Known { value, .. } => panic!("known: {value}"),
        Value::Undefined { reason } => reason,
    }
}

fn point(value: &Value<[f64; 2]>) -> [f64; 2] {
    *value.best().unwrap()
}

#[test]
fn disc_at_random_places_has_twice_its_radius_as_mean_diameter_within_the_interval() {
    let radius = 23.4;
    let n = 400;
    let mut diameters = Vec::new();
    let mut inside = 0;
    for trial in 0..n {
        let mut random = PixelRandom::new(1, trial);
        let (cx, cy) = (80.0 + random.uniform(), 60.0 + random.uniform());
        let disc = image(|x, y| if (x - cx).hypot(y - cy) < radius { 200.0 } else { 0.0 });
        let [d, low, high] = known(&estimate(&disc, &Settings::default()).diameter_px);
        diameters.push(d);
        inside += usize::from(low <= 2.0 * radius && 2.0 * radius <= high);
    }
    let mean = diameters.iter().sum::<f64>() / f64::from(n);
    let variance = diameters.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / f64::from(n - 1);
    // 4 standard errors; the square root's own bias, variance/(2 d), is 2e-5 px.
    assert!((mean - 2.0 * radius).abs() < 4.0 * (variance / f64::from(n)).sqrt(), "{mean}");
    // Intervals of two (slightly generous) standard deviations: 95 % and more, less 4 sqrt(0.95 * 0.05 / n).
    assert!(inside as f64 > (0.95 - 0.044) * f64::from(n), "{inside} of {n}");
}

#[test]
fn diameter_of_a_gaussian_is_that_of_its_level_line() {
    for (peak, sigma) in [(200.0, 12.0), (40.0, 15.0), (100.0, 8.0)] {
        let [d, low, high] = known(&estimate(&gaussian(peak, sigma, 79.3, 60.6), &Settings::default()).diameter_px);
        let theory = 2.0 * sigma * (2.0f64 * (peak / 5.0f64).ln()).sqrt();
        // Two rms errors of counting the edge's pixels.
        let (_, error) = equivalent_diameter((PI * theory * theory / 4.0) as usize);
        assert!((d - theory).abs() < error, "{d} {theory}");
        // The level lines at k + 1 and k - 1 lie inside the interval.
        let at = |k: f64| 2.0 * sigma * (2.0f64 * (peak / k).ln()).sqrt();
        assert!(low < at(6.0) + 1e-9 && high > at(4.0) - 1e-9, "{low} {high}");
    }
}

#[test]
fn size_grows_with_brightness() {
    let d = |peak: f64| known(&estimate(&gaussian(peak, 12.0, 80.0, 60.0), &Settings::default()).diameter_px)[0];
    assert!(d(200.0) > 1.2 * d(50.0));
}

#[test]
fn centroid_of_an_unclipped_gaussian_is_exact_to_a_millionth_of_a_pixel() {
    // Cut at 7 sigma (2e-11 of the peak) and sampled at 7 points per sigma (aliasing e^-(2 pi^2 49)): both far below
    // 1e-6.
    for (cx, cy) in [(80.0, 60.0), (77.123, 62.877), (83.5, 57.25)] {
        let got = estimate(&gaussian(180.0, 7.0, cx, cy), &Settings::default());
        let [x, y] = point(&got.centroid_px);
        assert!((x - cx).abs() < 1e-6 && (y - cy).abs() < 1e-6, "{x} {y}");
        // Bilinear interpolation of a Gaussian falls short by at most (1/8 + 1/8) / sigma^2 of the peak.
        let h = known(&got.h_grey)[0];
        assert!(h <= 180.0 && h > 180.0 * (1.0 - 0.25 / 49.0), "{h}");
    }
}

#[test]
fn uniform_background_pulls_the_centroid_to_the_middle_by_its_share() {
    let (cx, cy, base) = (50.0, 50.0, 2.0);
    let blob = gaussian(150.0, 6.0, cx, cy);
    let sum = known(&estimate(&blob, &Settings::default()).sum_grey)[0];
    let with = image(|x, y| base + blob.at([x, y]));
    let [x, y] = point(&estimate(&with, &Settings::default()).centroid_px);
    let share = base * (W * H) as f64 / (sum + base * (W * H) as f64);
    // Weighted mean of the blob's centre and the image's; the Gaussian's centre is exact to 1e-6.
    assert!((x - (cx + share * (80.0 - cx))).abs() < 1e-6, "{x}");
    assert!((y - (cy + share * (60.0 - cy))).abs() < 1e-6, "{y}");
}

#[test]
fn centroid_interval_covers_noise_95_percent_of_the_time() {
    let (n, noise) = (200, 1.5);
    let clean = gaussian(120.0, 9.0, 70.0, 55.0);
    let settings = Settings { noise_grey: noise, ..Settings::default() };
    let mut inside = 0;
    for trial in 0..n {
        let mut random = PixelRandom::new(trial, 0);
        let noisy: Vec<f64> = clean.grey().iter().map(|v| v + noise * random.normal()).collect();
        let noisy = GreyImage::new(W, H, &noisy, None).unwrap();
        if let Value::Known { low, high, .. } = estimate(&noisy, &settings).centroid_px {
            inside += usize::from(low[0] < 70.0 && 70.0 < high[0]);
        }
    }
    // Two standard deviations: 95.4 % of 200, less 4 binomial standard deviations (3.0).
    assert!((179..200).contains(&inside), "{inside}");
}

#[test]
fn reference_frame_removes_a_background_and_kept_negatives_leave_the_centroid_alone() {
    let noisy = |seed: u32, with_blob: bool| {
        let mut random = PixelRandom::new(seed, 0);
        let blob = gaussian(if with_blob { 150.0 } else { 0.0 }, 6.0, 50.0, 50.0);
        let grey: Vec<f64> = blob.grey().iter().map(|v| v + 20.0 + 0.5 * random.normal()).collect();
        GreyImage::new(W, H, &grey, Some(255.0)).unwrap()
    };
    let difference = noisy(1, true).minus(&noisy(2, false)).unwrap();
    let settings = Settings { noise_grey: 0.5f64.sqrt(), ..Settings::default() };
    let Value::Known { value, low, high } = estimate(&difference, &settings).centroid_px else { panic!("undefined") };
    // The interval is two standard deviations; twice that for a single draw.
    for axis in 0..2 {
        assert!((value[axis] - 50.0).abs() < high[axis] - low[axis], "{value:?}");
    }
    let clamped: Vec<f64> = difference.grey().iter().map(|v| v.max(0.0)).collect();
    let clamped = estimate(&GreyImage::new(W, H, &clamped, None).unwrap(), &settings);
    assert!(point(&clamped.centroid_px)[0] > high[0] + 1.0, "clamping would pull the centroid");
}

#[test]
fn blank_image_is_undefined_everywhere_but_in_its_sum() {
    let blank = estimate(&image(|_, _| 0.0), &Settings::default());
    assert_eq!(blank.diameter_px.best(), None);
    assert_eq!(blank.centroid_px.best(), None);
    assert_eq!(blank.h_grey.best(), None);
    assert_eq!(blank.sum_grey.best(), Some(&0.0));
    let json = serde_json::to_string(&blank).unwrap();
    assert!(json.contains("blank") && !json.contains("null"), "{json}");
}

#[test]
fn image_darker_than_its_reference_has_no_centroid() {
    let darker = image(|_, _| 3.0).minus(&image(|_, _| 5.0)).unwrap();
    assert_eq!(estimate(&darker, &Settings::default()).centroid_px.best(), None);
}

#[test]
fn saturated_pixels_are_counted_and_named() {
    let saturated = estimate(&image(|x, _| if x < 10.0 { 255.0 } else { 1.0 }), &Settings::default());
    assert_eq!(saturated.saturated_pixels, 10 * H);
    assert!(saturated.warnings[0].contains("1200 of 19200"), "{:?}", saturated.warnings);
    assert_eq!(saturated.max_grey, 255.0);
}

#[test]
fn depth_indicator_is_undefined_where_the_centroid_saturates() {
    let blob = |peak: f64, top: f64| {
        let clipped: Vec<f64> = gaussian(peak, 12.0, 80.0, 60.0).grey().iter().map(|v| v.min(top)).collect();
        GreyImage::new(W, H, &clipped, Some(top)).unwrap()
    };
    let h = |image: &GreyImage| estimate(image, &Settings::default()).h_grey;
    assert!(reason(&h(&blob(300.0, 255.0))).contains("255 grey levels or more"));
    assert!(known(&h(&blob(200.0, 255.0)))[0] > 199.0);
    // A frame without inclusions taken off does not make it known.
    let less = blob(300.0, 255.0).minus(&blob(50.0, 255.0)).unwrap();
    assert!(reason(&h(&less)).contains("205 grey levels or more"), "{:?}", h(&less));
}

#[test]
fn single_lit_pixel_has_a_size_and_an_interval_down_to_zero() {
    let single = image(|x, y| if x == 9.5 && y == 9.5 { 5.5 } else { 0.0 });
    let [d, low, high] = known(&estimate(&single, &Settings::default()).diameter_px);
    assert!((d - 2.0 / PI.sqrt()).abs() < 1e-12);
    assert!(low == 0.0 && high > d);
}
