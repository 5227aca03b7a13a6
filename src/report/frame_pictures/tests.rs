use super::super::svg::{assert_well_formed, keep_sample};
use super::*;
use crate::mechanics::frames::{Reference, Settings, features};

/// A round indenter scanned over a lump: a parabola that rises and narrows near it, and leans towards it.
fn scan(lump: f64) -> Frames {
    let x_mm: Vec<f64> = (-40..=40).map(|i| 0.4 * f64::from(i)).collect();
    let pressure = |s: f64, x: f64| {
        let (near, from_lump) = ((-s * s / 60.0).exp(), x + s);
        let tissue = (5.5 - 0.045 * x * x * (1.0 + 0.2 * lump * near)).max(0.0);
        let bump = 3.4 * lump * (-from_lump * from_lump / 24.0).exp();
        if tissue > 0.0 { tissue + bump * (1.0 - x * x / 256.0).max(0.0) } else { 0.0 }
    };
    let frame = |s: i32| {
        let position_mm = f64::from(s);
        Frame {
            position_mm,
            pressure_kpa: x_mm.iter().map(|&x| pressure(position_mm, x)).collect(),
            x_mm: x_mm.clone(),
        }
    };
    Frames::new((-20..=20).map(frame).collect()).unwrap()
}

#[test]
fn the_image_has_a_stripe_for_each_frame_and_units() {
    let svg = frames_image("Pressure frames", &scan(1.0), true).unwrap();
    assert_well_formed(&svg);
    for text in ["pressure (kPa)", "place along the indenter (mm)", "position of the indenter (mm)"] {
        assert!(svg.contains(&format!(">{text}<")), "{text}");
    }
    keep_sample("frames.svg", &svg);
    assert_eq!(stripe_bounds(&scan(1.0).as_slice()[..3]), [-20.5, -19.5, -18.5, -17.5]);
    assert_eq!(stripe_bounds(&scan(1.0).as_slice()[..1]), [-20.5, -19.5]);
}

#[test]
fn the_lowest_position_is_at_the_bottom() {
    let all = scan(1.0);
    let frames = &all.as_slice()[..2];
    let axes = Axes { area: [0.0, 0.0, 1.0, 1.0], low: [-16.0, -20.5], high: [16.0, -18.5] };
    let mut frames = frames.to_vec();
    frames[0].pressure_kpa.fill(0.0);
    frames[1].pressure_kpa.fill(1.0);
    let rgb = stripes(&frames, &axes, &stripe_bounds(&frames), [0.0, 1.0]);
    assert_eq!(rgb.len(), 3 * BITMAP[0] * BITMAP[1]);
    assert_eq!((&rgb[..3], &rgb[rgb.len() - 3..]), (&false_color::color(1.0)[..], &false_color::color(0.0)[..]));
}

#[test]
fn one_frame_shows_what_was_read_off_it() {
    let (with, without) = (scan(1.0), scan(0.0));
    let settings = Settings { window_mm: Some(9.0), ..Settings::default() };
    let all = features(&with, Reference::Without(&without), &settings).unwrap();
    let i = 16;
    let (frame, reference) = (&with.as_slice()[i], &without.as_slice()[i]);
    let svg = frame_picture(&FramePicture { title: "One frame", frame, reference, features: &all[i] }).unwrap();
    assert_well_formed(&svg);
    for text in [">peak ", ">base ", ">FWHM ", "eccentricity 0.", ">fitted parabola<"] {
        assert!(svg.contains(text), "{text}");
    }
    keep_sample("frame.svg", &svg);
}

#[test]
fn a_frame_without_features_is_drawn_without_them() {
    let x_mm = vec![-1.0, 0.0, 1.0];
    let untouched = Frame { position_mm: 0.0, pressure_kpa: vec![0.0; 3], x_mm };
    let frames = Frames::new(vec![untouched]).unwrap();
    let all = features(&frames, Reference::Farthest, &Settings::default()).unwrap();
    let frame = &frames.as_slice()[0];
    let svg = frame_picture(&FramePicture { title: "a", frame, reference: frame, features: &all[0] }).unwrap();
    assert_well_formed(&svg);
    assert!(!svg.contains(">peak ") && !svg.contains(">fitted parabola<"));
    assert_well_formed(&frames_image("a", &frames, false).unwrap());
    let other = Frame { x_mm: vec![-1.0, 0.1, 1.0], ..frame.clone() };
    assert!(frame_picture(&FramePicture { title: "a", frame, reference: &other, features: &all[0] }).is_err());
}
