use super::*;
use crate::scene::{Lens, Sensor};

/// The paper's stack with the camera of the peer scene: 60 degrees across 1392 x 1042 pixels, pinhole 17.32 mm below.
const PAPER: [(f64, f64); 4] = [(1.41, 2.0), (1.40, 3.0), (1.39, 5.0), (1.38, 2.0)];

fn camera(view_axis: ViewAxis) -> Camera {
    Camera {
        pixels: [1392, 1042],
        pixel_pitch_um: 4.65,
        view_angle_deg: 60.0,
        view_axis,
        distance_mm: 17.32,
        lens: Lens::Pinhole,
        sensor: Sensor::default(),
    }
}

fn paper_view() -> View {
    View::new(&camera(ViewAxis::Width), &PAPER, 1.0).unwrap()
}

#[test]
fn scale_on_the_axis_is_the_reduced_distance_over_the_focal_length() {
    // D + sum d/n, each layer seen at its reduced thickness.
    let reduced = 17.32 + 2.0 / 1.41 + 3.0 / 1.40 + 5.0 / 1.39 + 2.0 / 1.38;
    let focal = 696.0 / 30f64.to_radians().tan();
    let got = mm_per_pixel(&camera(ViewAxis::Width), &PAPER, 1.0).unwrap();
    assert!((got / (reduced / focal) - 1.0).abs() < 1e-14, "{got}");
}

#[test]
fn scale_shrinks_by_2_4_percent_to_the_edge_and_3_5_percent_to_the_corner() {
    // Distance on the face over distance in the image against the axis. 2.398 % and 3.534 % come from a separate
    // Python script of r(s); their last digit is good to 5e-6.
    let view = paper_view();
    let loss = |pixel: [f64; 2]| {
        let [x, y] = view.touched_from_pixel(pixel).unwrap();
        let radius_px = (pixel[0] - 696.0).hypot(pixel[1] - 521.0);
        1.0 - x.hypot(y) / radius_px / view.mm_per_pixel()
    };
    assert!((loss([1392.0, 521.0]) - 0.02398).abs() < 1e-5, "{}", loss([1392.0, 521.0]));
    assert!((loss([1392.0, 0.0]) - 0.03534).abs() < 1e-5, "{}", loss([1392.0, 0.0]));
}

#[test]
fn local_radial_scale_shrinks_by_6_7_percent_at_the_edge_and_9_5_percent_in_the_corner() {
    // Millimetres under one pixel's step outward: the same script, its derivative by differences.
    let view = paper_view();
    let step = |pixel: [f64; 2], toward: [f64; 2]| {
        let a = view.touched_from_pixel([pixel[0] - toward[0], pixel[1] - toward[1]]).unwrap();
        let b = view.touched_from_pixel([pixel[0] + toward[0], pixel[1] + toward[1]]).unwrap();
        1.0 - (b[0] - a[0]).hypot(b[1] - a[1]) / 2.0 / view.mm_per_pixel()
    };
    let diagonal = 696f64.hypot(521.0);
    let corner = step([1392.0, 0.0], [696.0 / diagonal, -521.0 / diagonal]);
    assert!((step([1392.0, 521.0], [1.0, 0.0]) - 0.06688).abs() < 1e-5);
    assert!((corner - 0.09513).abs() < 1e-5, "{corner}");
}

#[test]
fn image_plane_and_touched_face_map_back_and_forth() {
    let view = paper_view();
    for pixel in [[0.5, 0.5], [696.0, 521.0], [1391.5, 1041.5], [100.25, 900.75], [696.001, 521.0]] {
        let point = view.touched_from_pixel(pixel).unwrap();
        let back = view.pixel_from_touched(point);
        // 1e-12 of 1400 pixels.
        assert!((back[0] - pixel[0]).hypot(back[1] - pixel[1]) < 2e-9, "{pixel:?} {back:?}");
    }
}

#[test]
fn first_pixel_sees_negative_x_and_positive_y() {
    let [x, y] = paper_view().touched_from_pixel([0.5, 0.5]).unwrap();
    assert!(x < 0.0 && y > 0.0, "{x} {y}");
}

#[test]
fn ray_runs_from_the_pinhole_over_every_face_and_obeys_snell() {
    let view = paper_view();
    let ray = view.ray_mm([1200.0, 200.0]);
    assert_eq!(ray.len(), 6);
    assert_eq!(ray[0], [0.0, 0.0, -17.32]);
    let sine = |a: [f64; 3], b: [f64; 3]| {
        let r = (b[0] - a[0]).hypot(b[1] - a[1]);
        r / r.hypot(b[2] - a[2])
    };
    let invariant = sine(ray[0], ray[1]);
    for (segment, n) in ray[1..].windows(2).zip([1.38, 1.39, 1.40, 1.41]) {
        // Coordinates of some 10 mm: differences keep 14 digits.
        assert!((n * sine(segment[0], segment[1]) - invariant).abs() < 1e-13);
    }
    let seen = view.touched_from_pixel([1200.0, 200.0]).unwrap();
    assert!((ray[5][0] - seen[0]).hypot(ray[5][1] - seen[1]) < 1e-12);
}

#[test]
fn total_reflection_below_a_thinner_medium_is_reported_and_inverted_from_inside() {
    // Camera in water under an air gap: critical angle 48.75 degrees, the corner looks beyond it.
    let mut wide = camera(ViewAxis::Width);
    wide.view_angle_deg = 120.0;
    let view = View::new(&wide, &[(1.41, 2.0), (1.0, 1.0)], 1.33).unwrap();
    assert_eq!(view.touched_from_pixel([0.0, 521.0]), None);
    let far = view.pixel_from_touched([500.0, 0.0]);
    let back = view.touched_from_pixel(far).unwrap();
    // Close to the critical angle r changes fast: 1e-15 of t is amplified by dr/dt * t / r, below 1e6 here.
    assert!((back[0] / 500.0 - 1.0).abs() < 1e-8, "{back:?}");
}

#[test]
fn view_angle_spans_the_named_axis() {
    let tangent = |axis, extent: f64| 0.5 * extent / focal_px(&camera(axis)).unwrap();
    let expected = 30f64.to_radians().tan();
    assert!((tangent(ViewAxis::Width, 1392.0) - expected).abs() < 1e-14);
    assert!((tangent(ViewAxis::Height, 1042.0) - expected).abs() < 1e-14);
    assert!((tangent(ViewAxis::Diagonal, 1392f64.hypot(1042.0)) - expected).abs() < 1e-14);
}

#[test]
fn impossible_geometry_is_a_typed_error() {
    let good = camera(ViewAxis::Width);
    let with = |change: fn(&mut Camera)| {
        let mut c = good.clone();
        change(&mut c);
        View::new(&c, &PAPER, 1.0).unwrap_err()
    };
    assert!(matches!(with(|c| c.pixels = [0, 5]), ProjectionError::NoPixels { .. }));
    assert!(matches!(with(|c| c.view_angle_deg = 180.0), ProjectionError::ViewAngle(_)));
    assert!(matches!(with(|c| c.view_angle_deg = f64::NAN), ProjectionError::ViewAngle(_)));
    assert!(matches!(with(|c| c.distance_mm = 0.0), ProjectionError::Distance(_)));
    assert!(matches!(View::new(&good, &[(0.5, 1.0)], 1.0), Err(ProjectionError::Layer { index: 0, .. })));
    assert!(matches!(View::new(&good, &PAPER, f64::NAN), Err(ProjectionError::Surround(_))));
}
