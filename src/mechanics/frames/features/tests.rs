use super::*;

/// Frames from -8 to 8 mm in steps of 0.25 mm at the given positions.
fn scan(positions: &[f64], pressure: &dyn Fn(f64, f64) -> f64) -> Frames {
    let x_mm: Vec<f64> = (-32..=32).map(|i| 0.25 * f64::from(i)).collect();
    let frame = |&position_mm: &f64| Frame {
        position_mm,
        pressure_kpa: x_mm.iter().map(|&x| pressure(position_mm, x)).collect(),
        x_mm: x_mm.clone(),
    };
    Frames::new(positions.iter().map(frame).collect()).unwrap()
}

fn one(pressure: &dyn Fn(f64) -> f64, settings: &Settings) -> Features {
    features(&scan(&[0.0], &|_, x| pressure(x)), Reference::Farthest, settings).unwrap().remove(0)
}

fn close(feature: &Figure, expected: f64) {
    let value = feature.value().unwrap();
    // Rounding of 65 samples in sums of a few kPa.
    assert!((value - expected).abs() < 1e-11, "{value} {expected}");
}

#[test]
fn a_parabola_cut_off_by_the_array_gives_its_peak_base_and_width() {
    let f = one(&|x| 9.0 - 0.1 * (x - 0.5) * (x - 0.5), &Settings::default());
    close(&f.peak_kpa, 9.0);
    close(&f.center_mm, 0.5);
    // Edges: 9 - 0.1 * 8.5^2 and 9 - 0.1 * 7.5^2.
    let base = 9.0 - 0.05 * (8.5 * 8.5 + 7.5 * 7.5);
    close(&f.base_kpa, base);
    // Half of the peak at a distance w of it: 0.1 w^2 = 9 / 2.
    close(&f.fwhm_mm, 2.0 * 45f64.sqrt());
    assert_eq!(f.eccentricity, Figure::Known(0.0));
}

#[test]
fn a_free_contact_edge_has_no_pressure() {
    let f = one(&|x| (4.0 - 0.16 * x * x).max(0.0), &Settings::default());
    close(&f.base_kpa, 0.0);
    close(&f.peak_kpa, 4.0);
    // Contact radius 5, half height at 5 / sqrt(2).
    close(&f.fwhm_mm, 10.0 / 2f64.sqrt());
    // 4.75 is the last place with pressure.
    assert_eq!(f.parabola.unwrap().window_mm, [-4.75, 4.75]);
}

#[test]
fn a_window_inside_the_contact_takes_its_base_at_its_ends() {
    // A quarter of a sample beyond a place: the raw frame is linear there.
    let settings = Settings { window_mm: Some(3.0625), ..Settings::default() };
    let f = one(&|x| (4.0 - 0.16 * x * x).max(0.0), &settings);
    close(&f.base_kpa, 0.75 * (4.0 - 0.16 * 9.0) + 0.25 * (4.0 - 0.16 * 3.25 * 3.25));
    assert_eq!(f.parabola.unwrap().window_mm, [-3.0, 3.0]);
    // A window larger than the contact has free edges.
    let wide = Settings { window_mm: Some(6.0), ..Settings::default() };
    close(&one(&|x| (4.0 - 0.16 * x * x).max(0.0), &wide).base_kpa, 0.0);
}

#[test]
fn the_width_at_half_of_the_peak_tells_shapes_apart() {
    // A parabola and a steeper one, both cut off by the window: above a base at its ends both would be sqrt(2) half
    // windows.
    let settings = Settings { window_mm: Some(4.0), ..Settings::default() };
    let width = |bend: f64| one(&|x| 8.0 - bend * x * x, &settings).fwhm_mm;
    close(&width(0.1), 2.0 * 40f64.sqrt());
    close(&width(0.4), 40f64.sqrt());
}

#[test]
fn frames_without_a_feature_say_why() {
    let settings = Settings::default();
    let reason = |feature: &Figure| feature.reason().unwrap().to_owned();
    let uniform = one(&|_| 3.0, &settings);
    assert_eq!(reason(&uniform.peak_kpa), "the fitted parabola has no peak");
    assert_eq!(reason(&uniform.fwhm_mm), "the fitted parabola has no peak");
    close(&uniform.base_kpa, 3.0);
    let untouched = one(&|_| 0.0, &settings);
    assert_eq!(reason(&untouched.base_kpa), "there is no contact");
    assert_eq!(reason(&untouched.peak_kpa), "there is no contact");
    let hollow = one(&|x| 1.0 + x * x, &settings);
    assert_eq!(reason(&hollow.peak_kpa), "the fitted parabola has no peak");
    let ramp = one(&|x| 20.0 + x - 0.001 * x * x, &settings);
    assert_eq!(reason(&ramp.center_mm), "the fitted parabola peaks outside its window");
    let spike = one(&|x| if x.abs() < 0.3 { 1.0 } else { 0.0 }, &settings);
    // Three places of equal pressure.
    assert_eq!(reason(&spike.peak_kpa), "the fitted parabola has no peak");
    let point = one(&|x| if x == 0.0 { 1.0 } else { 0.0 }, &settings);
    assert_eq!(reason(&point.peak_kpa), "fewer than three places of contact lie in the window");
    let horned = one(&|x| if x.abs() > 7.9 { 9.0 } else { 2.0 - 0.01 * x * x }, &settings);
    assert_eq!(reason(&horned.fwhm_mm), "the fitted parabola has no peak");
}

#[test]
fn eccentricity_is_that_of_what_the_inclusion_adds() {
    let homogeneous = |_: f64, x: f64| 5.0 - 0.05 * x * x + 0.2 * x;
    let positions = [-10.0, 0.0, 4.0];
    let with = scan(&positions, &|at, x| homogeneous(at, x) + if at == 4.0 { -0.03 * x } else { 0.0 });
    let without = scan(&positions, &homogeneous);
    let e = |frames: &Frames, reference| -> Vec<f64> {
        let all = features(frames, reference, &Settings::default()).unwrap();
        all.iter().map(|f| f.eccentricity.value().unwrap()).collect()
    };
    for found in [e(&with, Reference::Without(&without)), e(&with, Reference::Farthest)] {
        assert!(found[0] == 0.0 && found[1] == 0.0 && (found[2] + 1.0).abs() < 1e-12, "{found:?}");
    }
    let elsewhere = scan(&[-10.0, 0.0, 5.0], &homogeneous);
    let error = features(&with, Reference::Without(&elsewhere), &Settings::default()).unwrap_err();
    assert_eq!(error.frame, 2);
    let fewer = scan(&positions[..2], &homogeneous);
    assert!(features(&with, Reference::Without(&fewer), &Settings::default()).is_err());
    assert!(features(&fewer, Reference::Without(&with), &Settings::default()).is_err());
}

#[test]
fn noise_below_the_threshold_is_no_contact() {
    let noisy = |x: f64| (4.0 - 0.16 * x * x).max(0.01 * (x * 40.0).sin());
    let settings = Settings { contact_above_kpa: 0.02, ..Settings::default() };
    close(&one(&noisy, &settings).fwhm_mm, 10.0 / 2f64.sqrt());
    let fooled = one(&noisy, &Settings::default());
    assert!((fooled.fwhm_mm.value().unwrap() - 10.0 / 2f64.sqrt()).abs() > 0.5, "the threshold matters");
}

#[test]
fn frames_that_do_not_belong_together_are_refused() {
    let frame =
        |position_mm, x_mm: &[f64]| Frame { position_mm, x_mm: x_mm.to_vec(), pressure_kpa: vec![1.0; x_mm.len()] };
    let rule = |frames: Vec<Frame>| Frames::new(frames).unwrap_err();
    assert!(rule(vec![]).rule.contains("one at least"));
    assert!(rule(vec![frame(0.0, &[0.0])]).rule.contains("two places"));
    assert!(rule(vec![frame(0.0, &[0.0, 0.0])]).rule.contains("places must ascend"));
    assert!(rule(vec![frame(f64::NAN, &[0.0, 1.0])]).rule.contains("finite"));
    let second = rule(vec![frame(0.0, &[0.0, 1.0]), frame(1.0, &[0.0, 2.0])]);
    assert_eq!(second.to_string(), "frame 1, counted from 0: places must be those of the first frame");
    assert!(rule(vec![frame(1.0, &[0.0, 1.0]), frame(1.0, &[0.0, 1.0])]).rule.contains("positions must ascend"));
}
